"""``nbgrader export``: the gradebook as CSV that a spreadsheet shows and does not run.

nbgrader's own exporter writes names as they are. A comma in one moves the marks to
the next column, and one that begins as a formula does is computed when the file is
opened (OWASP, *CSV injection*).
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from nbgrader.api import Assignment, Gradebook, MissingEntry, Student
from nbgrader.plugins import ExportPlugin

from robust_slam_autograder.errors import GraderFailure
from robust_slam_autograder.grading import durable
from robust_slam_autograder.markup import as_csv

COLUMNS = (
    *("assignment", "duedate", "timestamp", "student_id", "last_name", "first_name", "email"),
    *("raw_score", "late_submission_penalty", "score", "max_score"),
)
"""nbgrader's own, in its order."""


class SafeCsv(ExportPlugin):  # type: ignore[misc]
    """nbgrader's exporter with text that stays text; configured by the same options."""

    def export(self, gradebook: Gradebook) -> None:
        """Write a row for each assignment and student."""
        rows = (
            _row(gradebook, assignment, student)
            for assignment in _chosen(gradebook.assignments, self.assignment, "name")
            for student in _chosen(gradebook.students, self.student, "id")
        )
        try:
            durable.write(Path(self.to or "grades.csv"), as_csv([COLUMNS, *rows]))
        except GraderFailure as error:
            raise SystemExit(str(error)) from error


def _chosen(listed: list[Any], wanted: list[Any], key: str) -> Iterator[Any]:
    names = {str(name) for name in wanted}
    return (one for one in listed if not names or getattr(one, key) in names)


def _row(gradebook: Gradebook, assignment: Assignment, student: Student) -> list[Any]:
    try:
        found = gradebook.find_submission(assignment.name, student.id)
        when, raw, penalty = found.timestamp, found.score, found.late_submission_penalty
    except MissingEntry:  # nothing handed in
        when, raw, penalty = None, 0.0, 0.0
    names = (student.id, student.last_name, student.first_name, student.email)
    marks = (raw, penalty, max(0.0, raw - (penalty or 0.0)), assignment.max_score)
    return [assignment.name, assignment.duedate, when, *names, *marks]
