"""Each assignment's own text says all that somebody needs who has nothing but the zip."""

from __future__ import annotations

import ast

import pytest

from tests.assignments import answers

NAMES = answers.assignments()


def cells(name: str) -> list[dict[str, object]]:
    """Return the cells of an assignment, each with its text in one piece."""
    found = answers.source_notebook(name)["cells"]
    return [cell | {"source": "".join(cell["source"])} for cell in found]


@pytest.mark.parametrize("name", NAMES)
def test_the_first_and_the_last_cell_say_what_to_do(name: str) -> None:
    first, *_, last = (cell["source"] for cell in cells(name))
    command = f"`autograder check {name}.ipynb`"
    assert command in first and command in last
    assert "hand in this one file" in last
    assert "exercises, ten points each." in first
    assert "The first one draws a picture of what your function does" in first


def test_every_set_up_compares_by_the_same_close() -> None:
    setups = [one for name in NAMES for one in cells(name) if one["id"] == "setup"]
    nodes = [node for one in setups for node in ast.parse(one["source"]).body]
    found = [ast.unparse(node) for node in nodes if getattr(node, "name", "") == "close"]
    assert len(found) == len(NAMES) and len(set(found)) == 1
