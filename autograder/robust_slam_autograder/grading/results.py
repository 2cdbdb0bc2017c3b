"""The result of one submission, and its file: one per submission, renamed into place."""

from __future__ import annotations

import glob
import hashlib
import json
import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from typing import Any, Literal, TypeVar

from robust_slam_autograder.errors import WrongUse
from robust_slam_autograder.grading import durable

SCHEMA = 1
Status = Literal["graded", "refused", "failed"]
ExerciseStatus = Literal["passed", "partial", "failed", "missing", "timeout", "died"]


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


@dataclass(frozen=True)
class CaseResult:
    """One case's outcome."""

    name: str
    points: float
    earned: float
    visible: bool
    """Whether the student has all of this case's checks."""
    message: str
    """For the student; of a hidden check it is the instructor's hint and nothing else."""
    compared: Compared | None = None
    """Of a visible check that failed, where it is known."""


@dataclass(frozen=True)
class ExerciseResult:
    """One exercise's outcome."""

    name: str
    score: float
    max_score: float
    status: ExerciseStatus
    message: str
    cases: tuple[CaseResult, ...]


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


Record = TypeVar("Record", Compared, CaseResult, ExerciseResult, Result)


def tidy(points: float) -> float:
    """Whole points as an int, so that 60 is written as 60."""
    return int(points) if float(points).is_integer() else points


def without_grade(
    status: Status, reason: str, *, student: str, assignment: str, max_score: float
) -> Result:
    """The result of a submission that was refused, or on which the grader failed."""
    return Result(student, assignment, 0, tidy(max_score), status, reason, "none", 0.0, ())


def path_of(out: Path, student: str, assignment: str) -> Path:
    """Where a submission's result file is."""
    return out / student / f"{assignment}.json"


def files_of(out: Path, assignment: str) -> list[Path]:
    """An assignment's result files, whatever its name."""
    return sorted(out.glob(f"*/{glob.escape(assignment)}.json"))


def write(out: Path, result: Result) -> Path:
    """Write a result's file; a reader sees the old one or the new one, never half of one.

    Raises:
        GraderFailure: the file cannot be written.
    """
    path = path_of(out, result.student, result.assignment)
    durable.write(path, as_text(result))
    return path


def as_text(result: Result) -> str:
    """What stands in a result's file."""
    value = {"schema": SCHEMA, **asdict(result)}
    return json.dumps(value, indent=1, ensure_ascii=False) + "\n"


def signature(result: Result, fingerprint: str) -> str:
    """Digest of what is said of a submission, and of all that it follows from.

    Not of the seconds, which differ from run to run and change no mark.
    """
    text = f"{fingerprint} {as_text(replace(result, seconds=0))}"
    return hashlib.sha256(text.encode(errors="backslashreplace")).hexdigest()


def read(path: Path) -> Result:
    """Read a result file back."""
    return from_text(path.read_text(encoding="utf-8"))


def from_text(text: str) -> Result:
    """Read back what ``as_text`` gave; of anything else an error, as ``read_checked`` knows it."""
    try:
        value = json.loads(text)
    except RecursionError as error:
        raise ValueError("it is nested too deeply") from error
    value.pop("schema")
    exercises = [
        _checked(ExerciseResult(**{**exercise, "cases": _cases(exercise["cases"])}))
        for exercise in value.pop("exercises")
    ]
    return _checked(Result(**value, exercises=tuple(exercises)))


def read_checked(path: Path) -> Result:
    """Read a result file that somebody may have spoilt.

    Raises:
        WrongUse: it cannot be read, or is no result file.
    """
    try:
        return read(path)
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        fix = "delete it and grade that submission again"
        raise WrongUse(f"{path} is no result file: {fix}.") from error


def _cases(values: Sequence[dict[str, Any]]) -> tuple[CaseResult, ...]:
    return tuple(_checked(CaseResult(**{**value, **_compared(value)})) for value in values)


def _compared(case: dict[str, Any]) -> dict[str, Any]:
    """The comparison in a case's values; files of before have none."""
    value = case.get("compared")
    if value is None:
        return {}
    curves = tuple(tuple(map(_number, curve)) for curve in value["curves"])
    if curves and (len(curves) != 2 or len(curves[0]) != len(curves[1])):
        raise TypeError(f"curves are {curves!r}")
    return {"compared": _checked(Compared(**{**value, "curves": curves}))}


def _number(value: Any) -> float:  # noqa: ANN401
    if type(value) not in (int, float) or not math.isfinite(value):
        raise TypeError(f"{value!r} is no number")
    return float(value)


def _checked(record: Record) -> Record:
    """A record whose numbers are numbers and whose texts are texts."""
    for field in fields(record):
        value = getattr(record, field.name)
        is_right = {
            "float": type(value) in (int, float) and math.isfinite(value),
            "bool": type(value) is bool,
            "Compared | None": value is None or isinstance(value, Compared),
        }.get(str(field.type), isinstance(value, str | tuple))
        if not is_right:
            raise TypeError(f"{field.name} is {value!r}")
    return record
