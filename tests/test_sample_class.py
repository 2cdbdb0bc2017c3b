"""The sample class, graded as `make course` grades it."""

from __future__ import annotations

import json
import sqlite3
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from robust_slam_autograder.sandbox import Bubblewrap

from tests import sample_class
from tests.assignments import answers

pytestmark = pytest.mark.sandbox
ASSIGNMENTS = ["02-four-costs", "05-gnc", "09-capstone"]
"""`make course`, which the page *Operate* runs, grades all ten."""


def autograder(*arguments: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "robust_slam_autograder.cli", "--solutions"]
    command += [str(answers.SOLUTIONS), *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)


@pytest.fixture(scope="module")
def graded(tmp_path_factory: pytest.TempPathFactory, bubblewrap: Bubblewrap) -> Path:
    """The class's folder: release, submitted, graded twice with two workers."""
    folder = tmp_path_factory.mktemp("class")
    made = autograder("release", *ASSIGNMENTS, "--out", folder / "release")
    assert made.returncode == 0, made.stderr
    paths = sample_class.write(folder / "release", folder / "submitted", ASSIGNMENTS)
    done = autograder("grade", *paths, "--out", folder / "graded", "--jobs", 2)
    assert done.returncode == 0, done.stderr
    (folder / "first.txt").write_text(done.stdout, encoding="utf-8")
    again = autograder("grade", *paths, "--out", folder / "graded", "--jobs", 2)
    (folder / "second.txt").write_text(again.stdout, encoding="utf-8")
    return folder


def result(graded: Path, student: str, assignment: str) -> dict[str, Any]:
    path = graded / "graded" / student / f"{assignment}.json"
    value: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return value


def lost(value: dict[str, Any]) -> set[str]:
    return {e["name"] for e in value["exercises"] if e["score"] < e["max_score"]}


@pytest.mark.parametrize("assignment", ASSIGNMENTS)
def test_solutions_get_full_marks(graded: Path, assignment: str) -> None:
    value = result(graded, "sample-solutions", assignment)
    assert value["score"] == value["max_score"] > 0
    assert value["sandbox"] in ("fork", "bubblewrap")


@pytest.mark.parametrize("assignment", ASSIGNMENTS)
def test_the_untouched_release_gets_nothing(graded: Path, assignment: str) -> None:
    value = result(graded, "sample-untouched", assignment)
    assert value["score"] == 0 and value["status"] == "graded"
    assert {exercise["status"] for exercise in value["exercises"]} == {"failed"}


@pytest.mark.parametrize("assignment", ASSIGNMENTS)
def test_half_of_the_exercises_get_half_of_the_marks(graded: Path, assignment: str) -> None:
    value = result(graded, "sample-half", assignment)
    done = set(sample_class.half(assignment))
    assert lost(value) == {e["name"] for e in value["exercises"]} - done
    assert value["score"] == 10 * len(done)


@pytest.mark.parametrize("assignment", ASSIGNMENTS)
def test_the_lessons_misprints_lose_their_exercises(graded: Path, assignment: str) -> None:
    typed_in = set(sample_class.misprints(assignment))
    assert lost(result(graded, "sample-misprints", assignment)) == typed_in


def test_the_misprints_of_chapters_two_to_five_are_there() -> None:
    assert set(sample_class.misprints("02-four-costs")) >= {"rho_cauchy", "table", "convex_until"}
    assert set(sample_class.misprints("03-irls")) >= {"irls_step", "irls"}
    for assignment in ("04-non-convexity", "05-gnc"):
        exercises = answers.solution_ids(answers.source_notebook(assignment))
        assert set(sample_class.misprints(assignment)) == set(exercises)


@pytest.mark.parametrize("assignment", ASSIGNMENTS)
def test_a_broken_file_is_refused_in_one_sentence(graded: Path, assignment: str) -> None:
    value = result(graded, "sample-broken", assignment)
    assert value["status"] == "refused" and value["score"] == 0
    assert f"{assignment}.ipynb" in value["reason"]
    assert value["reason"].count(". ") == 0 and value["reason"].endswith(".")


def test_a_second_run_reuses_every_result(graded: Path) -> None:
    first = (graded / "first.txt").read_text(encoding="utf-8")
    second = (graded / "second.txt").read_text(encoding="utf-8")
    number = len(sample_class.STUDENTS) * len(ASSIGNMENTS)
    assert "reused" not in first
    assert f"{number} of them unchanged and reused" in second
    assert first.splitlines()[: number + 1] == second.splitlines()[: number + 1]


def test_the_gradebook_holds_the_same_marks(graded: Path) -> None:
    query = """
        select student_id, assignment.name, sum(auto_score) from grade
        join submitted_notebook on grade.notebook_id = submitted_notebook.id
        join submitted_assignment on submitted_notebook.assignment_id = submitted_assignment.id
        join assignment on submitted_assignment.assignment_id = assignment.id
        group by student_id, assignment.name
    """
    with sqlite3.connect(graded / "graded" / "gradebook.db") as database:
        found = {(student, name): score for student, name, score in database.execute(query)}
    wanted = {
        (student, name): result(graded, student, name)["score"]
        for student in sample_class.STUDENTS
        for name in ASSIGNMENTS
    }
    assert found == wanted
