"""A notebook is read as plain cells, or refused in one sentence."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from robust_slam_autograder import notebook
from robust_slam_autograder.errors import Refused
from robust_slam_autograder.notebook import Cell

from tests.autograder import toy

JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(), inner, max_size=4),
    max_leaves=10,
)
FIELDS = st.fixed_dictionaries(
    {},
    optional={
        "cell_type": st.sampled_from(["code", "markdown"]) | JSON,
        "source": st.text() | st.lists(st.text()) | JSON,
        "metadata": st.dictionaries(st.just("nbgrader"), JSON) | JSON,
    },
)


def parsed(value: object) -> tuple[Cell, ...] | str:
    try:
        return notebook.parse(json.dumps(value).encode(), "a.ipynb")
    except Refused as error:
        return str(error)


def check(outcome: tuple[Cell, ...] | str) -> None:
    if isinstance(outcome, str):
        assert "a.ipynb" in outcome and outcome.endswith(".") and "\n" not in outcome
    else:
        assert all(type(cell.source) is str and type(cell.points) is not bool for cell in outcome)


@given(JSON)
def test_arbitrary_json_is_cells_or_refused(value: object) -> None:
    check(parsed(value))


@given(st.lists(FIELDS | JSON, max_size=4), st.sampled_from([4, 3, 4.0, "4", None, [[]], True]))
def test_arbitrary_cells_are_cells_or_refused(cells: list[Any], version: object) -> None:
    check(parsed({"nbformat": version, "cells": cells}))


@given(st.binary())
def test_arbitrary_bytes_are_refused(data: bytes) -> None:
    with pytest.raises(Refused, match=r"a\.ipynb"):
        notebook.parse(data, "a.ipynb")


def test_metadata_of_a_wrong_type_is_as_good_as_none() -> None:
    fields = {"grade_id": 3, "grade": "yes", "solution": 1, "locked": None, "points": True}
    value = toy.notebook([toy.cell("x = 1", "g") | {"metadata": {"nbgrader": fields}}])
    assert parsed(value) == (Cell(kind="code", source="x = 1"),)


def test_a_link_is_not_followed(tmp_path: Path) -> None:
    toy.write(tmp_path / "real.ipynb", toy.answer())
    (tmp_path / "link.ipynb").symlink_to("real.ipynb")
    assert len(notebook.read(tmp_path / "real.ipynb")) == 4
    with pytest.raises(Refused, match="is a link"):
        notebook.read(tmp_path / "link.ipynb")


def test_only_a_regular_file_is_opened_and_nothing_waits(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.ipynb")
    (tmp_path / "folder.ipynb").mkdir()
    for name in ("pipe.ipynb", "folder.ipynb", "missing.ipynb", "a\0b.ipynb"):
        with pytest.raises(Refused):
            notebook.read(tmp_path / name)
    before = len(os.listdir("/proc/self/fd"))
    for _ in range(20):
        with pytest.raises(Refused):
            notebook.read(tmp_path / "folder.ipynb")
    assert len(os.listdir("/proc/self/fd")) == before


def test_a_name_in_a_message_cannot_write_to_the_terminal() -> None:
    assert notebook.shown("a\x1b[2J\nb\udcff.ipynb") == "a?[2J?b?.ipynb"
    assert len(notebook.shown("x" * 500)) == notebook.MAX_NAME


@pytest.mark.parametrize("size", [notebook.MAX_BYTES, notebook.MAX_BYTES + 1])
def test_a_large_file_is_refused_by_its_size(tmp_path: Path, size: int) -> None:
    path = tmp_path / "large.ipynb"
    with open(path, "wb") as file:
        file.truncate(size)
    sentence = "larger than 20 MiB" if size > notebook.MAX_BYTES else "not valid JSON"
    with pytest.raises(Refused, match=sentence):
        notebook.read(path)
