"""What a batch remembers: its seed, and which submissions are done.

``.run.json`` holds the seed. ``.run.log`` beside it gets a line for each submission
that has its result, and for each that is in the gradebook; a line that a kill cut
short counts for nothing. Both are for their owner's eyes only.
"""

from __future__ import annotations

import json
import secrets
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

from robust_slam_autograder.errors import WrongUse
from robust_slam_autograder.grading import durable

RUN_NAME = ".run.json"
LOG_NAME = ".run.log"
_PRIVATE = 0o600


@dataclass
class Run:
    """A batch's seed, and fingerprints of its submissions by their keys.

    Attributes:
        out: the results' folder.
        seed: the batch's secret.
        graded: of those that have a result file.
        recorded: of those whose marks are in the gradebook.
    """

    out: Path
    seed: int
    graded: dict[str, str] = field(default_factory=dict)
    recorded: dict[str, str] = field(default_factory=dict)

    def remember(self, key: str, fingerprint: str) -> None:
        """Note that a submission has its result file."""
        self.graded[key] = fingerprint
        self._append([_line("graded", key, fingerprint)])

    def forget(self, key: str) -> None:
        """Note that a submission's result file is no longer one to keep."""
        if self.graded.pop(key, None) is not None:
            self._append([_line("graded", key, None)])

    def remember_recorded(self, keys: Iterable[str]) -> None:
        """Note that these submissions' marks, as graded, are in the gradebook."""
        new = {key: self.graded[key] for key in keys}
        self.recorded |= new
        self._append(_line("recorded", key, fingerprint) for key, fingerprint in new.items())

    def forget_recorded(self) -> None:
        """Note that there is no gradebook."""
        self.recorded.clear()
        self.tidy()

    def tidy(self) -> None:
        """Write the log anew, with what still counts."""
        durable.write(
            self.out / LOG_NAME, "".join(f"{line}\n" for line in self._lines()), mode=_PRIVATE
        )

    def _lines(self) -> Iterator[str]:
        for what, prints in (("graded", self.graded), ("recorded", self.recorded)):
            yield from (_line(what, key, fingerprint) for key, fingerprint in prints.items())

    def _append(self, lines: Iterable[str]) -> None:
        durable.append(self.out / LOG_NAME, lines)


def _line(what: str, key: str, fingerprint: str | None) -> str:
    return json.dumps([what, key, fingerprint])


def open_run(out: Path, seed: int | None) -> Run:
    """Go on with the batch in a folder, or begin one there.

    Args:
        out: the results' folder.
        seed: the seed to use; None keeps the batch's own, or draws a secret one.

    Raises:
        WrongUse: the folder's ``.run.json`` cannot be read.
        GraderFailure: the folder cannot be written.
    """
    path = out / RUN_NAME
    kept = _kept_seed(path)
    if kept is None or seed not in (None, kept):
        run = Run(out, secrets.randbits(63) if seed is None else seed)
        durable.write(path, json.dumps({"seed": run.seed}) + "\n", mode=_PRIVATE)
    else:
        run = Run(out, kept)
        _read_log(out / LOG_NAME, run)
    run.tidy()
    return run


def _kept_seed(path: Path) -> int | None:
    if not path.is_file():
        return None
    try:
        return int(json.loads(path.read_text(encoding="utf-8"))["seed"])
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise WrongUse(f"{path} cannot be read: delete it to begin a new batch.") from error


def _read_log(path: Path, run: Run) -> None:
    if not path.is_file():
        return
    with open(path, encoding="utf-8", errors="replace") as file:
        for line in file:
            match _parsed(line):
                case ["graded", str(key), str(fingerprint)]:
                    run.graded[key] = fingerprint
                case ["graded", str(key), None]:
                    run.graded.pop(key, None)
                case ["recorded", str(key), str(fingerprint)]:
                    run.recorded[key] = fingerprint


def _parsed(line: str) -> object:
    try:
        return json.loads(line)
    except (ValueError, RecursionError):
        return None
