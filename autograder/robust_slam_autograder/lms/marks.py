"""Marks as they leave the house: before and after what lateness costs, and whose are not known."""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import timedelta
from pathlib import Path
from typing import TYPE_CHECKING

from robust_slam_autograder.errors import WrongUse
from robust_slam_autograder.grading import results
from robust_slam_autograder.grading.results import Result, tidy
from robust_slam_autograder.lms import late
from robust_slam_autograder.lms.late import HandedIn, Rules, Undated
from robust_slam_autograder.reading import assignment as assignments
from robust_slam_autograder.reading.assignment import Assignment

if TYPE_CHECKING:
    from robust_slam_autograder.nbgrader.database import Location
    from robust_slam_autograder.nbgrader.totals import Total, Totals

TOLERANCE = 1e-6
"""Points between a sum here and the same sum in the gradebook."""
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
    handed_in: HandedIn | None
    """Where there is a late policy."""
    late: timedelta
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


@dataclass(frozen=True)
class Ledger:
    """The marks of some assignments."""

    columns: tuple[Column, ...]
    ungraded: tuple[Result, ...]
    """What the grader failed on, which has no mark, and what it refused."""

    @functools.cached_property
    def lost(self) -> frozenset[tuple[str, str]]:
        """Return students and assignments whose mark is not known: they have no 0 either."""
        undated = {(student, column.name) for column in self.columns for student in column.undated}
        failed = {(one.student, one.assignment) for one in self.ungraded if one.status == "failed"}
        return frozenset(failed | undated)


def read(
    tree: Path,
    names: Sequence[str],
    *,
    location: Location,
    out: Path,
    rules: Rules | None,
    submitted: Path,
) -> Ledger:
    """Read marks from the gradebook, which has what a person entered too.

    Where no assignment is named they are all that somebody has handed in. Without rules for late
    work it stays what nbgrader itself has taken off, and submissions are not looked at.

    Raises:
        WrongUse: there are no marks, or not of all results; or, with rules, a due time is missing,
            no submission says when it was handed in, or nbgrader has taken something off already.
    """
    from robust_slam_autograder.nbgrader import database, totals  # these take a second to import

    database.refuse_missing(location)
    columns: list[Column] = []
    ungraded: list[Result] = []
    for name in assignments.find_names(tree, names):
        recorded = totals.read(location, name)
        ungraded += (others := _ungraded(out, name, recorded.students))
        broken = {one.student for one in others if one.status == "failed"}
        known = {name: one for name, one in recorded.students.items() if name not in broken}
        if known:
            tests = assignments.of(tree, name)
            columns.append(_column(tests, replace(recorded, students=known), rules, submitted))
        elif name in names:
            raise WrongUse(f"{out} has no mark of {name}: grade it first, or say --out DIR.")
    return Ledger(tuple(columns), tuple(ungraded))


def _ungraded(out: Path, name: str, recorded: Mapping[str, Total]) -> list[Result]:
    """Return what failed or was refused; a mark that the former have is an old one.

    Raises:
        WrongUse: a result is not in the gradebook as it is, for grading was stopped.
    """
    found = [results.read_checked(path) for path in results.files_of(out, name)]
    for result in (one for one in found if one.status != "failed"):
        total = recorded.get(result.student)
        if total is None or abs(total.by_tests - result.score) > TOLERANCE:
            raise WrongUse(
                f"The gradebook does not have {result.student}/{name} as it was graded last: "
                "give the grade command again, which brings it up to date."
            )
    return [one for one in found if one.status != "graded"]


def _column(tests: Assignment, known: Totals, rules: Rules | None, submitted: Path) -> Column:
    """Return an assignment's marks, after the late policy where there is one."""
    marks: dict[str, Mark] = {}
    undated: dict[str, str] = {}
    for student, total in known.students.items():
        at, over, off = None, timedelta(), total.penalty
        if rules is not None:
            if total.penalty:
                raise WrongUse(
                    f"nbgrader's own late policy has taken {off:g} points off {student}/"
                    f"{tests.name}: export without --late, or take it out of nbgrader."
                )
            try:
                at = late.handed_in(submitted / student / tests.name, tests.notebook)
            except Undated as error:
                undated[student] = str(error)
                continue
            due = rules.due_for(tests.name, student)
            over = max(over, at.at - due) if due is not None else over
            off = rules.policy.penalty(over, known.max_score)
        points = total.score, max(0.0, total.score - off)
        before, after = (tidy(round(each, DIGITS)) for each in points)
        marks[student] = Mark(before, after, total.waits, at, over)
    if undated and not marks:
        raise WrongUse(next(iter(undated.values())))
    return Column(tests.name, tests.config.title, tidy(known.max_score), marks, undated)
