"""Reports for the instructor as HTML: pages for assignments and students, and all side by side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from robust_slam_autograder.reports import documents, pictures
from robust_slam_autograder.reports.class_report import ENOUGH, MANY, Report
from robust_slam_autograder.reports.heat_map import HeatMap, Row

STYLE = "report"
HINTS = 3
"""How many texts of an exercise are open to see; the others are folded away."""
MOST_HINTS = 30
ATTENTION = 12
"""Lists that are longer are folded."""


@dataclass(frozen=True)
class Entry:
    """An assignment among all, with its page's address; empty where it has no page."""

    report: Report
    address: str


def html(report: Report, notice: str = "") -> str:
    """Return an assignment's page as one self-contained file.

    Args:
        report: what it shows.
        notice: stands at its top in place of the warning not to publish it.
    """
    return documents.html(
        "report",
        report=report,
        notice=notice,
        pictures=pictures,
        percent=percent,
        duration=duration,
        enough=ENOUGH,
        many=MANY,
        hints_open=HINTS,
        hints_most=MOST_HINTS,
        attention_open=ATTENTION,
    )


def index(entries: Sequence[Entry], chart: HeatMap, *, names: bool, notice: str = "") -> str:
    """Make the page that shows all assignments side by side, and every student in each."""
    return documents.html(
        "report-index",
        style=STYLE,
        entries=entries,
        chart=chart,
        many=MANY,
        names=names,
        notice=notice,
        pictures=pictures,
        percent=percent,
    )


def student(row: Row, notice: str = "") -> str:
    """Return the page of one student in all assignments."""
    return documents.html("report-student", style=STYLE, row=row, notice=notice, percent=percent)


def percent(share: float | None) -> str:
    """Return a share in per cent; shows 0 % or 100 % only when exact."""
    if share is None:
        return "–"
    if 0 < share < 0.01:
        return "<1 %"
    if 0.99 < share < 1:
        return ">99 %"
    return f"{100 * share:.0f} %"


def duration(seconds: float) -> str:
    """Return seconds for people: two digits, then minutes, then hours."""
    if seconds < 9.95:
        return f"{seconds:.1f} s"
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    if hours:
        return f"{hours} h {minutes:02d} min"
    return f"{minutes} min {rest:02d} s" if minutes else f"{rest} s"
