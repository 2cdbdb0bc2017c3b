"""Marks as they leave the house: before and after what lateness costs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import timedelta
from pathlib import Path

from robust_slam_autograder.errors import WrongUse
from robust_slam_autograder.grading.results import tidy
from robust_slam_autograder.lms import handed_in
from robust_slam_autograder.lms.handed_in import HandedIn, Undated
from robust_slam_autograder.lms.late import Rules, as_utc
from robust_slam_autograder.nbgrader.totals import Total, Totals
from robust_slam_autograder.reading.assignment import Assignment

DIGITS = 2
"""Both systems show two, and Canvas compares no more."""


@dataclass(frozen=True)
class Mark:
    """One submission's mark."""

    before: float
    """As in the gradebook."""
    after: float
    """As exported."""
    waits: bool
    """Whether a person has still to mark something."""
    handed_in: HandedIn | None = None
    """Where there is a late policy."""
    late: timedelta = timedelta()
    """Time after the due time, grace included."""


@dataclass(frozen=True)
class Column:
    """One assignment's marks, by student."""

    name: str
    title: str
    """As ``autograder.toml`` has it; empty where it has none."""
    max_score: float
    marks: Mapping[str, Mark]
    undated: Mapping[str, str]
    """Students whose lateness is unknown, with the reason: they have no mark here."""


def column(
    assignment: Assignment, totals: Totals, *, rules: Rules | None, submitted: Path
) -> Column:
    """Return an assignment's marks, after the late policy where there is one.

    Args:
        assignment: whose.
        totals: what the gradebook says.
        rules: the late policy; None leaves what nbgrader itself has taken off.
        submitted: where ``<student>/<assignment>/`` are; looked at for the policy alone.

    Raises:
        WrongUse: a due time is missing, no submission says when it was handed in, or nbgrader
            has taken something off already.
    """
    marks: dict[str, Mark] = {}
    undated: dict[str, str] = {}
    for student, total in totals.students.items():
        if rules is None:
            marks[student] = _as_recorded(total)
            continue
        try:
            marks[student] = _judged(
                student, assignment, totals.max_score, total, rules, submitted
            )
        except Undated as error:
            undated[student] = str(error)
    if undated and not marks:
        raise WrongUse(next(iter(undated.values())))
    most = tidy(totals.max_score)
    return Column(assignment.name, assignment.config.title, most, marks, undated)


def rounded(points: float) -> float:
    """Return points to two digits, whole ones as an int."""
    return tidy(round(points, DIGITS))


def _as_recorded(total: Total) -> Mark:
    after = max(0.0, total.score - total.penalty)
    return Mark(rounded(total.score), rounded(after), total.waits)


def _judged(
    student: str,
    assignment: Assignment,
    max_score: float,
    total: Total,
    rules: Rules,
    submitted: Path,
) -> Mark:
    if total.penalty:
        raise WrongUse(
            f"nbgrader's own late policy has taken {total.penalty:g} points off "
            f"{student}/{assignment.name}: export without --late, or take it out of nbgrader."
        )
    at = handed_in.when(submitted / student / assignment.name, assignment.notebook)
    due = rules.due_for(assignment.name, student)
    late = timedelta() if due is None else max(timedelta(), as_utc(at.at) - as_utc(due))
    after = max(0.0, total.score - rules.policy.penalty(late, max_score))
    return Mark(rounded(total.score), rounded(after), total.waits, at, late)
