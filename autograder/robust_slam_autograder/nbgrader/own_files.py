"""The two files that nbgrader itself puts into a submission's folder, read as warily as the rest.

``timestamp.txt`` says when it was handed in, and ``submission_secret.txt`` lets its student fetch
feedback. nbgrader follows them through links, waits for a pipe and stops at words that are no
date, in formgrader's list of submissions too; and it has no setting for that.
"""

from __future__ import annotations

import os
from datetime import datetime
from pathlib import Path

from nbgrader.apps.api import NbGraderAPI
from nbgrader.coursedir import CourseDirectory
from nbgrader.utils import parse_utc

from robust_slam_autograder.errors import Refused
from robust_slam_autograder.reading import notebook

TIMESTAMP = "timestamp.txt"
SECRET = "submission_secret.txt"
MAX_BYTES = 1000


def read_warily() -> None:
    """Have nbgrader, in this process, take what is no plain timestamp for none."""
    CourseDirectory.get_existing_timestamp = _existing_timestamp
    NbGraderAPI.get_submitted_timestamp = _submitted_timestamp


def plain(folder: Path) -> dict[str, bytes]:
    """Those of the two files that are short plain files, with what they hold."""
    found = {name: _read(folder / name) for name in (TIMESTAMP, SECRET)}
    return {name: data for name, data in found.items() if data is not None}


def _read(path: Path) -> bytes | None:
    try:
        data = notebook.read_bytes(path)
    except Refused:
        return None
    return data if len(data) <= MAX_BYTES else None


def _existing_timestamp(course: CourseDirectory, folder: str) -> datetime | None:
    path = Path(folder, TIMESTAMP)
    try:
        found: datetime = parse_utc((_read(path) or b"").decode().strip())
    except (ValueError, OverflowError):
        if os.path.lexists(path):
            course.log.warning("%s is no file with a time: it counts as handed in at none", path)
        return None
    return found


def _submitted_timestamp(api: NbGraderAPI, assignment: str, student: str) -> datetime | None:
    course = api.coursedir
    folder = course.format_path(course.submitted_directory, student, assignment)
    return _existing_timestamp(course, folder)
