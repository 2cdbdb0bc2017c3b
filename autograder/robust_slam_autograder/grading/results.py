"""The result of one submission, and its file: one per submission, renamed into place."""

import functools
import glob
import hashlib
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, is_dataclass, replace
from enum import StrEnum
from pathlib import Path
from types import NoneType
from typing import Any, Literal, get_args, get_origin, get_type_hints

from robust_slam_autograder.errors import WrongUse
from robust_slam_autograder.grading import durable, first_schema
from robust_slam_autograder.reading.assignment import Assignment

SCHEMA = 2
Status = Literal["graded", "refused", "failed"]
ExerciseStatus = Literal["passed", "partial", "failed", "missing", "timeout", "died"]
_types_of = functools.cache(get_type_hints)


class Ending(StrEnum):
    """How a case ended."""

    PASSED = "passed"
    FAILED = "failed"
    TIMEOUT = "timeout"
    """Student code used up its time, or a name is missing whose cell did."""
    DIED = "died"
    """Student code ended its process."""

    @property
    def is_fault(self) -> bool:
        """Tell whether the rest of the exercise is lost."""
        return self in (Ending.TIMEOUT, Ending.DIED)


class Words(StrEnum):
    """Whose words a message is."""

    CHECK = "check"
    """A check's own, or the instructor's hint: it names what was misunderstood."""
    GRADER = "grader"
    STUDENT = "student"
    """The grader's, which go on with what the student's code said."""


@dataclass(frozen=True)
class Compared:
    """What a visible check got from the student's code, beside what it expected."""

    what: str
    """A call, or an expression of the check."""
    yours: str
    relation: str
    """"expected", "expected less than" and the like."""
    expected: str
    remark: str
    """What is to be said of the value itself; empty where nothing is."""
    curves: tuple[tuple[float, ...], ...] = ()
    """Both as numbers, yours first, where they are as many and can be drawn."""

    def __post_init__(self) -> None:
        if self.curves and (len(self.curves) != 2 or len(set(map(len, self.curves))) != 1):
            raise TypeError(f"curves are {self.curves!r}")


@dataclass(frozen=True)
class CaseResult:
    """One case's outcome."""

    name: str
    points: float
    earned: float
    visible: bool
    """Whether the student has all of this case's checks."""
    ending: Ending
    message: str
    """For the student; of a hidden check it is the instructor's hint and nothing else."""
    words: Words = Words.CHECK
    """Whose words the message is."""
    gist: str = ""
    """The message without what the student's code said or returned, where it holds any."""
    raised: str = ""
    """The exception's name at the end of the gist, which the student may have chosen."""
    compared: Compared | None = None
    """Of a visible check that failed, where it is known."""
    returned: tuple[str, ...] | None = field(default=None, compare=False)
    """Of a visible check that failed, ``returned.digests`` of what came back, to name it."""

    @property
    def passed(self) -> bool:
        """Tell whether the case earned its points."""
        return self.ending is Ending.PASSED

    @property
    def sentence(self) -> str:
        """Return the message without what the student's code said or returned."""
        return self.gist or self.message


@dataclass(frozen=True)
class ExerciseResult:
    """One exercise's outcome."""

    name: str
    score: float
    max_score: float
    status: ExerciseStatus
    message: str
    cases: tuple[CaseResult, ...]
    misconception: str = ""
    """What a wrong answer looks like, to go on after "It looks as if"; empty where unknown."""
    pattern: str = ""
    """What wrong answers have in common that return the same; for the instructor alone."""


@dataclass(frozen=True)
class Result:
    """One submission's outcome, as in the result file."""

    student: str
    assignment: str
    score: float
    max_score: float
    status: Status
    reason: str
    """Why it was refused or failed, or what was unusual; empty where nothing was."""
    sandbox: str
    seconds: float
    exercises: tuple[ExerciseResult, ...]
    texts: Mapping[str, str] | None = None
    """By grade id ``submission.digest`` of each free-text answer; None where not known."""


def by_grade_id(result: Result, assignment: Assignment) -> Mapping[str, CaseResult]:
    """Return how an assignment's cases went, as far as a result has them."""
    found = {(one.name, case.name): case for one in result.exercises for case in one.cases}
    keys = {case.grade_id: (case.exercise, case.name) for case in assignment.cases}
    return {grade_id: found[key] for grade_id, key in keys.items() if key in found}


def tidy(points: float) -> float:
    """Return whole points as an int, so that 60 is written as 60."""
    return int(points) if float(points).is_integer() else points


def without_grade(
    status: Status, reason: str, *, student: str, assignment: str, max_score: float
) -> Result:
    """Return the result of a submission that was refused, or on which the grader failed."""
    return Result(student, assignment, 0, tidy(max_score), status, reason, "none", 0.0, ())


def path_of(out: Path, student: str, assignment: str) -> Path:
    """Return where a submission's result file is."""
    return out / student / f"{assignment}.json"


