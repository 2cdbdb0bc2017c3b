"""The gradebook holds each case's points once, and follows the instructor's notebook."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from nbgrader.api import Gradebook
from robust_slam_autograder.errors import GraderFailure
from robust_slam_autograder.grading.results import (
    CaseResult,
    ExerciseResult,
    Result,
    without_grade,
)
from robust_slam_autograder.nbgrader import gradebook
from robust_slam_autograder.reading.assignment import Assignment

from tests.autograder import toy
from tests.autograder.nbgrader import course


@pytest.fixture(scope="module")
def empty(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A gradebook with nothing in it: to make one takes nbgrader a second."""
    path = tmp_path_factory.mktemp("empty") / "made" / "gradebook.db"
    gradebook.record(path, [], [])
    return path


@pytest.fixture
def database(empty: Path, tmp_path: Path) -> Path:
    """A gradebook of the test's own."""
    return Path(shutil.copy(empty, tmp_path / "gradebook.db"))


def result(student: str, earned: list[float], tests: Assignment) -> Result:
    cases = [
        (case.exercise, CaseResult(case.name, case.points, points, True, ""))
        for case, points in zip(tests.cases, earned, strict=True)
    ]
    exercises = tuple(
        ExerciseResult(name, 0, 0, "passed", "", tuple(c for e, c in cases if e == name))
        for name in tests.exercises
    )
    score = sum(earned)
    return Result(student, tests.name, score, 20, "graded", "", "none", 0.0, exercises)


def marks(database: Path) -> dict[str, dict[str, float]]:
    with Gradebook(f"sqlite:///{database}") as book:
        return {
            submission.student.id: {grade.name: grade.score for grade in notebook.grades}
            for submission in book.assignment_submissions(toy.NAME)
            for notebook in submission.notebooks
        }


def test_every_case_has_its_points(database: Path) -> None:
    tests = toy.assignment()
    refused = without_grade("refused", "why", student="eve", assignment=tests.name, max_score=20)
    gradebook.record(database, [tests], [result("ada", [4, 0, 5, 5], tests), refused])
    names = [case.grade_id for case in tests.cases]
    assert marks(database) == {
        "ada": dict(zip(names, [4, 0, 5, 5], strict=True)),
        "eve": dict.fromkeys(names, 0),
    }
    with Gradebook(f"sqlite:///{database}") as book:
        assert book.find_assignment(toy.NAME).max_score == 20
        assert book.find_submission(toy.NAME, "ada").score == 14
        assert not book.find_submission(toy.NAME, "ada").needs_manual_grade


def test_marks_are_replaced_and_other_students_stay(database: Path) -> None:
    tests = toy.assignment()
    gradebook.record(database, [tests], [result(s, [0, 0, 0, 0], tests) for s in ("ada", "bob")])
    gradebook.record(database, [tests], [result("ada", [4, 6, 5, 5], tests)])
    assert {student: sum(each.values()) for student, each in marks(database).items()} == {
        "ada": 20,
        "bob": 0,
    }


def test_the_gradebook_follows_the_instructors_cases(database: Path) -> None:
    tests = toy.assignment()
    gradebook.record(database, [tests], [result("ada", [4, 6, 5, 5], tests)])
    value = toy.source_notebook()
    value["cells"][5]["metadata"]["nbgrader"]["grade_id"] = "apply-new"
    fewer = toy.assignment(value=value | {"cells": value["cells"][:6]})
    gradebook.record(database, [fewer], [result("ada", [4, 6, 5], fewer)])
    assert marks(database) == {"ada": {"double-by-hand": 4, "double-random": 6, "apply-new": 5}}


def test_nbgraders_own_gradebook_is_taken_over(database: Path) -> None:
    tests = toy.assignment()
    with Gradebook(f"sqlite:///{database}") as book:
        book.add_assignment(toy.NAME)
        book.add_notebook(toy.NAME, toy.NAME)
        book.add_grade_cell("double-random", toy.NAME, toy.NAME, max_score=1, cell_type="code")
        book.add_student("ada", first_name="Ada")
    gradebook.record(database, [tests], [result("ada", [4, 6, 5, 5], tests)])
    assert sum(marks(database)["ada"].values()) == 20
    with Gradebook(f"sqlite:///{database}") as book:
        assert book.find_student("ada").first_name == "Ada"


