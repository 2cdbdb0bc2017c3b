"""Which Python runs here, and what of a newer one it does not know.

A sandbox runs the grader's own Python, so that one grades what was written in it or in an older.
"""

import os
import re
import sys
from collections.abc import Sequence
from pathlib import Path

from robust_slam_autograder.executor.session import StudentError
from robust_slam_autograder.reading.assignment import Piece
from robust_slam_autograder.student.imports import REFUSED

OURS = sys.version_info[:2]
MAX_LINE = 200
_MAY_BE_NEW = (SyntaxError, ImportError, AttributeError)
_NEW_GRAMMAR = {
    (3, 12): r"type\s+\w+.*=|(?:async\s+)?(?:def|class)\s+\w+\s*\[|.*\b(?:f|rf|fr)[\"'].*\{",
    (3, 14): r"except\b[^(\n]*,|.*\bt[\"']",
}
"""By the Python that knows it first, how a line looks that an older one cannot read."""
_FOLDERS = {sys.prefix, sys.base_prefix, *sys.path} - {"", "/"}
_PLACES = sorted({*_FOLDERS, *map(os.path.realpath, _FOLDERS)}, key=len, reverse=True)
_PATH = re.compile(rf"(?:{'|'.join(map(re.escape, _PLACES))})(?:(?:/[^\s'\"()/]+)*/|(?![\w.-]))")


def shown(version: tuple[int, ...]) -> str:
    """Return a version as people write it."""
    return "Python " + ".".join(map(str, version))


def without_paths(text: str) -> str:
    """Return a text in which files of this machine's Python have no folder."""
    return _PATH.sub(lambda found: "" if found[0].endswith("/") else "…", text)


def remark(error: StudentError, written: tuple[int, int] | None, pieces: Sequence[Piece]) -> str:
    """Say on a line of its own that a newer Python wrote the notebook, where that may be why.

    Args:
        error: what the student's code raised.
        written: the notebook's Python; None where it does not say, and only this one is named.
        pieces: the student's code; what fails in an own cell is lacking in others.
    """
    is_lacking = isinstance(error, NameError)
    name = re.search(r"'(\w+)' is not defined", str(error)) if is_lacking else None
    own = (piece.source for piece in pieces if piece.own)
    is_lost = name and any(re.search(rf"\b{name[1]}\b", source) for source in own)
    is_new = isinstance(error, SyntaxError) and _looks_new(error, pieces)
    is_new |= isinstance(error, ImportError) and REFUSED not in str(error)
    if written is None and is_new:
        return f"\n{shown(OURS)} runs it here: what only a newer one knows fails."
    if written is None or written <= OURS or not (is_lost or isinstance(error, _MAY_BE_NEW)):
        return ""
    return (
        f"\nYour notebook was written in {shown(written)}, and {shown(OURS)} runs it here: "
        "what is new since then fails."
    )


def _looks_new(error: StudentError, pieces: Sequence[Piece]) -> bool:
    """Tell whether the line that cannot be read has the look of a newer Python's grammar."""
    looks = "|".join(look for since, look in _NEW_GRAMMAR.items() if since > OURS) or r"(?!)"
    lines = (piece.source.split("\n")[(error.line or 0) - 1 :][:1] for piece in pieces)
    return any(re.match(rf"\s*(?:{looks})", text[:MAX_LINE]) for line in lines for text in line)


def warning(lab: tuple[int, int] | None) -> str:
    """Say what to do where students write in a newer Python than this; empty where they do not."""
    if lab is None or lab <= OURS:
        return ""
    return (
        f"Students write in {shown(lab)} in the browser, and {shown(OURS)} grades: what is new "
        f"since then costs them marks. Make the grader's environment with {shown(lab)} or newer"
        f"{_here(lab)}."
    )


def _here(least: tuple[int, int]) -> str:
    """Name the Pythons on the command path that are as new as this."""
    there = [path for folder in os.get_exec_path() for path in Path(folder).glob("python3*")]
    names = {name for path in there for name in (path.name, path.resolve().name)}
    found = {int(one[1]) for name in names if (one := re.fullmatch(r"python3\.(\d+)", name))}
    fit = [f"python3.{minor}" for minor in sorted(found) if (3, minor) >= least]
    return f", which this machine has: {', '.join(fit)}" if fit else ""
