"""A class's marks side by side: a row for each student, a column for each exercise.

Without names students are numbered in the order of their points, and have no pages.
"""

from __future__ import annotations

import os
import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal
from urllib.parse import quote

from robust_slam_autograder.grading.results import ExerciseResult, Result, tidy
from robust_slam_autograder.markup import one_line, visible
from robust_slam_autograder.reports import versions
from robust_slam_autograder.reports.class_report import Source

Level = Literal["all", "most", "some", "zero", "unmarked"]
"""How much of the points: all, at least half, less, nothing; or no mark at all."""
STUDENTS = "students"
"""The folder of the students' pages, beside the index."""
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
    file: str
    """Name of the student's page in the folder ``STUDENTS``; empty without names."""
    share: float | None
    """Of the points of what has a mark."""
    parts: tuple[Part, ...]

    @property
    def address(self) -> str:
        """Return where the student's page is from the index; empty without one."""
        return f"{STUDENTS}/{quote(os.fsencode(self.file))}" if self.file else ""

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


@dataclass(frozen=True)
class Column:
    """An assignment as it goes into the table.

    Attributes:
        source: its results.
        page: address of its page from the index; empty without one.
        feedback: by student, the address of the feedback page from a student's page.
    """

    source: Source
    page: str
    feedback: Mapping[str, str] = field(default_factory=dict)


def heat_map(columns: Sequence[Column], files: Mapping[str, str]) -> HeatMap:
    """Put a class's marks side by side.

    Args:
        columns: the assignments, in order.
        files: by student, the name of the student's page.
    """
    tables = [_Table(column) for column in columns]
    names = all(column.source.names for column in columns)
    students = sorted({student for table in tables for student in table.results})
    rows = [_row(student, tables, files if names else {}) for student in students]
    if not names:
        rows.sort(key=lambda row: (-1.0 if row.share is None else -row.share, repr(row.squares)))
        rows = [Row(str(n), "", row.share, row.parts) for n, row in enumerate(rows, start=1)]
    return HeatMap(tuple(table.group for table in tables), tuple(rows))


class _Table:
    """One assignment's results by student; the exercises are those of the usual tests."""

    def __init__(self, column: Column) -> None:
        self.column = column
        self.results = {result.student: result for result in column.source.results}
        found = versions.of(column.source.results)
        usual = found[0].results if found else ()
        self.exercises = tuple((e.name, e.max_score) for e in usual[0].exercises) if found else ()
        most = usual[0].max_score if found else 0
        marks = [result.score / most for result in usual if most]
        self.median = statistics.median(marks) if marks else None
        self.group = Group(
            title=_title(column.source),
            page=column.page,
            exercises=tuple((visible(name), tidy(points)) for name, points in self.exercises),
            shares=tuple(_mean(usual, n) for n in range(len(self.exercises))),
        )

    def part(self, student: str) -> Part:
        result = self.results.get(student)
        graded = result if result is not None and result.status == "graded" else None
        return Part(
            title=self.group.title,
            page=self.column.page and f"../{self.column.page}",
            feedback=self.column.feedback.get(student, ""),
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


def _title(source: Source) -> str:
    return source.title or visible(source.assignment)


def _mean(results: Sequence[Result], n: int) -> float | None:
    mine = [result.exercises[n] for result in results]
    most = sum(exercise.max_score for exercise in mine)
    return sum(exercise.score for exercise in mine) / most if most else None


def _row(student: str, tables: Sequence[_Table], files: Mapping[str, str]) -> Row:
    parts = tuple(table.part(student) for table in tables)
    results = [table.results[student] for table in tables if student in table.results]
    marks = [result for result in results if result.status == "graded"]
    most = sum(result.max_score for result in marks)
    share = sum(result.score for result in marks) / most if most else None
    return Row(one_line(student), files.get(student, ""), share, parts)


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
