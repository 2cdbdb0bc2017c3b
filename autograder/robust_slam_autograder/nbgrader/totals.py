"""Each student's total in an assignment: in a gradebook, and with new results."""

import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from nbgrader.api import MissingEntry

from robust_slam_autograder.grading.results import Result
from robust_slam_autograder.grading.submissions import Submission
from robust_slam_autograder.nbgrader import database, gradebook
from robust_slam_autograder.nbgrader.database import Location


@dataclass(frozen=True)
class Total:
    """One submission's points."""

    score: float
    """All of them; where a person entered a score, it counts in place of the tests'."""
    by_tests: float
    """Those of the tests alone."""
    waits: bool
    """Whether a person has still to mark or to look at something."""
    penalty: float
    """What nbgrader's own late policy takes off."""


@dataclass(frozen=True)
class Totals:
    """All submissions of one assignment."""

    max_score: float
    students: Mapping[str, Total]


def read(location: Location, assignment: str) -> Totals:
    """Read an assignment's totals; an assignment that is not there has no students.

    The gradebook must be there: nbgrader would make one.

    Raises:
        GraderFailure: it is no gradebook.
    """
    with gradebook.opened(location) as book:
        try:
            max_score = book.find_assignment(assignment).max_score
        except MissingEntry:
            return Totals(0, {})
        return Totals(
            max_score,
            {
                one.student_id: Total(
                    one.score,
                    sum(row.auto_score or 0 for each in one.notebooks for row in each.grades),
                    one.needs_manual_grade,
                    one.late_submission_penalty or 0,
                )
                for one in book.assignment_submissions(assignment)
            },
        )


@dataclass(frozen=True)
class Effect:
    """What becomes of one student's total; None where there is none yet."""

    before: Total | None
    after: Total


def effects(
    location: Location, assignment: str, new: Sequence[tuple[Submission, Result]]
) -> dict[str, Effect]:
    """Return by student every total that would change, and who would then wait for a person.

    A cell that was deleted takes its marks along, from students too who are not graded again.
    Where there is no gradebook all totals are new.

    Raises:
        GraderFailure: it is no gradebook.
    """
    if not new:
        return {}
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder, "gradebook.db")
        database.copy(location, copy)
        before = read(copy, assignment).students
        tests = [job.assignment for job, _ in new[:1]]
        gradebook.record(copy, tests, [result for _, result in new])
        after = read(copy, assignment).students
    pairs = {student: Effect(before.get(student), total) for student, total in after.items()}
    return {student: pair for student, pair in pairs.items() if _differs(pair)}


def _differs(pair: Effect) -> bool:
    old = pair.before
    return old is None or (old.score, old.waits) != (pair.after.score, pair.after.waits)
