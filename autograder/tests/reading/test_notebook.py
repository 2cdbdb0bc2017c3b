"""A notebook is read as plain cells, or refused in one sentence."""

import json
import os

import pytest
from robust_slam_autograder.errors import Refused
from robust_slam_autograder.reading import notebook
from robust_slam_autograder.reading.notebook import Cell

from .. import toy


def parsed(value: object) -> tuple[Cell, ...] | str:
    try:
        return notebook.parse(json.dumps(value).encode(), "a.ipynb")
    except Refused as error:
        return str(error)


def test_metadata_of_a_wrong_type_is_as_good_as_none():
    fields = {"grade_id": 3, "grade": "yes", "solution": 1, "locked": None, "points": True}
    value = toy.notebook([toy.cell("x = 1", "g") | {"metadata": {"nbgrader": fields}}])
    assert parsed(value) == (Cell(kind="code", source="x = 1"),)


@pytest.mark.parametrize("points", [float("nan"), float("inf"), 10**400, "3", None, [1]])
def test_points_are_a_number_or_none(points):
    cells = parsed(toy.notebook([toy.test_cell("pass\n", "g", points)]))
    assert isinstance(cells, tuple) and cells[0].points == 0


def test_a_notebook_of_too_many_values_is_refused():
    value = toy.answer()
    value["cells"][0]["outputs"] = [0] * notebook.MAX_VALUES
    assert "holds more than 1,000,000 values: clear its outputs" in parsed(value)
    value["cells"][0]["outputs"] = [0] * (notebook.MAX_VALUES // 2)
    assert parsed(value) == parsed(toy.answer())


def test_only_a_regular_file_is_opened_and_nothing_waits(tmp_path):
    toy.write(tmp_path / "real.ipynb", toy.answer())
    (tmp_path / "link.ipynb").symlink_to("real.ipynb")
    os.mkfifo(tmp_path / "pipe.ipynb")
    (tmp_path / "folder.ipynb").mkdir()
    assert len(notebook.read(tmp_path / "real.ipynb")) == 4
    before = len(os.listdir("/proc/self/fd"))
    no_file = dict.fromkeys(("pipe", "folder"), "is not a regular file: hand in the notebook")
    cut = f"^.{{1,{notebook.MAX_NAME}}} cannot be opened"
    unopened = dict.fromkeys(("missing", "a\0b", "x" * 500), cut)
    for name, why in (no_file | unopened | {"link": "it is a link"}).items():
        for _ in range(20):
            with pytest.raises(Refused, match=why):
                notebook.read(tmp_path / f"{name}.ipynb")
    assert len(os.listdir("/proc/self/fd")) == before


@pytest.mark.parametrize("size", [notebook.MAX_BYTES, notebook.MAX_BYTES + 1])
def test_a_large_file_is_refused_by_its_size(tmp_path, size):
    path = tmp_path / "large.ipynb"
    with open(path, "wb") as file:
        file.truncate(size)
    sentence = "larger than 20 MiB" if size > notebook.MAX_BYTES else "not valid JSON"
    with pytest.raises(Refused, match=sentence):
        notebook.read(path)
