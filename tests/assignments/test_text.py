"""Each assignment's own text says all that somebody needs who has nothing but the zip."""

from __future__ import annotations

import pytest

from tests.assignments import answers


@pytest.mark.parametrize("name", answers.assignments())
def test_the_first_and_the_last_cell_say_how_to_check(name: str) -> None:
    first, *_, last = answers.source_notebook(name)["cells"]
    command = f"`autograder check {name}.ipynb`"
    assert command in "".join(first["source"])
    assert command in "".join(last["source"])
    assert "hand in this one file" in "".join(last["source"])


@pytest.mark.parametrize("name", answers.assignments())
def test_a_picture_stands_below_every_exercise(name: str) -> None:
    cells = answers.source_notebook(name)["cells"]
    fields = [(cell["id"], cell["metadata"].get("nbgrader", {})) for cell in cells]
    exercises = [one["grade_id"] for _, one in fields if one.get("solution")]
    pictures = [known.removeprefix("picture-") for known, _ in fields if "picture-" in known]
    assert exercises == pictures
    assert "picture" in "".join(cells[0]["source"])
