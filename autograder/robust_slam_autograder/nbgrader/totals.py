"""What a gradebook says of an assignment: each student's total, with what a person gave."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from nbgrader.api import MissingEntry

from robust_slam_autograder.nbgrader import gradebook
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

    Args:
        location: the gradebook, which must be there: nbgrader would make one.
        assignment: its name.

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
