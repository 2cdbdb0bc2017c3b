"""What new results would make of a gradebook, tried on a copy of it."""

from __future__ import annotations

import contextlib
import sqlite3
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from robust_slam_autograder.errors import GraderFailure
from robust_slam_autograder.grading.batch import Job
from robust_slam_autograder.grading.results import Result
from robust_slam_autograder.nbgrader import gradebook, graded_notebook, totals
from robust_slam_autograder.nbgrader.totals import Total


@dataclass(frozen=True)
class Effect:
    """What becomes of one student's total; None where there is none yet."""

    before: Total | None
    after: Total


def effects(
    database: Path, assignment: str, new: Sequence[tuple[Job, Result]]
) -> dict[str, Effect]:
    """By student every total that would change, and who would then wait for a person.

    A cell that was deleted takes its marks along, from students too who are not graded again.

    Args:
        database: the gradebook; where there is none, all totals are new.
        assignment: its name.
        new: submissions with their results.

    Raises:
        GraderFailure: the file is no gradebook.
    """
    if not new:
        return {}
    with _copied(database) as copy:
        before = totals.read(copy, assignment).students
        blank = {job.key: graded_notebook.unanswered(job) for job, _ in new}
        tests = [job.assignment for job, _ in new[:1]]
        gradebook.record(copy, tests, [result for _, result in new], blank)
        after = totals.read(copy, assignment).students
    pairs = {student: Effect(before.get(student), total) for student, total in after.items()}
    return {student: pair for student, pair in pairs.items() if _differs(pair)}


def _differs(pair: Effect) -> bool:
    old = pair.before
    return old is None or (old.score, old.waits) != (pair.after.score, pair.after.waits)


@contextlib.contextmanager
def _copied(database: Path) -> Iterator[Path]:
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder, database.name)
        if database.exists():
            _copy(database, copy)
        yield copy


def _copy(database: Path, copy: Path) -> None:
    """Copy with what SQLite keeps beside the file."""
    address = f"{database.absolute().as_uri()}?mode=ro"
    try:
        with (
            contextlib.closing(sqlite3.connect(address, uri=True)) as old,
            contextlib.closing(sqlite3.connect(copy)) as new,
        ):
            old.backup(new)
    except sqlite3.Error as error:
        raise GraderFailure(f"The gradebook {database} cannot be read: {error}.") from error
