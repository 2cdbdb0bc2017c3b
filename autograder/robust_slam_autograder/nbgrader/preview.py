"""What new results would make of a gradebook, tried on a copy of it."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from robust_slam_autograder.grading.results import Result
from robust_slam_autograder.grading.tasks import Job
from robust_slam_autograder.nbgrader import database, gradebook, totals
from robust_slam_autograder.nbgrader.database import Location
from robust_slam_autograder.nbgrader.totals import Total


@dataclass(frozen=True)
class Effect:
    """What becomes of one student's total; None where there is none yet."""

    before: Total | None
    after: Total


def effects(
    location: Location, assignment: str, new: Sequence[tuple[Job, Result]]
) -> dict[str, Effect]:
    """Return by student every total that would change, and who would then wait for a person.

    A cell that was deleted takes its marks along, from students too who are not graded again.

    Args:
        location: the gradebook; if it does not exist, all totals are new.
        assignment: its name.
        new: submissions with their results.

    Raises:
        GraderFailure: it is no gradebook.
    """
    if not new:
        return {}
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder, "gradebook.db")
        database.copy(location, copy)
        before = totals.read(copy, assignment).students
        tests = [job.assignment for job, _ in new[:1]]
        gradebook.record(copy, tests, [result for _, result in new])
        after = totals.read(copy, assignment).students
    pairs = {student: Effect(before.get(student), total) for student, total in after.items()}
    return {student: pair for student, pair in pairs.items() if _differs(pair)}


def _differs(pair: Effect) -> bool:
    old = pair.before
    return old is None or (old.score, old.waits) != (pair.after.score, pair.after.waits)
