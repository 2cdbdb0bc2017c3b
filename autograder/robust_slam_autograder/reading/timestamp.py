"""``timestamp.txt``, in which nbgrader says when a submission was handed in.

It is in the student's folder, so it is read as strictly as a notebook.
"""

import os
from datetime import UTC, datetime
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
    except (ValueError, OverflowError, OSError, LookupError) as error:  # as ZoneInfo has them
        raise Refused(
            f"{NAME} holds no time with its zone, as 2026-10-20 23:59:00 UTC is: correct it."
        ) from error


def _parsed(text: str) -> datetime:
    """Read ``2026-10-20 23:59:00.123456 Europe/Berlin``: nbgrader writes a zone or an offset.

    Where there is neither, it is UTC, as nbgrader reads it.
    """
    date, clock, zone = [*text.split(" ", 2), "", ""][:3]
    is_offset = zone.startswith(("+", "-"))
    moment = datetime.fromisoformat(f"{date} {clock}{zone if is_offset else ''}".strip())
    if zone and not is_offset:
        return moment.replace(tzinfo=ZoneInfo(zone))
    return moment if moment.tzinfo else moment.replace(tzinfo=UTC)
