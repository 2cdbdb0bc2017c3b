"""Results as text for a terminal: ✓, ◐ and ✗, always with a word."""

from collections.abc import Mapping, Sequence

from robust_slam_autograder.grading.results import ExerciseResult, Result
from robust_slam_autograder.grading.verdicts import (
    ADVICE,
    FAULTS,
    check_verdict,
    failed_cases,
    has_hidden,
    losses,
    remaining,
    sign,
)
from robust_slam_autograder.markup import one_line


def aligned(rows: Sequence[Sequence[str]]) -> list[str]:
    """Return a table's lines, the head first: columns are as wide as their widest cell."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return [
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in rows
    ]


def marks_table(marks: Sequence[Result], *, names: bool = True) -> str:
    """Return a short table: one line per submission, with the reason where there is no plain mark.

    Without names there are no reasons, which may hold one.
    """
    rows = [("student", "assignment", "mark", "")]
    rows += [
        (one_line(r.student), r.assignment, f"{r.score}/{r.max_score}", _remark(r, names))
        for r in marks
    ]
    if not names:
        head, *others = (row[1:] for row in rows)
        return "\n".join(aligned([head, *sorted(others)]))
    return "\n".join(aligned(rows))


def _remark(result: Result, names: bool) -> str:
    if result.status != "graded":
        return f"{result.status}: {one_line(result.reason)}" if names else result.status
    if not (lost := losses(result)):
        return "all passed" if has_hidden(result.exercises) else "public checks passed"
    is_told = result.score or any(exercise.status in FAULTS for exercise in result.exercises)
    return f"lost marks in {', '.join(lost)}" if is_told else "nothing passed"


def check_line(
    exercise: ExerciseResult,
    hidden: Mapping[str, int] | None,
    place: str = "",
    hints: Sequence[str] = (),
) -> str:
    """Say how the visible cases of an exercise went, with the first message.

    Args:
        exercise: how it ended.
        hidden: how many hidden cases each exercise has; None where that is not known.
        place: where its matter stands in the book.
        hints: to be told where it did not pass.
    """
    if exercise.status == "passed":
        left = None if hidden is None else hidden.get(exercise.name, 0)
        return f"✓ passed   {exercise.name} (visible cases; {remaining(left)})"
    where = f" ({', '.join(failed)})" if (failed := failed_cases(exercise)) else ""
    first, *more = exercise.message.split("\n")
    lines = [f"{sign(exercise.status):<10} {exercise.name}{where}: {one_line(first)}"]
    if exercise.status in FAULTS:
        lines[0] += f" {ADVICE[exercise.status]}"
    if exercise.misconception:
        more.append(f"It looks as if {exercise.misconception}.")
        more += [f"Read again: {place}."] if place else []
    more += [f"Hint {number}: {hint}" for number, hint in enumerate(hints, start=1)]
    return "\n".join([*lines, *(f"    {one_line(line)}" for line in more)])


def check_end(result: Result, hidden: Mapping[str, int] | None) -> str:
    """Return the last lines of a student's own check."""
    notes = [f"Note: {one_line(result.reason)}"] if result.reason else []
    return "\n".join([*notes, check_verdict(result, hidden)])
