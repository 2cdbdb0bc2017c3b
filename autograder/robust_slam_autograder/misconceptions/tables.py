"""By which digests the wrong answers to an exercise have which label.

A label can be read by those alone whose answer has its key, so a table may go to students: it
tells no one what could be wrong, but only what is. What students are told comes of what their
functions returned to visible cases; no hidden pass has a part in it.
"""

import functools
import hashlib
import itertools
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from robust_slam_autograder.grading import durable
from robust_slam_autograder.grading.results import ExerciseResult, Result
from robust_slam_autograder.grading.returned import RAISED, REAL
from robust_slam_autograder.grading.submissions import Submission
from robust_slam_autograder.reading.labelled import Answer

FILE = "misconceptions.json"
"""In a release, the tables of its visible cases."""
MOST_KEYS = 64
"""Of one exercise: with more numbers beside the edge of a cell than give so many, none fits."""
FORMAT = 9
"""Of an assignment's file: one more makes files of an older engine be made again."""
Table = Mapping[str, str]
"""By half of a key, the label, which the key opens; empty where that is not one thing."""


@dataclass(frozen=True)
class Known:
    """The tables of an assignment's exercises, and of what they were made."""

    tests: str
    """Digest of the instructor's notebook that they were found with."""
    answers: str
    """Digest of the answers that were written down then."""
    exercises: Mapping[str, Table]


def keys(exercise: ExerciseResult) -> tuple[str, ...]:
    """Return the key of what failed visible cases returned, and then those beside it.

    There is none where a case cannot be compared, or each ended in an exception.
    """
    cases = ((f"{exercise.name}-{case.name}", case.returned) for case in exercise.cases)
    failed = {name: returned for name, returned in cases if returned is not None}
    if all(one.startswith(RAISED) for some in failed.values() for one in some):
        return ()
    names = sorted(failed)
    ways = itertools.product(*(failed[name] for name in names))
    found = list(itertools.islice(ways, MOST_KEYS + 1))
    return tuple(_key(names, one) for one in found) if len(found) <= MOST_KEYS else ()


def _key(names: Sequence[str], found: Sequence[str]) -> str:
    text = " ".join(f"{name}={one[1:]}" for name, one in zip(names, found, strict=True))
    return hashlib.sha256(text.encode()).hexdigest()


def is_real(exercise: ExerciseResult) -> bool:
    """Tell whether a case ended at numbers that are not whole, and so hardly by chance alike."""
    return any(one.startswith(REAL) for case in exercise.cases for one in case.returned or ())


def named(exercise: ExerciseResult, table: Table) -> ExerciseResult:
    """Return a wrong answer with its label, and with what tells it from answers unlike it."""
    if exercise.status not in ("partial", "failed") or not (found := keys(exercise)):
        return exercise
    pattern = hashlib.sha256(f"pattern {found[0]}".encode()).hexdigest()[:16]
    return replace(exercise, misconception=sentence(table, found), pattern=pattern)


def namer(folder: Path) -> Callable[[Submission, Result], Result]:
    """Return what names the wrong answers of a batch, by files in a folder; see ``read_made``."""
    known = functools.cache(functools.partial(read_made, folder))

    def name(job: Submission, result: Result) -> Result:
        found = known(job.assignment.path)
        tables = found.exercises if found else {}
        exercises = (named(one, tables.get(one.name, {})) for one in result.exercises)
        return replace(result, exercises=tuple(exercises))

    return name


def sentence(table: Table, keys: Sequence[str]) -> str:
    """Say what answers of these keys look like; empty where nothing fits, or two things do."""
    closed = {key: bytes.fromhex(table[_place(key)]) for key in keys if _place(key) in table}
    said = {_changed(text, key).decode(errors="replace") for key, text in closed.items()}
    return said.pop() if len(said) == 1 else ""


def sealed(labels: Mapping[str, str]) -> dict[str, str]:
    """Return sentences by half of their keys, each so that the whole key opens it."""
    return {_place(key): _changed(text.encode(), key).hex() for key, text in labels.items()}


def _place(key: str) -> str:
    return key[: len(key) // 2]


def _changed(data: bytes, key: str) -> bytes:
    stream = hashlib.shake_256(f"label {key}".encode()).digest(len(data))
    return bytes(one ^ other for one, other in zip(data, stream, strict=True))


def write(path: Path, tables: Mapping[str, Table]) -> None:
    """Write the tables of an assignment's exercises."""
    text = json.dumps(tables, separators=(",", ":"), sort_keys=True)
    path.write_text(f"{text}\n", "utf-8")


def read(path: Path) -> dict[str, Table]:
    """Read what ``write`` has written; none where there is no such file, or another one."""
    try:
        return _made(json.loads(path.read_text(encoding="utf-8")))
    except (OSError, ValueError, TypeError, AttributeError, RecursionError):
        return {}


def _made(data: Any) -> dict[str, Table]:  # noqa: ANN401
    found: dict[str, Table] = {name: dict(table.items()) for name, table in data.items()}
    for text in (text for table in found.values() for text in table.values()):
        bytes.fromhex(text)
    return found


def digest(tests: Path) -> str:
    """Return the digest of an instructor's notebook."""
    return hashlib.sha256(tests.read_bytes()).hexdigest()


def digest_of_answers(answers: Sequence[Answer]) -> str:
    """Return the digest of the format and of answers that are written down, right and wrong."""
    text = json.dumps([FORMAT, [[one.exercise, one.source, one.label] for one in answers]])
    return hashlib.sha256(text.encode()).hexdigest()


def made_of(folder: Path, tests: Path) -> Path:
    """Return the file of what was found out with an instructor's notebook."""
    return folder / f"{tests.resolve().parent.name}.json"


def write_made(folder: Path, tests: Path, known: Known) -> None:
    """Write what was found out about an assignment; no one else may read it.

    Raises:
        GraderFailure: it cannot be written.
    """
    durable.write(made_of(folder, tests), f"{json.dumps(asdict(known))}\n", private=True)


def read_made(folder: Path, tests: Path) -> Known | None:
    """Read what was found out; None where there is nothing, or it is of other tests."""
    try:
        data = json.loads(made_of(folder, tests).read_text(encoding="utf-8"))
        found = Known(data["tests"], data["answers"], _made(data["exercises"]))
        return found if found.tests == digest(tests) else None
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return None