def with_text() -> Assignment:
    return toy.assignment(value=course.source_notebook())


def test_what_a_person_marks_is_declared_and_waits(database: Path) -> None:
    tests = with_text()
    gradebook.record(database, [tests], [result("ada", [4, 6, 5, 5], tests)])
    with Gradebook(f"sqlite:///{database}") as book:
        assert book.find_assignment(toy.NAME).max_score == 25
        notebook = book.find_notebook(toy.NAME, toy.NAME)
        assert [cell.max_score for cell in notebook.task_cells] == [2]
        assert {cell.name for cell in notebook.solution_cells} == {"double", "apply", "why"}
        submission = book.find_submission(toy.NAME, "ada")
        assert submission.score == 20 and submission.max_score == 25
        assert submission.needs_manual_grade
    assert course.rows(database, "auto_score")["ada"]["why"] is None


def test_an_answer_that_is_not_there_waits_for_nobody(database: Path) -> None:
    tests = with_text()
    mark = result("ada", [4, 6, 5, 5], tests)
    gradebook.record(database, [tests], [mark], {f"ada/{toy.NAME}": ["why"]})
    assert course.rows(database, "auto_score")["ada"]["why"] == 0
    assert course.rows(database, "comment")["ada"]["why"] == gradebook.NO_ANSWER


def test_what_a_person_entered_is_never_lost(database: Path) -> None:
    tests = with_text()
    gradebook.record(database, [tests], [result("ada", [4, 6, 5, 5], tests)])
    course.enter(database, "ada", "why", 2)
    with Gradebook(f"sqlite:///{database}") as book:
        book.find_comment("why", toy.NAME, toy.NAME, "ada").manual_comment = "Nearly."
        book.db.commit()
    refused = without_grade("refused", "why", student="ada", assignment=tests.name, max_score=20)
    for again in (refused, result("ada", [0, 0, 0, 0], tests)):
        gradebook.record(database, [tests], [again])
        assert marks(database)["ada"]["why"] == 2
        assert course.rows(database, "comment")["ada"]["why"] == "Nearly."


def test_free_text_comes_and_goes_with_the_instructors_notebook(database: Path) -> None:
    tests = with_text()
    gradebook.record(database, [toy.assignment()], [result("ada", [4, 6, 5, 5], tests)])
    gradebook.record(database, [tests], [result("ada", [4, 6, 5, 5], tests)])
    assert marks(database)["ada"].keys() >= {"why", "draw"}
    gradebook.record(database, [toy.assignment()], [result("ada", [4, 6, 5, 5], tests)])
    assert marks(database)["ada"].keys().isdisjoint({"why", "draw"})


def test_a_comment_is_the_exercises_message(database: Path) -> None:
    tests = toy.assignment()
    mark = result("ada", [4, 0, 5, 5], tests)
    double = replace(mark.exercises[0], message="Look at \x1b[31mred.")
    mark = replace(mark, exercises=(double, *mark.exercises[1:]))
    gradebook.record(database, [tests], [mark])
    said = course.rows(database, "comment")["ada"]
    assert said == {"double": "Look at \\x1b[31mred.", "apply": None}


def test_a_region_that_is_not_closed_is_named(database: Path) -> None:
    value = toy.source_notebook()
    value["cells"][1]["source"] = toy.DOUBLE.replace("### END SOLUTION", "")
    with pytest.raises(GraderFailure, match="no end solution statement"):
        gradebook.declare(database, toy.assignment(value=value))


def test_a_file_that_is_no_gradebook_is_named(tmp_path: Path) -> None:
    database = tmp_path / "gradebook.db"
    database.write_text(json.dumps({"no": "gradebook"}) * 100)
    with pytest.raises(GraderFailure, match=r"gradebook\.db cannot be written"):
        gradebook.record(database, [toy.assignment()], [result("a", [0] * 4, toy.assignment())])
