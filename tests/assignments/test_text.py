"""Each assignment's own text says all that somebody needs who has nothing but the zip."""

from __future__ import annotations

import ast
import itertools

import pytest
from robust_slam_autograder.reading import assignment as assignment_module
from robust_slam_autograder.reading.assignment import Assignment

from tests.assignments import answers

NUMBERS = ("No", "One", "Two", "Three", "Four", "Five", "Six", "Seven", "Eight", "Nine", "Ten")
NAMES = answers.assignments()


def load(name: str) -> Assignment:
    return assignment_module.load(answers.SOLUTIONS / name / f"{name}.ipynb")


@pytest.mark.parametrize("name", NAMES)
def test_the_first_and_the_last_cell_say_how_to_check(name: str) -> None:
    first, *_, last = answers.source_notebook(name)["cells"]
    command = f"`autograder check {name}.ipynb`"
    assert command in "".join(first["source"])
    assert command in "".join(last["source"])
    assert "hand in this one file" in "".join(last["source"])


@pytest.mark.parametrize("name", NAMES)
def test_the_picture_of_an_exercise_comes_before_its_checks(name: str) -> None:
    first, *cells = answers.source_notebook(name)["cells"]
    fields = [(cell["id"], cell["metadata"].get("nbgrader", {})) for cell in cells]
    for (_, solution), (below, _) in itertools.pairwise(fields):
        if solution.get("solution"):
            assert below == f"picture-{solution['grade_id']}"
    assert "The first one draws a picture of what your function does" in "".join(first["source"])


@pytest.mark.parametrize("name", NAMES)
def test_the_first_cell_says_how_many_exercises_there_are(name: str) -> None:
    first = "".join(answers.source_notebook(name)["cells"][0]["source"])
    assert f"{NUMBERS[len(load(name).exercises)]} exercises, ten points each." in first


def test_every_set_up_compares_by_the_same_close() -> None:
    sources = ["".join(answers.source_notebook(name)["cells"][1]["source"]) for name in NAMES]
    nodes = [node for text in sources for node in ast.parse(text).body]
    found = [ast.unparse(node) for node in nodes if getattr(node, "name", "") == "close"]
    assert len(found) == len(NAMES) and len(set(found)) == 1
