"""Where a command shall write, looked at before it works: a mistyped path costs nothing then."""

from __future__ import annotations

import os
from pathlib import Path

from robust_slam_autograder.errors import WrongUse


def refuse_unwritable(option: str, path: Path, *, made: Path | None = None) -> None:
    """Refuse a place that no file can be written to.

    Args:
        option: who names it, as on the command line.
        path: the file to write.
        made: a folder that the command makes itself before it writes.

    Raises:
        WrongUse: its folder is missing or closed, or it is a folder itself.
    """
    folder = path.parent
    if path.is_dir():
        raise WrongUse(f"{option} {path} is a folder: name a file in it.")
    if made is not None and folder.resolve() == made.resolve():
        return
    if not folder.is_dir():
        raise WrongUse(
            f"There is no folder {folder} for {option} {path}: make it, or mend the path."
        )
    if not os.access(path if path.exists() else folder, os.W_OK):
        raise WrongUse(f"{option} {path} cannot be written: make it writable, or name another.")