def files_of(out: Path, assignment: str) -> list[Path]:
    """Return an assignment's result files, whatever its name."""
    return sorted(out.glob(f"*/{glob.escape(assignment)}.json"))


def listed(out: Path) -> list[Path]:
    """Return all result files of a folder.

    Raises:
        WrongUse: there is none.
    """
    plain = (path for path in out.glob("*/*.json") if path.parts[-2][0] != "." != path.name[0])
    if not (found := sorted(plain)):
        raise WrongUse(f"{out} holds no result: grade first, or name the folder with --out DIR.")
    return found


def write(out: Path, result: Result) -> Path:
    """Write a result's file; a reader sees the old one or the new one, never half of one.

    Raises:
        GraderFailure: the file cannot be written.
    """
    path = path_of(out, result.student, result.assignment)
    durable.write(path, as_text(result))
    return path


def as_text(result: Result) -> str:
    """Return what stands in a result's file."""
    value = {"schema": SCHEMA, **asdict(result)}
    return json.dumps(value, indent=1, ensure_ascii=False) + "\n"


def signature(result: Result, fingerprint: str) -> str:
    """Return a digest of what is said of a submission, and of all that it follows from.

    Not of the seconds, which differ from run to run and change no mark.
    """
    text = f"{fingerprint} {as_text(replace(result, seconds=0))}"
    return hashlib.sha256(text.encode(errors="backslashreplace")).hexdigest()


def read(path: Path) -> Result:
    """Read a result file back, and check it: the folder may hold another program's or person's.

    Raises:
        OSError: it cannot be read.
        ValueError: it is no result, or not the one of its student and its assignment.
    """
    result = from_text(path.read_text(encoding="utf-8"))
    if (result.student, result.assignment) != (path.parent.name, path.stem):
        raise ValueError(f"it is the result of {result.student}/{result.assignment}")
    return result


def read_checked(path: Path) -> Result:
    """Read a result file for a command, which stops where it is not one.

    Raises:
        WrongUse: it cannot be read, or is no result file.
    """
    try:
        return read(path)
    except (OSError, ValueError) as error:
        why = str(error.strerror if isinstance(error, OSError) else error)
        fix = "delete it and grade that submission again"
        raise WrongUse(f"{path} is no result file ({why}): {fix}.") from error


def from_text(text: str) -> Result:
    """Read back what ``as_text`` gave.

    Raises:
        ValueError: it is anything else, or its points do not add up.
    """
    try:
        value = json.loads(text)
        schema = value.pop("schema")
        if schema not in (1, SCHEMA):
            raise ValueError(f"its schema is {schema!r}, of a newer grader")
        if schema == 1:
            value["exercises"] = list(map(first_schema.upgraded, value["exercises"]))
        result: Result = made(Result, value)
    except (RecursionError, OverflowError, KeyError, TypeError, AttributeError) as error:
        raise ValueError("a grader writes it otherwise") from error
    if problem := _miscount(result):
        raise ValueError(f"the points of {problem} do not add up")
    return result


def made(kind: Any, value: Any, **known: object) -> Any:  # noqa: ANN401
    """Make a value of an annotated type of what JSON has of it; ``known`` are further fields.

    Raises:
        TypeError: it is of another type, as are AttributeError, KeyError and ValueError.
    """
    if isinstance(kind, type) and is_dataclass(kind):
        types = _types_of(kind)
        return kind(**known, **{name: made(types[name], part) for name, part in value.items()})
    if isinstance(kind, type) and issubclass(kind, StrEnum):
        return kind(value)
    outer, inner = get_origin(kind), get_args(kind)
    if NoneType in inner:
        return None if value is None else made(inner[0], value)
    if outer in (tuple, list) and isinstance(value, list):
        return outer(made(inner[0], part) for part in value)
    if outer in (Mapping, dict) and isinstance(value, dict):
        return {name: made(inner[1], part) for name, part in value.items()}
    if kind is float and type(value) in (int, float) and math.isfinite(value):
        return value
    if value in inner if outer is Literal else kind in (str, bool, int) and type(value) is kind:
        return value
    raise TypeError(f"{value!r} is no {kind}")


def _miscount(result: Result) -> str:
    """Name what has other points than its parts together; empty where all add up."""
    for exercise in result.exercises:
        for case in exercise.cases:
            if case.points < 0 or case.earned != (case.points if case.passed else 0):
                return f"{exercise.name}-{case.name}"
        if not _adds_up(exercise, exercise.cases, "earned", "points"):
            return exercise.name
    if result.status == "graded":
        whole = _adds_up(result, result.exercises, "score", "max_score")
    else:
        whole = not result.score and not result.exercises
    return "" if whole else "the whole"


def _adds_up(
    whole: Result | ExerciseResult, parts: Sequence[object], earned: str, points: str
) -> bool:
    got = math.isclose(whole.score, sum(getattr(part, earned) for part in parts))
    return got and math.isclose(whole.max_score, sum(getattr(part, points) for part in parts))
