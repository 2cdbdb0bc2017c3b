"""The file of an assignment's ways to be wrong, as ``autograder misconceptions`` writes it."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from robust_slam_autograder.errors import GraderFailure
from robust_slam_autograder.misconceptions.candidates import Candidate
from robust_slam_autograder.reading.labelled import Answer

_PRIVATE = 0o600
FORMAT = 6
"""Of the file: one more makes files of an older engine be made again."""
_OWN = ("slip", "about")
"""What the survey alone needs to know of a candidate."""


@dataclass(frozen=True)
class Known:
    """The ways to be wrong in an assignment that have a name."""

    tests: str
    """Digest of the instructor's notebook that they were found with."""
    answers: str
    """Digest of the answers that were written down then."""
    exercises: Mapping[str, Sequence[Candidate]]


def digest(tests: Path) -> str:
    """Return the digest of an instructor's notebook."""
    return hashlib.sha256(tests.read_bytes()).hexdigest()


def digest_of_answers(answers: Sequence[Answer]) -> str:
    """Return the digest of the format and of answers that are written down, right and wrong."""
    text = json.dumps([FORMAT, [[one.exercise, one.source, one.label] for one in answers]])
    return hashlib.sha256(text.encode()).hexdigest()


def write(folder: Path, name: str, known: Known) -> Path:
    """Write an assignment's file, which holds solutions with a slip: no one else may read it.

    Raises:
        GraderFailure: it cannot be written.
    """
    path = folder / f"{name}.json"
    exercises = {
        exercise: [
            {key: value for key, value in asdict(one).items() if key not in _OWN} for one in found
        ]
        for exercise, found in known.exercises.items()
    }
    data = {"tests": known.tests, "answers": known.answers, "exercises": exercises}
    text = json.dumps(data, ensure_ascii=False)
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
        exercises = {
            exercise: tuple(Candidate(**one) for one in found)
            for exercise, found in data["exercises"].items()
        }
        found = Known(data["tests"], data["answers"], exercises)
        return found if found.tests == digest(tests) else None
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return None
