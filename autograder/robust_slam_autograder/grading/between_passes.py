"""Submissions that wait for their next pass: on the disk, so that few are in memory.

Each is kept with the bytes that were read, and with what its visible pass came to. A batch that
was stopped takes that over: the text that a student sees is the one that was made first.
"""

import base64
import hashlib
import json
from dataclasses import replace
from pathlib import Path

from robust_slam_autograder.grading import durable
from robust_slam_autograder.grading.submissions import Outcome, Submission

_KEPT = ("name", "notes", "refusal", "fingerprint", "town")


def put(folder: Path, one: Submission) -> None:
    """Keep a submission as it was read.

    Raises:
        GraderFailure: it cannot be written.
    """
    data = base64.b64encode(one.data).decode("ascii")
    seen = None if one.seen is None else one.seen.as_text()
    value = {name: getattr(one, name) for name in _KEPT} | {"data": data, "seen": seen}
    durable.write(_path(folder, one), json.dumps(value), private=True)


def get(folder: Path, one: Submission) -> Submission:
    """Take a submission back as it was kept.

    Raises:
        OSError: none is kept.
        ValueError: what is there is none.
    """
    try:
        value = json.loads(_path(folder, one).read_text(encoding="utf-8"))
        seen = None if value["seen"] is None else Outcome.from_text(value["seen"])
        known = {name: value[name] for name in _KEPT} | {"notes": tuple(value["notes"])}
        return replace(one, data=base64.b64decode(value["data"]), seen=seen, **known)
    except (KeyError, TypeError, RecursionError) as error:
        raise ValueError(f"{_path(folder, one)} keeps no submission") from error


def has_seen(folder: Path, one: Submission) -> bool:
    """Tell whether the same submission is kept with its visible pass."""
    try:
        kept = get(folder, one)
    except (OSError, ValueError):
        return False
    return kept.seen is not None and kept.fingerprint == one.fingerprint


def _path(folder: Path, one: Submission) -> Path:
    return folder / f"{hashlib.sha256(one.key.encode()).hexdigest()}.json"
