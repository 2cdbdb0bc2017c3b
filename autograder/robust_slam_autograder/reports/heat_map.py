"""A class's marks side by side: a row for each student, a column for each exercise.

Without names students are numbered in the order of their points, and have no pages.
"""

from __future__ import annotations

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


@dataclass(frozen=True)
class Part:
    """One assignment of one student, against the class."""

    title: str
    page: str
    """Address of the assignment's page from the student's; empty without one."""
    feedback: str
    """The same of the feedback."""
    mark: str
    remark: str
    """Why there is no mark; empty where there is one."""
    share: float | None
    """Of the points; None where there is no mark."""
    median: float | None
    """Of the class, in the same unit."""
    squares: tuple[tuple[str, Square], ...]
    """The exercises by their names."""


@dataclass(frozen=True)
class Row:
    """One student in all assignments."""

    student: str
    page: str
    """Where the student's page is from the index; empty without names."""
    share: float | None
    """Of the points of what has a mark."""
    parts: tuple[Part, ...]

    @property
    def address(self) -> str:
        """Return the address of the student's page; empty without one."""
        return quote(os.fsencode(self.page))

    @property
    def squares(self) -> tuple[Square, ...]:
        """Return the exercises of all assignments."""
        return tuple(square for part in self.parts for _, square in part.squares)


@dataclass(frozen=True)
class Group:
    """The columns of one assignment."""

    title: str
    page: str
    exercises: tuple[tuple[str, float], ...]
    """Names, and most points."""
    shares: tuple[float | None, ...]
    """Of each exercise's points, over all who have a mark."""


@dataclass(frozen=True)
class HeatMap:
    """The whole table."""

    groups: tuple[Group, ...]
    rows: tuple[Row, ...]


def heat_map(sources: Sequence[Source]) -> HeatMap:
    """Put a class's marks in some assignments side by side."""
    tables = [_Table(source) for source in sources]
    students = sorted({student for table in tables for student in table.results})
    rows = [_row(student, tables) for student in students]
    if not all(source.names for source in sources):
        rows.sort(key=lambda row: (-1.0 if row.share is None else -row.share, repr(row.squares)))
        rows = [replace(row, student=str(n), page="") for n, row in enumerate(rows, start=1)]
    return HeatMap(tuple(table.group for table in tables), tuple(rows))


class _Table:
    """One assignment's results by student; the exercises are those of the usual tests."""

    def __init__(self, source: Source) -> None:
        self.links = source.links
        self.results = {result.student: result for result in source.results}
        found = versions.of(source.results)
        usual = found[0].results if found else ()
        self.exercises = tuple((e.name, e.max_score) for e in usual[0].exercises) if found else ()
        most = usual[0].max_score if found else 0
        marks = [result.score / most for result in usual if most]
        self.median = statistics.median(marks) if marks else None
        self.group = Group(
            title=source.title or visible(source.assignment),
            page=source.page,
            exercises=tuple((visible(name), tidy(points)) for name, points in self.exercises),
            shares=tuple(_mean(usual, n) for n in range(len(self.exercises))),
        )

    def part(self, student: str) -> Part:
        result = self.results.get(student)
        graded = result if result is not None and result.status == "graded" else None
        return Part(
            title=self.group.title,
            page=_from_above(self.group.page),
            feedback=_from_above(self.links.get(student, "")),
            mark=f"{tidy(graded.score)} of {tidy(graded.max_score)}" if graded else ABSENT,
            remark="" if graded else _remark(result),
            share=graded.score / graded.max_score if graded and graded.max_score else None,
            median=self.median,
            squares=tuple(self._squares(result)),
        )

    def _squares(self, result: Result | None) -> list[tuple[str, Square]]:
        exercises = {} if result is None else {e.name: e for e in result.exercises}
        found = [(visible(name), exercises.get(name)) for name, _ in self.exercises]
        return [(name, _square(exercise, result)) for name, exercise in found]


def _from_above(address: str) -> str:
    """Return an address from the folder of the students' pages in place of the one above."""
    return address and f"../{address}"


def _mean(results: Sequence[Result], n: int) -> float | None:
    mine = [result.exercises[n] for result in results]
    most = sum(exercise.max_score for exercise in mine)
    return sum(exercise.score for exercise in mine) / most if most else None


def _row(student: str, tables: Sequence[_Table]) -> Row:
    parts = tuple(table.part(student) for table in tables)
    results = [table.results[student] for table in tables if student in table.results]
    marks = [result for result in results if result.status == "graded"]
    most = sum(result.max_score for result in marks)
    share = sum(result.score for result in marks) / most if most else None
    return Row(one_line(student), f"students/{student}.html", share, parts)


def _remark(result: Result | None) -> str:
    return "not handed in" if result is None else SAID.get(result.status, result.status)


def _square(exercise: ExerciseResult | None, result: Result | None) -> Square:
    if exercise is None:
        graded = result is not None and result.status == "graded"
        said = "graded by other tests" if graded else _remark(result)
        return Square(ABSENT if graded or result is None else REFUSED, "unmarked", said)
    points, most = tidy(exercise.score), tidy(exercise.max_score)
    return Square(str(points), _level(points, most), f"{points} of {most}")


def _level(points: float, most: float) -> Level:
    if points >= most:
        return "all"
    if points <= 0:
        return "zero"
    return "most" if 2 * points >= most else "some"
