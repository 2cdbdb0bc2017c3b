"""Results as text for a terminal: ✓ and ✗, always with a word."""

from __future__ import annotations

from collections.abc import Sequence

from robust_slam_autograder.results import ExerciseResult, Result


def marks_table(marks: Sequence[Result]) -> str:
    """A short table: one line per submission, with the reason where there is no plain mark."""
    rows = [("student", "assignment", "mark", "")]
    rows += [(r.student, r.assignment, f"{r.score}/{r.max_score}", _remark(r)) for r in marks]
    widths = [max(len(row[column]) for row in rows) for column in range(3)]
    lines = [
        "  ".join([*(cell.ljust(width) for cell, width in zip(row, widths, strict=False)), row[3]])
        for row in rows
    ]
    return "\n".join(line.rstrip() for line in lines)


def _remark(result: Result) -> str:
    if result.status != "graded":
        return f"{result.status}: {result.reason}"
    lost = [exercise.name for exercise in result.exercises if exercise.status != "passed"]
    if not lost:
        return "all passed"
    return "nothing passed" if not result.score else f"lost marks in {', '.join(lost)}"


def check_report(result: Result) -> str:
    """Exercise by exercise what passed, with the first message of each that did not."""
    lines = [_exercise_line(exercise) for exercise in result.exercises]
    if result.reason:
        lines.append(f"Note: {result.reason}")
    passed = sum(exercise.status == "passed" for exercise in result.exercises)
    total = len(result.exercises)
    verdict = "Public checks passed" if passed == total else "Not all public checks passed"
    lines.append(f"{verdict}: {passed} of {total} exercises. Grading runs hidden checks too.")
    return "\n".join(lines)


def _exercise_line(exercise: ExerciseResult) -> str:
    if exercise.status == "passed":
        return f"✓ passed   {exercise.name}"
    failed = [case.name for case in exercise.cases if case.earned < case.points]
    where = f" ({', '.join(failed)})" if exercise.status in ("partial", "failed") else ""
    return f"✗ {exercise.status:<8} {exercise.name}{where}: {exercise.message}"
