"""One submission of the suite, as data: what it is called, what it tries, what it may earn."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from .target import Notebook, Target

Bound = Literal["wrong", "less", "full", "refused", "any"]
"""What a submission may earn.

wrong: of the victim's cases only those that a plain wrong answer, or its own twin, earns.
less: not all of the victim's points.
full: all points, no less: it is right, however it looks.
refused: nothing, with the reason.
any: it is there to be compared with, or not to be judged by its marks.
"""


@dataclass(frozen=True)
class Place:
    """Where a submission is written, and what its code is told of the batch around it."""

    folder: Path
    """``submitted/<student>/<assignment>/``."""
    root: Path
    """The batch's folder: the source tree, submissions, results and the gradebook lie in it."""
    mark: str
    """Names the processes and files of this batch's attacks, so that survivors are found."""


Write = Callable[[Target, Place], None]


@dataclass(frozen=True)
class Entry:
    name: str
    """Also its student."""
    kind: str
    """As ``group: kind``; empty for a neighbour, a baseline or a twin."""
    bound: Bound
    write: Write
    twin: str | None = None
    """Name of the entry that does the same without the trick."""
    ends: str = ""
    """Status of the victim's exercise, where it matters: "timeout" or "died"."""
    spills: bool = False
    """Whether it may cost its own author marks in other exercises too."""


def hand_in(notebook: Notebook, target: Target, place: Place) -> None:
    """Write a notebook under its right name."""
    put(json.dumps(notebook).encode(), target, place)


def put(data: bytes, target: Target, place: Place) -> None:
    place.folder.mkdir(parents=True, exist_ok=True)
    (place.folder / target.file).write_bytes(data)
