"""All marks that can be exported, and whose the grader failed to give."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path

from robust_slam_autograder.errors import WrongUse
from robust_slam_autograder.grading import results
from robust_slam_autograder.lms import marks
from robust_slam_autograder.lms.late import Rules
from robust_slam_autograder.lms.marks import Column
from robust_slam_autograder.nbgrader import database, totals
from robust_slam_autograder.nbgrader.database import Location
from robust_slam_autograder.nbgrader.totals import Totals
from robust_slam_autograder.reading import assignment as assignments

TOLERANCE = 1e-6
"""Points between a sum here and the same sum in the gradebook."""


@dataclass(frozen=True)
class Ledger:
    """The marks of some assignments."""

    columns: tuple[Column, ...]
    failed: tuple[tuple[str, str], ...]
    """Students and assignments on which the grader itself failed: they have no mark."""

    @property
    def students(self) -> list[str]:
        """Return everybody who has handed something in, once."""
        named = [student for column in self.columns for student in column.marks]
        return list(dict.fromkeys([*named, *sorted(student for student, _ in self.lost)]))

    @property
    def lost(self) -> frozenset[tuple[str, str]]:
        """Return students and assignments whose mark is not known: they have no 0 either."""
        undated = {(student, column.name) for column in self.columns for student in column.undated}
        return frozenset({*self.failed, *undated})


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

    Args:
        tree: the instructor's source tree.
        names: assignments; all that somebody has handed in where empty.
        location: the gradebook.
        out: the results' folder.
        rules: the late policy.
        submitted: where the submissions are.

    Raises:
        WrongUse: there are no marks, or the gradebook does not have all results.
    """
    if not database.exists(location):
        raise WrongUse(
            f"There is no gradebook {database.shown(location)}: grade first, or say --out DIR or "
            "--gradebook URL."
        )
    columns: list[Column] = []
    failed: list[tuple[str, str]] = []
    for name in assignments.chosen(tree, names):
        total = totals.read(location, name)
        broken = _failed(out, name, total)
        failed += [(student, name) for student in broken]
        total = _without(total, broken)
        if total.students:
            tests = assignments.load(assignments.notebook_path(tree / name))
            columns.append(marks.column(tests, total, rules=rules, submitted=submitted))
        elif name in names:
            raise WrongUse(f"{out} has no mark of {name}: grade it first, or say --out DIR.")
    return Ledger(tuple(columns), tuple(failed))


def _failed(out: Path, name: str, recorded: Totals) -> list[str]:
    """Return students on whose submission the grader failed; a mark that they have is an old one.

    Raises:
        WrongUse: a result is not in the gradebook as it is, for grading was stopped.
    """
    failed = []
    for path in results.files_of(out, name):
        result = results.read_checked(path)
        student = path.parent.name
        total = recorded.students.get(student)
        if result.status == "failed":
            failed.append(student)
        elif total is None or abs(total.by_tests - result.score) > TOLERANCE:
            raise WrongUse(
                f"The gradebook does not have {student}/{name} as it was graded last: "
                "give the grade command again, which brings it up to date."
            )
    return failed


def _without(recorded: Totals, students: Collection[str]) -> Totals:
    kept = {name: one for name, one in recorded.students.items() if name not in students}
    return Totals(recorded.max_score, kept)
