"""What a batch remembers: its seed, and which submissions are done.

``.run.json`` holds the seed, and the secret of students' own data where they have any.
``.run.log`` beside it gets a line for each submission that has its result; a line that a kill cut
short counts for nothing. Both are for their owner's eyes only. Whose marks the gradebook has
stands in the gradebook: there may be another.
"""

import json
import secrets
from dataclasses import dataclass, field
from pathlib import Path

from robust_slam_autograder.errors import WrongUse
from robust_slam_autograder.executor import seeds
from robust_slam_autograder.grading import durable

RUN_NAME = ".run.json"
LOG_NAME = ".run.log"
_KEY_BYTES = 32


@dataclass
class Journal:
    """A batch's seed, and fingerprints of its submissions by their keys.

    Attributes:
        out: the results' folder.
        seed: the batch's secret.
        graded: of those that have a result file.
        towns: the secret from which students' numbers follow, in hexadecimal digits; empty where
            all have the same data.
    """

    out: Path
    seed: int
    graded: dict[str, str] = field(default_factory=dict)
    towns: str = ""

    def town(self, student: str) -> int:
        """Return the number of a student's data."""
        return seeds.town_of(self.towns, student) if self.towns else seeds.SHARED_TOWN

    def give_towns(self) -> None:
        """Give students data of their own from now on, where they have none yet."""
        if not self.towns:
            self.towns = secrets.token_hex(_KEY_BYTES)
            self.keep()

    def keep(self) -> None:
        """Write the batch's secrets down."""
        text = json.dumps({"seed": self.seed, "towns": self.towns})
        durable.write(self.out / RUN_NAME, f"{text}\n", private=True)

    def remember(self, key: str, fingerprint: str) -> None:
        """Note that a submission has its result file."""
        self.graded[key] = fingerprint
        durable.append(self.out / LOG_NAME, _line(key, fingerprint))

    def forget(self, key: str) -> None:
        """Note that a submission's result file is no longer one to keep."""
        if self.graded.pop(key, None) is not None:
            durable.append(self.out / LOG_NAME, _line(key, None))

    def tidy(self) -> None:
        """Write the log anew, with what still counts."""
        lines = [f"{_line(key, fingerprint)}\n" for key, fingerprint in self.graded.items()]
        durable.write(self.out / LOG_NAME, "".join(lines), private=True)


def _line(key: str, fingerprint: str | None) -> str:
    return json.dumps(["graded", key, fingerprint])


def open_journal(out: Path, seed: int | None) -> Journal:
    """Go on with the batch in a folder, or begin one there.

    Without a seed the batch keeps its own, or draws a secret one.

    Raises:
        WrongUse: the folder's ``.run.json`` cannot be read.
        GraderFailure: the folder cannot be written.
    """
    path = out / RUN_NAME
    kept, towns = _kept(path)
    if kept is None or seed not in (None, kept):
        journal = Journal(out, secrets.randbits(63) if seed is None else seed, towns=towns)
        journal.keep()
    else:
        journal = Journal(out, kept, towns=towns)
        _read_log(out / LOG_NAME, journal)
    journal.tidy()
    return journal


def _kept(path: Path) -> tuple[int | None, str]:
    if not path.is_file():
        return None, ""
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
        towns = data.get("towns", "")
        bytes.fromhex(towns)
        return int(data["seed"]), towns
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise WrongUse(f"{path} cannot be read: delete it to begin a new batch.") from error


def _read_log(path: Path, journal: Journal) -> None:
    if not path.is_file():
        return
    with open(path, encoding="utf-8", errors="replace") as file:
        for line in file:
            match _parsed(line):
                case ["graded", str(key), str(fingerprint)]:
                    journal.graded[key] = fingerprint
                case ["graded", str(key), None]:
                    journal.graded.pop(key, None)


def _parsed(line: str) -> object:
    try:
        return json.loads(line)
    except (ValueError, RecursionError):
        return None
