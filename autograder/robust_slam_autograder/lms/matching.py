"""Whose mark goes to which line of the roster."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from robust_slam_autograder.errors import WrongUse
from robust_slam_autograder.lms import roster
from robust_slam_autograder.lms.marks import Column, Mark
from robust_slam_autograder.lms.roster import Row


@dataclass(frozen=True)
class Matching:
    """Submissions and the roster, side by side."""

    students: Mapping[str, Row]
    """The roster's lines by the name that submissions are matched by."""
    owners: Mapping[int, str]
    """By line the student, as the submissions' folder is named, where there is one."""
    strangers: tuple[str, ...]
    """Who has handed something in and is not on the roster."""

    def mark(self, row: Row, column: Column) -> Mark | None:
        """A line's mark in an assignment; None where there is none."""
        return column.marks.get(self.owners.get(row.line, ""))

    def marked(self, columns: Sequence[Column]) -> int:
        """How many of the roster's students have a mark in one of these assignments."""
        rows = self.students.values()
        return sum(any(self.mark(row, column) for column in columns) for row in rows)

    def missing(self, column: Column) -> list[str]:
        """Who is on the roster and has no mark in an assignment."""
        rows = self.students.items()
        return [name for name, row in rows if self.mark(row, column) is None]


def match(names: Iterable[str], students: Mapping[str, Row]) -> Matching:
    """Find each student's line.

    Args:
        names: the students, as their submissions' folders are named.
        students: the roster's lines, from ``roster.by_key``.

    Raises:
        WrongUse: two submissions' names are the same to the roster.
    """
    owners: dict[int, str] = {}
    strangers = []
    for student in dict.fromkeys(names):
        row = students.get(roster.key(student))
        if row is None:
            strangers.append(student)
        elif row.line in owners:
            both = f"{owners[row.line]!a} and {student!a}"
            raise WrongUse(f"{both} are one name, written in two ways: grade them as one.")
        else:
            owners[row.line] = student
    return Matching(students, owners, tuple(strangers))
