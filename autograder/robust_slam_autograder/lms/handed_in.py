"""When a submission was handed in: nbgrader's ``timestamp.txt``, else the notebook's own time."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from robust_slam_autograder.errors import Refused, WrongUse
from robust_slam_autograder.reading import submission, timestamp


class Undated(WrongUse):
    """One submission does not say when it was handed in: its lateness is unknown."""


@dataclass(frozen=True)
class HandedIn:
    """A time, and who says so."""

    at: datetime
    source: str
    """``timestamp.txt``, or the notebook's name: then a copy without its times says too late."""


def when(folder: Path, notebook: str) -> HandedIn:
    """Return the time of a submission ``submitted/<student>/<assignment>/``.

    Args:
        folder: the submission's.
        notebook: the assignment's notebook, without its ending.

    Raises:
        Undated: there is no folder or no notebook, or ``timestamp.txt`` holds no time.
    """
    try:
        stated = timestamp.read(folder)
    except Refused as error:
        raise Undated(f"{folder}: {error}") from error
    if stated is not None:
        return HandedIn(stated, timestamp.NAME)
    try:
        path, _ = submission.notebook_in(folder, notebook)
        modified = path.lstat().st_mtime
    except (Refused, OSError) as error:
        raise Undated(
            f"{folder} does not say when it was handed in ({error}): "
            "name the submissions' folder with --submitted DIR."
        ) from error
    return HandedIn(datetime.fromtimestamp(modified, UTC), path.name)
