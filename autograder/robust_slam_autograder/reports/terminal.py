"""Results as text for a terminal: ✓ and ✗, always with a word."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from robust_slam_autograder.grading.results import ExerciseResult, Result
from robust_slam_autograder.grading.verdicts import (
    ADVICE,
    check_verdict,
    failed_cases,
    has_hidden,
    remaining,
)
from robust_slam_autograder.markup import one_line


def marks_table(marks: Sequence[Result], *, names: bool = True) -> str:
    """A short table: one line per submission, with the reason where there is no plain mark.

    Args:
        marks: results.
        names: whether students are named; reasons, which may hold a name, go with them.
    """
    rows = [("student", "assignment", "mark", "")]
    rows += [
        (one_line(r.student), r.assignment, f"{r.score}/{r.max_score}", _remark(r, names))
        for r in marks
    ]
    rows = rows if names else [rows[0], *sorted(rows[1:], key=lambda row: row[1:])]
    widths = [max(len(row[column]) for row in rows) for column in range(3)]
    shown = range(0 if names else 1, 3)
    lines = ["  ".join([*(row[n].ljust(widths[n]) for n in shown), row[3]]) for row in rows]
    return "\n".join(line.rstrip() for line in lines)


def _remark(result: Result, names: bool) -> str:
    if result.status != "graded":
        return f"{result.status}: {one_line(result.reason)}" if names else result.status
    lost = [exercise.name for exercise in result.exercises if exercise.status != "passed"]
    if not lost:
        return "all passed" if has_hidden(result.exercises) else "public checks passed"
    return "nothing passed" if not result.score else f"lost marks in {', '.join(lost)}"


def check_line(exercise: ExerciseResult, hidden: Mapping[str, int] | None) -> str:
    """How an exercise of a student's own check went, with the first message where it failed.

    Args:
        exercise: its result, of the visible cases.
        hidden: per exercise how many hidden cases there are; None where that is not known.
    """
    if exercise.status == "passed":
        left = None if hidden is None else hidden.get(exercise.name, 0)
        return f"✓ passed   {exercise.name} (visible cases; {remaining(left)})"
    where = f" ({', '.join(failed)})" if (failed := failed_cases(exercise)) else ""
    first, *more = exercise.message.split("\n")
    lines = [f"✗ {exercise.status:<8} {exercise.name}{where}: {one_line(first)}"]
    if exercise.status in ("timeout", "died"):
        lines[0] += f" {ADVICE[exercise.status]}"
    return "\n".join([*lines, *(f"    {one_line(line)}" for line in more)])


def check_end(result: Result, hidden: Mapping[str, int] | None) -> str:
    """The last lines of a student's own check."""
    notes = [f"Note: {one_line(result.reason)}"] if result.reason else []
    return "\n".join([*notes, check_verdict(result, hidden)])
