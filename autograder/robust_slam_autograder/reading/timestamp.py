"""``timestamp.txt``, in which nbgrader says when a submission was handed in.

It is in the student's folder, so it is read as strictly as a notebook.
"""

from __future__ import annotations

import os
from datetime import UTC, datetime, timedelta, timezone, tzinfo
from pathlib import Path
from zoneinfo import ZoneInfo

from robust_slam_autograder.errors import Refused
from robust_slam_autograder.reading import notebook

NAME = "timestamp.txt"
MAX_BYTES = 200
"""Of a line that nbgrader writes."""


def read(folder: Path) -> datetime | None:
    """Return the time and zone that a submission's folder states; None without such a file.

    Raises:
        Refused: the file is a link or no plain file, or it holds no time.
    """
    path = folder / NAME
    if not os.path.lexists(path):
        return None
    data = notebook.read_bytes(path)
    try:
        if len(data) > MAX_BYTES:
            raise ValueError("too long")
        return _parsed(data.decode("utf-8").strip()).astimezone(UTC)
    except (ValueError, OverflowError) as error:
        raise Refused(
            f"{NAME} holds no time with its zone, as 2026-10-20 23:59:00 UTC is: correct it."
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
