"""A small course for nbgrader: tests, a free-text answer and a task; and what it does with it."""

import subprocess
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from nbgrader.api import Gradebook
from nbgrader.converters.base import BaseConverter
from nbgrader.coursedir import CourseDirectory
from robust_slam_autograder.grading.results import CaseResult, Ending, Result
from robust_slam_autograder.nbgrader.database import Location, url_of
from robust_slam_autograder.nbgrader.settings import nbgrader_settings
from robust_slam_autograder.reading.assignment import Assignment

from .. import toy
from ..as_user import GRADER, SCRIPTS, ended, nothing_set_up
from ..reports import samples

SEED = 4711
PATIENCE_SECONDS = 1800
"""How long a command may take: much longer than it does on a busy machine."""
FULL = [4.0, 6.0, 5.0, 5.0]
"""Full points in the toy's cases."""
SCHEME = "canary-of-the-marking-scheme"
WHY = "Why twice?\n### BEGIN SOLUTION\nBecause canary-of-the-answer.\n### END SOLUTION"
DRAW = f"Draw it.\n=== BEGIN MARK SCHEME ===\n{SCHEME}\n=== END MARK SCHEME ==="
RELEASED_WHY = "Why twice?\nYOUR ANSWER HERE"


def text_cell(source: str, grade_id: str, **fields: Any) -> dict[str, Any]:
    made = toy.cell(source, grade_id, **fields)
    return {key: made[key] for key in ("id", "metadata", "source")} | {"cell_type": "markdown"}


def free_text(source: str = WHY, points: int = 3) -> dict[str, Any]:
    """The free-text cell; its points are the instructor's to say."""
    return text_cell(source, "why", grade=True, solution=True, points=points)


def task(source: str = DRAW) -> dict[str, Any]:
    return text_cell(source, "draw", task=True, locked=True, points=2)


def source_notebook() -> dict[str, Any]:
    """The toy's notebook, with five points more that a person gives."""
    value = toy.source_notebook()
    value["cells"].insert(4, free_text())
    value["cells"].append(task())
    return value


def answer(text: str = "Because.", **sources: str) -> dict[str, Any]:
    """A submission with a free-text answer, whose metadata asks for more than it is worth."""
    value = toy.answer(**sources)
    value["cells"].append(free_text(text, points=300))
    return value


def with_text() -> Assignment:
    """The assignment that a person marks a part of."""
    return toy.assignment(value=source_notebook())


def marked(student: str, earned: Sequence[float], tests: Assignment | None = None) -> Result:
    """A student's result, with these points for the cases."""
    tests = tests or toy.assignment()
    cases: dict[str, list[CaseResult]] = {name: [] for name in tests.exercises}
    for case, points in zip(tests.cases, earned, strict=True):
        ending = Ending.PASSED if points == case.points else Ending.FAILED
        cases[case.exercise].append(CaseResult(case.name, case.points, points, True, ending, ""))
    exercises = [samples.exercise(name, "passed", *each) for name, each in cases.items()]
    return replace(samples.result(*exercises, student=student), assignment=tests.name, seconds=0)


def make(folder: Path) -> Path:
    """A course's root with the source tree; the configuration stays in the grader's folder."""
    path = toy.make_tree(folder, "[limits]\ncall_seconds = 0.4\ncell_seconds = 2\n") / toy.NAME
    toy.write(path / f"{toy.NAME}.ipynb", source_notebook())
    return folder


def hand_in(course: Path, student: str, value: dict[str, Any]) -> Path:
    return toy.hand_in(course / "class" / "submitted", student, value)


def environment(course: Path) -> dict[str, str]:
    """Variables for a user who has nothing set up but the course."""
    home = course / "home"
    home.mkdir(exist_ok=True)
    return nothing_set_up(home) | {"JUPYTER_CONFIG_PATH": str(GRADER)}


def run(course: Path, program: str, *arguments: object) -> subprocess.CompletedProcess[str]:
    options = {"cwd": course, "env": environment(course), "timeout": PATIENCE_SECONDS}
    return ended([SCRIPTS / program, *arguments], **options)


def convert(course: Path, step: type[BaseConverter], student: str = "*", **fields: Any) -> None:
    """Do in this process what a button of formgrader's does with the assignment."""
    config = nbgrader_settings(str(course))
    config.CourseDirectory.assignment_id = toy.NAME
    config.CourseDirectory.student_id = student
    config.SafeExporter.update(fields)
    converter = step(coursedir=CourseDirectory(config=config), config=config)
    converter.force = True
    converter.start()


def database(course: Path) -> Path:
    return course / "class" / "graded" / "gradebook.db"


def rows(place: Location, what: str, assignment: str = toy.NAME) -> dict[str, dict[str, Any]]:
    """By student and grade id a column of the marks, or ``comment``."""
    with Gradebook(url_of(place)) as book:
        return {
            submission.student.id: {
                row.name: getattr(row, what)
                for notebook in submission.notebooks
                for row in (notebook.comments if what == "comment" else notebook.grades)
            }
            for submission in book.assignment_submissions(assignment)
        }


def enter(place: Location, student: str, grade_id: str, score: float) -> None:
    """Do what formgrader does where an instructor enters a score."""
    with Gradebook(url_of(place)) as book:
        row = book.find_grade(grade_id, toy.NAME, toy.NAME, student)
        row.manual_score = score
        row.needs_manual_grade = False
        book.db.commit()
