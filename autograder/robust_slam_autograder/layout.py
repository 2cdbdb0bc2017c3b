"""Where the files of a class are kept, below the folder of the course.

They have a folder of their own, apart from ``build``, which may be deleted at any time.
"""

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
MISCONCEPTIONS = Path("build/misconceptions")
"""How answers can be wrong; it can be made again."""

COLOURS = Path("lib/robust_slam/colours.toml")
FONTS = Path("build/fonts/fonts.css")
LOGO = Path("chapters/assets/favicon.svg")
"""The course's colours, fonts and sign, of its pages and its reports; elsewhere there are none."""


def shown_beside(graded: Path) -> Path | None:
    """Return where formgrader looks for what the results in a folder are about.

    nbgrader keeps its graded notebooks beside the results, ``class/autograded`` beside
    ``class/graded``. Results in a folder of another name belong to no class: None.
    """
    return graded.parent / AUTOGRADED.name if graded.name == GRADED.name else None


def refuse_unmoved(graded: Path, root: Path = Path()) -> None:
    """Refuse to begin new results while those of the old layout have not been moved.

    Args:
        graded: the results' folder that a command uses, below ``root`` or absolute.
        root: the folder of the course.

    Raises:
        WrongUse: ``build/graded`` holds results, and ``graded`` is ``class/graded`` and holds
            none. The message gives the command that moves them.
    """
    before = root / "build"
    chosen = (root / graded).absolute() == (root / GRADED).absolute()
    old = before / GRADED.name
    if not chosen or _holds_anything(root / GRADED) or not _holds_anything(old):
        return
    moved = [
        str(before / new.name)
        for new in (GRADED, SUBMITTED, AUTOGRADED, FEEDBACK, REPORT)
        if (before / new.name).is_dir() and not _holds_anything(root / new)
    ]
    target = shlex.quote(str(root / CLASS))
    raise WrongUse(
        f"{old} holds results, and `make clean` would delete them. Move them to where a class "
        f"is kept now: mkdir -p {target} && mv {shlex.join(moved)} {target}/. "
        f"If they are only the sample class's, delete them: rm -r {shlex.quote(str(old))}"
    )


def _holds_anything(folder: Path) -> bool:
    return folder.is_dir() and any(folder.iterdir())
