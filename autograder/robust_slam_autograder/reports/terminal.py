"""Results as text for a terminal: ✓ and ✗, always with a word."""

from __future__ import annotations

from collections.abc import Sequence

from robust_slam_autograder.grading.results import ExerciseResult, Result
from robust_slam_autograder.reports.markup import one_line
from robust_slam_autograder.reports.verdict import (
    ADVICE,
    check_verdict,
    failed_cases,
    has_hidden,
)


def marks_table(marks: Sequence[Result], *, names: bool = True) -> str:
    """A short table: one line per submission, with the reason where there is no plain mark.

    Args:
        marks: results.
        names: whether students are named; reasons, which may hold a name, go with them.
    """
    rows = [("student", "assignment", "mark", "")]
    rows += [
        (r.student, r.assignment, f"{r.score}/{r.max_score}", _remark(r, names)) for r in marks
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


def check_report(result: Result) -> str:
    """Exercise by exercise what passed, with the first message of each that did not."""
    lines = [_exercise_line(exercise) for exercise in result.exercises]
    if result.reason:
        lines.append(f"Note: {one_line(result.reason)}")
    lines.append(check_verdict(result))
    return "\n".join(lines)


def _exercise_line(exercise: ExerciseResult) -> str:
    if exercise.status == "passed":
        return f"✓ passed   {exercise.name}"
    where = f" ({', '.join(failed)})" if (failed := failed_cases(exercise)) else ""
    said = f"✗ {exercise.status:<8} {exercise.name}{where}: {one_line(exercise.message)}"
    stopped = exercise.status in ("timeout", "died")
    return f"{said} {ADVICE[exercise.status]}" if stopped else said
