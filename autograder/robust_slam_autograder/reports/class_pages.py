"""Reports for the instructor as HTML: pages for assignments and students, and all side by side."""

from collections.abc import Sequence

from robust_slam_autograder.reports import documents
from robust_slam_autograder.reports.class_report import MANY, Report
from robust_slam_autograder.reports.heat_map import HeatMap, Row


def html(report: Report, notice: str = "") -> str:
    """Return an assignment's page; a notice stands in place of the warning not to publish it."""
    return documents.html("report", report=report, notice=notice, many=MANY)


def index(reports: Sequence[Report], chart: HeatMap, *, names: bool, notice: str = "") -> str:
    """Make the page that shows all assignments side by side, and every student in each."""
    content = {"reports": reports, "chart": chart, "names": names, "notice": notice}
    return documents.html("report-index", many=MANY, **content)


def student(row: Row, notice: str = "") -> str:
    """Return the page of one student in all assignments."""
    return documents.html("report-student", row=row, notice=notice)
