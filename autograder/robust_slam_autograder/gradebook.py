"""nbgrader's gradebook (SQLite by default): written once per batch, by one writer."""

from __future__ import annotations

import contextlib
import os
import sys
import warnings
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from nbgrader.api import Gradebook
from sqlalchemy.exc import SAWarning, SQLAlchemyError

from robust_slam_autograder.assignment import Assignment
from robust_slam_autograder.errors import GraderFailure
from robust_slam_autograder.results import Result


def record(database: Path, assignments: Sequence[Assignment], marks: Sequence[Result]) -> None:
    """Write results into a gradebook, making assignments and students that are new to it.

    Args:
        database: the SQLite file; made where it is missing.
        assignments: every assignment that a result belongs to.
        marks: results; of a refused one every case earns 0.

    Raises:
        GraderFailure: the file is no gradebook, or cannot be written.
    """
    database.parent.mkdir(parents=True, exist_ok=True)
    known = {assignment.name: assignment for assignment in assignments}
    try:
        with _quiet_nbgrader(), Gradebook(f"sqlite:///{database}") as gradebook:
            for name in dict.fromkeys(result.assignment for result in marks):
                _declare(gradebook, known[name])
            for result in marks:
                _record_one(gradebook, known[result.assignment], result)
    except (SQLAlchemyError, OSError) as error:
        why = str(error).split("\n")[0]
        raise GraderFailure(f"The gradebook {database} cannot be written: {why}") from error


@contextlib.contextmanager
def _quiet_nbgrader() -> Iterator[None]:
    """Let nbgrader find its ``alembic`` command, and keep its own warnings from the terminal."""
    before = os.environ.get("PATH", "")
    # An environment that is not activated does not have its scripts on the path.
    os.environ["PATH"] = os.pathsep.join([str(Path(sys.executable).parent), before])
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", SAWarning)
            yield
    finally:
        os.environ["PATH"] = before


def _declare(gradebook: Gradebook, assignment: Assignment) -> None:
    """Make the assignment and its test cells as the instructor's notebook has them."""
    gradebook.update_or_create_assignment(assignment.name)
    notebook = gradebook.update_or_create_notebook(assignment.notebook, assignment.name)
    wanted = {case.grade_id for case in assignment.cases}
    for cell in list(notebook.grade_cells):
        if cell.name not in wanted:
            _forget(gradebook, cell)
    for case in assignment.cases:
        gradebook.update_or_create_grade_cell(
            case.grade_id,
            assignment.notebook,
            assignment.name,
            max_score=case.points,
            cell_type="code",
        )


def _forget(gradebook: Gradebook, cell: object) -> None:
    """Remove a test cell that the instructor has deleted, with its marks."""
    for grade in list(cell.grades):  # type: ignore[attr-defined]
        gradebook.db.delete(grade)
    gradebook.db.delete(cell)
    gradebook.db.commit()


def _record_one(gradebook: Gradebook, assignment: Assignment, result: Result) -> None:
    gradebook.update_or_create_student(result.student)
    rows = _rows(gradebook, assignment, result.student)
    if not rows.keys() >= {case.grade_id for case in assignment.cases}:
        # A submission from before a test cell was added lacks its row: it is made anew.
        gradebook.remove_submission(assignment.name, result.student)
        rows = _rows(gradebook, assignment, result.student)
    earned = {
        (exercise.name, case.name): case.earned
        for exercise in result.exercises
        for case in exercise.cases
    }
    for case in assignment.cases:
        row = rows[case.grade_id]
        row.auto_score = earned.get((case.exercise, case.name), 0)
        row.needs_manual_grade = False
    gradebook.db.commit()


def _rows(gradebook: Gradebook, assignment: Assignment, student: str) -> dict[str, Any]:
    """A student's marks by grade id, made where there are none."""
    submission = gradebook.update_or_create_submission(assignment.name, student)
    return {grade.name: grade for notebook in submission.notebooks for grade in notebook.grades}
