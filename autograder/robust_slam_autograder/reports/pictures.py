"""Where the parts of a picture stand: per cent of its width, and pixels of its height.

The pictures are SVG without a view box: they become as wide as the page is, and their
text stays as large as it is.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from robust_slam_autograder.reports.class_report import Bin, ExerciseStatistics, Marks

HEIGHT = 150.0
"""Of the highest bar of a histogram."""
CURVE = 90.0
"""Height of a row of numbers."""
GAP = 0.12
"""Between bars, as a share of the room for one."""
LABELS = 8
"""More labels than this do not fit beside each other on a phone."""


@dataclass(frozen=True)
class Bar:
    """One bar of a histogram."""

    x: float
    width: float
    middle: float
    height: float
    students: int
    label: str
    minor: bool
    """Whether its label may be left out for want of room."""


@dataclass(frozen=True)
class Histogram:
    """Bars, and where the median is between them."""

    bars: tuple[Bar, ...]
    median: float
    anchor: str
    """On which side of the median its label has room, in SVG's words."""


def histogram(marks: Marks) -> Histogram:
    """Draw how marks are spread."""
    number = len(marks.bins)
    tallest = max(found.students for found in marks.bins)
    bars = tuple(
        Bar(
            x=100 * (n + GAP / 2) / number,
            width=100 * (1 - GAP) / number,
            middle=100 * (n + 0.5) / number,
            height=HEIGHT * found.students / tallest,
            students=found.students,
            label=found.label,
            minor=number > LABELS and (number - 1 - n) % 2 == 1,
        )
        for n, found in enumerate(marks.bins)
    )
    at = 100 * _place(marks.bins, marks.median, marks.unit) / number
    return Histogram(bars, at, "start" if at < 20 else "end" if at > 80 else "middle")


def _place(bins: Sequence[Bin], mark: float, unit: float) -> float:
    """Return where a mark is, in bins from the left: alone in its bin it is in the middle."""
    n = max(n for n, found in enumerate(bins) if found.low <= mark or n == 0)
    room = bins[n].high - bins[n].low + unit
    return n + ((mark - bins[n].low + unit / 2) / room if room else 0.5)


@dataclass(frozen=True)
class Part:
    """A part of a bar that shows a whole."""

    kind: str
    x: float
    width: float


def parts(exercise: ExerciseStatistics) -> tuple[Part, ...]:
    """Draw how many students have all of an exercise's points, some, none, and no answer."""
    found, x = [], 0.0
    for kind in ("whole", "partly", "none", "missing"):
        width = 100 * getattr(exercise, kind) / exercise.students
        found.append(Part(kind, x, width))
        x += width
    return tuple(part for part in found if part.width)


@dataclass(frozen=True)
class Spread:
    """Marks on a line from nothing to everything: ends, quartiles and median."""

    lowest: float
    lower_quartile: float
    median: float
    upper_quartile: float
    highest: float


def spread(marks: Marks) -> Spread | None:
    """Draw marks as shares of the points; None where there are no points."""
    if not marks.max_score:
        return None
    values = (getattr(marks, name) for name in Spread.__dataclass_fields__)
    return Spread(*(100 * max(0.0, min(value / marks.max_score, 1.0)) for value in values))


@dataclass(frozen=True)
class Curves:
    """Two rows of numbers, as pairs of per cent from the left and pixels from the top."""

    yours: tuple[tuple[float, float], ...]
    expected: tuple[tuple[float, float], ...]
    lowest: str
    highest: str


def curves(yours: Sequence[float], expected: Sequence[float]) -> Curves | None:
    """Draw numbers in a row beside those that were expected; None where their range is too large.

    Args:
        yours: as many as ``expected``, two or more, all finite.
        expected: the other row.
    """
    low, high = min(*yours, *expected), max(*yours, *expected)
    if not math.isfinite(high - low):
        return None

    def placed(row: Sequence[float]) -> tuple[tuple[float, float], ...]:
        step = 100 / (len(row) - 1)
        shares = ((value - low) / (high - low) if high > low else 0.5 for value in row)
        return tuple((n * step, CURVE * (1 - share)) for n, share in enumerate(shares))

    return Curves(placed(yours), placed(expected), f"{low:.6g}", f"{high:.6g}")
