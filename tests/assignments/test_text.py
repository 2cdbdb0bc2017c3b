"""Each assignment's own text says all that somebody needs who has nothing but the zip."""

from __future__ import annotations

import ast
import itertools
import re

import pytest
from robust_slam_autograder.reading import assignment as assignment_module

from tests.assignments import answers

NUMBERS = ("No", "One", "Two", "Three", "Four", "Five", "Six", "Seven", "Eight", "Nine", "Ten")
NAMES = answers.assignments()


def cells(name: str) -> list[dict[str, object]]:
    """Return the cells of an assignment, each with its text in one piece."""
    found = answers.source_notebook(name)["cells"]
    return [cell | {"source": "".join(cell["source"])} for cell in found]


@pytest.mark.parametrize("name", NAMES)
def test_the_first_and_the_last_cell_say_what_to_do(name: str) -> None:
    assignment = assignment_module.load(answers.SOLUTIONS / name / f"{name}.ipynb")
    first, *_, last = (cell["source"] for cell in cells(name))
    command = f"`autograder check {name}.ipynb`"
    assert command in first and command in last
    assert "hand in this one file" in last
    assert f"{NUMBERS[len(assignment.exercises)]} exercises, ten points each." in first
    assert "The first one draws a picture of what your function does" in first
    for exercise in assignment.exercises:
        mine = [case.points for case in assignment.cases if case.exercise == exercise]
        assert sum(mine) == 10, exercise


@pytest.mark.parametrize("name", NAMES)
def test_a_picture_that_replaces_no_students_function_comes_before_the_checks(name: str) -> None:
    assignment = assignment_module.load(answers.SOLUTIONS / name / f"{name}.ipynb")
    defined = {each for solution in assignment.solutions for each in solution.names}
    for cell, below in itertools.pairwise(cells(name)):
        field = cell["metadata"].get("nbgrader", {})
        if field.get("solution"):
            assert below["id"] == f"picture-{field['grade_id']}"
            nodes = ast.walk(ast.parse(below["source"]))
            imports = [node for node in nodes if isinstance(node, ast.Import | ast.ImportFrom)]
            imported = {alias.asname or alias.name for node in imports for alias in node.names}
            assert imported and not defined & imported, field["grade_id"]


def test_every_set_up_compares_by_the_same_close() -> None:
    setups = [one for name in NAMES for one in cells(name) if one["id"] == "setup"]
    nodes = [node for one in setups for node in ast.parse(one["source"]).body]
    found = [ast.unparse(node) for node in nodes if getattr(node, "name", "") == "close"]
    assert len(found) == len(NAMES) and len(set(found)) == 1


@pytest.mark.parametrize("name", NAMES)
def test_no_visible_check_hides_a_value_behind_a_difference(name: str) -> None:
    """`abs(x - 1) is 0.65` does not tell the student what x is; `close` shows it."""
    assignment = assignment_module.load(answers.SOLUTIONS / name / f"{name}.ipynb")
    for case in assignment.cases:
        tests = [
            node.test for node in ast.walk(ast.parse(case.visible)) if isinstance(node, ast.Assert)
        ]
        calls = [node for test in tests for node in ast.walk(test) if isinstance(node, ast.Call)]
        sizes = [node for node in calls if ast.unparse(node.func).endswith(("abs", "norm"))]
        hidden = [node for node in sizes if isinstance(node.args[0], ast.BinOp)]
        assert not [ast.unparse(node) for node in hidden if isinstance(node.args[0].op, ast.Sub)]


@pytest.mark.parametrize("name", answers.assignments())
def test_a_misconception_goes_on_after_it_looks_as_if_your_function(name: str) -> None:
    wrong = [one for one in answers.answers(name) if not one.is_right]
    # A label is read by itself, where no pronoun has anything to stand for.
    first = re.compile(r"(Never [a-z]+s|[A-Z][a-z]+s) (?!(only )?(it|them|both|those|all of)\b)")
    assert [one.story for one in wrong if not first.match(one.story)] == []
    assert [one.story for one in wrong if not one.story.endswith(".")] == []
