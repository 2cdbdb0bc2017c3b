"""Whose mark goes to which line of the roster."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

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
    """Students who have handed something in and are not on the roster."""
    doubled: Mapping[int, tuple[str, ...]]
    """By line students whose names are equal after Unicode normalisation: they have no mark."""

    def mark(self, row: Row, column: Column) -> Mark | None:
        """Return a line's mark in an assignment; None where there is none."""
        return column.marks.get(self.owners.get(row.line, ""))

    def marked(self, columns: Sequence[Column]) -> int:
        """Return how many of the roster's students have a mark in one of these assignments."""
        rows = self.students.values()
        return sum(any(self.mark(row, column) for column in columns) for row in rows)

    def missing(self, column: Column) -> list[str]:
        """Return who is on the roster and has no mark in an assignment."""
        rows = self.students.items()
        return [name for name, row in rows if self.mark(row, column) is None]


def match(names: Iterable[str], students: Mapping[str, Row]) -> Matching:
    """Find each student's line.

    Args:
        names: the students, as their submissions' folders are named.
        students: the roster's lines, from ``roster.by_key``.
    """
    found: dict[int, list[str]] = {}
    strangers = []
    for student in dict.fromkeys(names):
        row = students.get(roster.key(student))
        if row is None:
            strangers.append(student)
        else:
            found.setdefault(row.line, []).append(student)
    owners = {line: same[0] for line, same in found.items() if len(same) == 1}
    doubled = {line: tuple(same) for line, same in found.items() if len(same) > 1}
    return Matching(students, owners, tuple(strangers), doubled)
