"""When a submission was handed in: nbgrader's ``timestamp.txt``, else the notebook's own time."""

from __future__ import annotations

import stat
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta, timezone, tzinfo
from pathlib import Path
from zoneinfo import ZoneInfo

from robust_slam_autograder.errors import Refused, WrongUse
from robust_slam_autograder.reading import submission

TIMESTAMP_NAME = "timestamp.txt"
MAX_BYTES = 200
"""Of a line that nbgrader writes."""


@dataclass(frozen=True)
class HandedIn:
    """A time, and who says so."""

    at: datetime
    source: str
    """``timestamp.txt``, or the notebook's name: then a copy without its times says too late."""


def when(folder: Path, notebook: str) -> HandedIn:
    """The time of a submission ``submitted/<student>/<assignment>/``.

    Args:
        folder: the submission's.
        notebook: the assignment's notebook, without its ending.

    Raises:
        WrongUse: there is no folder or no notebook, or ``timestamp.txt`` holds no time.
    """
    stamp = folder / TIMESTAMP_NAME
    if stamp.is_symlink() or stamp.exists():
        return HandedIn(_stamped(stamp), TIMESTAMP_NAME)
    try:
        path, _ = submission.notebook_in(folder, notebook)
        modified = path.lstat().st_mtime
    except (Refused, OSError) as error:
        raise WrongUse(
            f"{folder} does not say when it was handed in ({error}): "
            "name the submissions' folder with --submitted DIR."
        ) from error
    return HandedIn(datetime.fromtimestamp(modified, UTC), path.name)


def _stamped(path: Path) -> datetime:
    try:
        if not stat.S_ISREG(path.lstat().st_mode):
            raise ValueError("no plain file")
        with open(path, "rb") as file:
            return _parsed(file.read(MAX_BYTES).decode("utf-8").strip())
    except (OSError, ValueError) as error:
        raise WrongUse(
            f"{path}: this is no time with its zone, as 2026-10-20 23:59:00 UTC is: mend it."
        ) from error


def _parsed(text: str) -> datetime:
    """Read ``2026-10-20 23:59:00.123456 Europe/Berlin``: nbgrader writes a zone or an offset.

    Where there is neither, it is UTC, as nbgrader reads it.
    """
    parts = text.split(" ")
    moment = datetime.fromisoformat(" ".join(parts[:2]))
    if len(parts) > 2:
        return moment.replace(tzinfo=_zone(" ".join(parts[2:])))
    return moment if moment.tzinfo else moment.replace(tzinfo=UTC)


def _zone(text: str) -> tzinfo:
    if text[:1] in "+-" and text[1:].isdecimal() and len(text) == 5:
        sign = -1 if text[0] == "-" else 1
        return timezone(sign * timedelta(hours=int(text[1:3]), minutes=int(text[3:])))
    try:
        return ZoneInfo(text)
    except (OSError, LookupError) as error:
        raise ValueError(f"{text} is no time zone") from error
