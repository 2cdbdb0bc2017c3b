"""The file of an assignment's tables, as ``autograder misconceptions`` writes it."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from robust_slam_autograder.errors import GraderFailure
from robust_slam_autograder.misconceptions import tables
from robust_slam_autograder.misconceptions.tables import Table
from robust_slam_autograder.reading.labelled import Answer

_PRIVATE = 0o600
FORMAT = 8
"""Of the file: one more makes files of an older engine be made again."""


@dataclass(frozen=True)
class Known:
    """The tables of an assignment's exercises, and of what they were made."""

    tests: str
    """Digest of the instructor's notebook that they were found with."""
    answers: str
    """Digest of the answers that were written down then."""
    exercises: Mapping[str, Table]


def digest(tests: Path) -> str:
    """Return the digest of an instructor's notebook."""
    return hashlib.sha256(tests.read_bytes()).hexdigest()


def digest_of_answers(answers: Sequence[Answer]) -> str:
    """Return the digest of the format and of answers that are written down, right and wrong."""
    text = json.dumps([FORMAT, [[one.exercise, one.source, one.label] for one in answers]])
    return hashlib.sha256(text.encode()).hexdigest()


def write(folder: Path, name: str, known: Known) -> Path:
    """Write an assignment's file; no one else may read it.

    Raises:
        GraderFailure: it cannot be written.
    """
    path = folder / f"{name}.json"
    text = json.dumps(asdict(known))
    try:
        folder.mkdir(parents=True, exist_ok=True)
        path.touch(_PRIVATE)
        path.write_text(f"{text}\n", encoding="utf-8")
    except OSError as error:
        what = f"{path} cannot be written ({error.strerror}): choose another place with --to DIR."
        raise GraderFailure(what) from error
    return path


def read(folder: Path, name: str, tests: Path) -> Known | None:
    """Read an assignment's file; None where there is none, or it is of other tests.

    Args:
        folder: where the files are.
        name: the assignment.
        tests: the instructor's notebook.
    """
    try:
        data = json.loads((folder / f"{name}.json").read_text(encoding="utf-8"))
        found = Known(data["tests"], data["answers"], tables.made(data["exercises"]))
        return found if found.tests == digest(tests) else None
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return None
