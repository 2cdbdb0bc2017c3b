"""The two files that nbgrader itself puts into a submission's folder, read as warily as the rest.

``timestamp.txt`` says when it was handed in, and ``submission_secret.txt`` lets its student fetch
feedback. nbgrader follows them through links, waits for a pipe and stops at words that are no
date, in formgrader's list of submissions too; and it has no setting for that.
"""

from datetime import datetime
from logging import Logger
from pathlib import Path

from nbgrader.apps.api import NbGraderAPI
from nbgrader.coursedir import CourseDirectory

from robust_slam_autograder.errors import Refused
from robust_slam_autograder.markup import log_line
from robust_slam_autograder.reading import notebook, timestamp

SECRET = "submission_secret.txt"
MAX_BYTES = 1000


def read_warily() -> None:
    """Have nbgrader, in this process, take what is no plain timestamp for none."""
    CourseDirectory.get_existing_timestamp = _existing_timestamp
    NbGraderAPI.get_submitted_timestamp = _submitted_timestamp


def plain(folder: Path) -> dict[str, bytes]:
    """Return those of the two files that are short plain files, with what they hold."""
    found = {name: _read(folder / name) for name in (timestamp.NAME, SECRET)}
    return {name: data for name, data in found.items() if data is not None}


def time_of(folder: Path, log: Logger | None = None) -> datetime | None:
    """Return when a submission says that it was handed in, in UTC without a zone.

    None where it does not, or says what is no time, which ``log`` is told.
    """
    try:
        stated = timestamp.read(folder)
    except Refused as error:
        if log is not None:
            log.warning("%s: %s It counts as without a time.", log_line(str(folder)), error)
        return None
    return None if stated is None else stated.replace(tzinfo=None)


def _read(path: Path) -> bytes | None:
    try:
        data = notebook.read_bytes(path)
    except Refused:
        return None
    return data if len(data) <= MAX_BYTES else None


def _existing_timestamp(course: CourseDirectory, folder: str) -> datetime | None:
    return time_of(Path(folder), course.log)


def _submitted_timestamp(api: NbGraderAPI, assignment: str, student: str) -> datetime | None:
    course = api.coursedir
    folder = course.format_path(course.submitted_directory, student, assignment)
    return _existing_timestamp(course, folder)
