"""Each assignment's own text says all that somebody needs who has nothing but the zip."""

import ast

import pytest

from solutions.classes import answers
from tests.assignments import reference

NAMES = answers.assignments()


def cells(name: str) -> list[dict[str, object]]:
    """Return the cells of an assignment, each with its text in one piece."""
    found = answers.source_notebook(name)["cells"]
    return [cell | {"source": "".join(cell["source"])} for cell in found]


@pytest.mark.parametrize("name", NAMES)
def test_the_first_and_the_last_cell_say_what_to_do(name):
    first, *_, last = (cell["source"] for cell in cells(name))
    command = f"`autograder check {name}.ipynb`"
    assert command in first and command in last
    assert "hand in this one file" in last
    assert "exercises, ten points each." in first
    assert "The first one draws a picture of what your function does" in first


def test_every_set_up_compares_by_the_same_close():
    setups = [one for name in NAMES for one in cells(name) if one["id"] == "setup"]
    nodes = [node for one in setups for node in ast.parse(one["source"]).body]
    found = [ast.unparse(node) for node in nodes if getattr(node, "name", "") == "close"]
    assert len(found) == len(NAMES) and len(set(found)) == 1


@pytest.mark.parametrize(
    ("exercise", "formula"),
    [
        ("gnc_tls_weight", "c√(μ(μ+1)) - μu"),
        ("gnc_gm_weight", "u(μc²)²/(μc² + u²)²"),
        ("start_mu", "(μ+1)/μ = 2"),
    ],
)
def test_what_is_to_be_derived_is_the_last_hint_and_in_no_visible_check(exercise, formula):
    assignment = reference.load("05-gnc").assignment
    hints = assignment.config.hints[exercise]
    assert [formula in hint for hint in hints] == [False, False, True]
    assert not [case.name for case in assignment.cases if formula in case.visible]
