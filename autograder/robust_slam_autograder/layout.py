"""Where the files of a class are kept, below the folder of the course.

They have a folder of their own, apart from ``build``, which may be deleted at any time.
"""

from __future__ import annotations

import shlex
from pathlib import Path

from robust_slam_autograder.errors import WrongUse

CLASS = Path("class")
SUBMITTED = CLASS / "submitted"
GRADED = CLASS / "graded"
"""Results, gradebook and seed."""
AUTOGRADED = CLASS / "autograded"
FEEDBACK = CLASS / "feedback"
REPORT = CLASS / "report"
GRADESCOPE = CLASS / "gradescope"

COLOURS = Path("lib/robust_slam/colours.toml")
"""The course's colours, of its pages and its reports; elsewhere reports have their own."""

_BEFORE = Path("build")
"""Where a class was kept before it had a folder of its own."""


def refuse_unmoved(graded: Path, root: Path = Path()) -> None:
    """Refuse to begin new results while those of the old layout have not been moved.

    Args:
        graded: the results' folder that a command uses, below ``root`` or absolute.
        root: the folder of the course.

    Raises:
        WrongUse: ``build/graded`` holds results, and ``graded`` is ``class/graded`` and holds
            none. The message gives the command that moves them.
    """
    before = root / _BEFORE / GRADED.name
    chosen = (root / graded).absolute() == (root / GRADED).absolute()
    if not chosen or _holds_anything(root / GRADED) or not _holds_anything(before):
        return
    there = [_BEFORE / new.name for new in (GRADED, SUBMITTED, AUTOGRADED, FEEDBACK, REPORT)]
    moved = [
        old
        for old in there
        if (root / old).is_dir() and not _holds_anything(root / CLASS / old.name)
    ]
    raise WrongUse(
        f"{before} holds results, and `make clean` would delete them. Move them to where a class "
        f"is kept now: {_move(moved, root)}. If they are only the sample class's, delete them: "
        f"rm -r {shlex.quote(str(before))}"
    )


def _holds_anything(folder: Path) -> bool:
    return folder.is_dir() and any(folder.iterdir())


def _move(folders: list[Path], root: Path) -> str:
    target = shlex.quote(str(root / CLASS))
    return f"mkdir -p {target} && mv {shlex.join(str(root / path) for path in folders)} {target}/"
