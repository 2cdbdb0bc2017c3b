"""A class's marks side by side: a row for each student, a column for each exercise.

Without names students are numbered in the order of their points, and have no pages.
"""

import os
import statistics
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal
from urllib.parse import quote

from robust_slam_autograder.grading.results import ExerciseResult, Result, tidy
from robust_slam_autograder.markup import one_line, visible
from robust_slam_autograder.reports import versions
from robust_slam_autograder.reports.class_report import Source

Level = Literal["all", "most", "some", "zero", "unmarked"]
"""How much of the points: all, at least half, less, nothing; or no mark at all."""
ABSENT = "–"
REFUSED = "✗"
SAID = {"refused": "refused", "failed": "the grader failed"}


@dataclass(frozen=True)
class Square:
    """One student's points in one exercise."""

    text: str
    level: Level
    said: str
    """The same in words."""


class Group:
    """One assignment: its columns, and the results by student.

    The exercises are those of the usual tests, with their most points; ``shares`` are of each
    one's points over all who have a mark, and ``median`` is of their shares of all points.
    """

    def __init__(self, source: Source) -> None:
        self.title = source.title or visible(source.assignment)
        self.page, self.links = source.page, source.links
        marks = source.marks
        self.results = {result.student: result for result in marks}
        found = versions.of(marks)
        usual = found[0].results if found else ()
        first = usual[0].exercises if found else ()
        self.exercises = tuple((each.name, tidy(each.max_score)) for each in first)
        self.shares = tuple(_share([one.exercises[n] for one in usual]) for n in range(len(first)))
        shares = [result.score / result.max_score for result in usual if result.max_score]
        self.median = statistics.median(shares) if shares else None


@dataclass(frozen=True)
class Part:
    """One student in one assignment, against the class."""

    group: Group
    student: str

    @property
    def result(self) -> Result | None:
        """Return the result; None where nothing was handed in."""
        return self.group.results.get(self.student)

    @property
    def graded(self) -> Result | None:
        """Return the result; None where there is no mark."""
        result = self.result
        return result if result is not None and result.status == "graded" else None

    @property
    def remark(self) -> str:
        """Return why there is no mark; empty where there is one."""
        if self.result is None:
            return "not handed in"
        return "" if self.graded else SAID.get(self.result.status, self.result.status)

    @property
    def share(self) -> float | None:
        """Return the share of the points; None where there is no mark."""
        return _share([self.graded] if self.graded else [])

    @property
    def squares(self) -> tuple[tuple[str, Square], ...]:
        """Return the exercises by their names."""
        done = {each.name: each for each in (self.result.exercises if self.result else ())}
        return tuple(
            (visible(name), self._square(done.get(name))) for name, _ in self.group.exercises
        )

    def _square(self, exercise: ExerciseResult | None) -> Square:
        if exercise is None:
            said = "graded by other tests" if self.graded else self.remark
            return Square(ABSENT if self.graded or not self.result else REFUSED, "unmarked", said)
        points, most = tidy(exercise.score), tidy(exercise.max_score)
        return Square(str(points), _level(points, most), f"{points} of {most}")


@dataclass(frozen=True)
class Row:
    """One student in all assignments."""

    student: str
    page: str
    """Where the student's page is from the index; empty without names."""
    parts: tuple[Part, ...]

    @property
    def share(self) -> float | None:
        """Return the share of the points of what has a mark."""
        return _share([part.graded for part in self.parts if part.graded])

    @property
    def address(self) -> str:
        """Return the address of the student's page; empty without one."""
        return quote(os.fsencode(self.page))

    @property
    def squares(self) -> tuple[Square, ...]:
        """Return the exercises of all assignments."""
        return tuple(square for part in self.parts for _, square in part.squares)


@dataclass(frozen=True)
class HeatMap:
    """The whole table."""

    groups: tuple[Group, ...]
    rows: tuple[Row, ...]


def heat_map(sources: Sequence[Source]) -> HeatMap:
    """Put a class's marks in some assignments side by side."""
    groups = tuple(Group(source) for source in sources)
    rows = [
        Row(
            one_line(student),
            f"students/{student}.html",
            tuple(Part(group, student) for group in groups),
        )
        for student in sorted({student for group in groups for student in group.results})
    ]
    if not all(source.names for source in sources):
        rows.sort(key=lambda row: (-1.0 if row.share is None else -row.share, repr(row.squares)))
        rows = [replace(row, student=str(n), page="") for n, row in enumerate(rows, start=1)]
    return HeatMap(groups, tuple(rows))


def _share(results: Sequence[Result] | Sequence[ExerciseResult]) -> float | None:
    most = sum(result.max_score for result in results)
    return sum(result.score for result in results) / most if most else None


def _level(points: float, most: float) -> Level:
    if points >= most:
        return "all"
    if points <= 0:
        return "zero"
    return "most" if 2 * points >= most else "some"
