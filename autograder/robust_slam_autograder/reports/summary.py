"""A batch as JSON and as Markdown, for a job's summary page and for other programs.

No seed, no time and no message of a check is in it: without names it may be public.
A student's own check, as Markdown, has the messages: they are the student's.
"""

import json
from collections.abc import Mapping, Sequence
from typing import Any

from robust_slam_autograder.grading.results import ExerciseResult, Result
from robust_slam_autograder.grading.verdicts import (
    check_verdict,
    failed_cases,
    losses,
    sign,
    verdict,
)
from robust_slam_autograder.markup import cell, code, one_line, visible

SCHEMA = 1


def as_json(marks: Sequence[Result], counts: Mapping[str, int], *, names: bool) -> str:
    """Return the batch as JSON, with how many were graded, refused, failed, and kept from before.

    Without names neither the students' order nor a file's name tells who it is.
    """
    value = {
        "schema": SCHEMA,
        "counts": dict(counts),
        "submissions": [_entry(result, names=names) for result in _ordered(marks, names=names)],
    }
    return json.dumps(value, indent=1, ensure_ascii=False) + "\n"


def _ordered(marks: Sequence[Result], *, names: bool) -> list[Result]:
    """Order results; without names by the marks, for the order of names is told to no one."""
    if names:
        return list(marks)
    return sorted(marks, key=lambda r: (r.assignment, -r.score, r.status, losses(r)))


def _entry(result: Result, *, names: bool) -> dict[str, Any]:
    exercises = [
        {"name": e.name, "score": e.score, "max_score": e.max_score, "status": e.status}
        for e in result.exercises
    ]
    return {
        **({"student": visible(result.student)} if names else {}),
        "assignment": result.assignment,
        "score": result.score,
        "max_score": result.max_score,
        "status": result.status,
        **({"reason": one_line(_reason(result))} if names else {}),
        "exercises": exercises,
    }


def _reason(result: Result) -> str:
    """Return why it was refused, or what was unusual, but not why the grader failed."""
    return "" if result.status == "failed" else result.reason


def as_markdown(marks: Sequence[Result], counts: Mapping[str, int], *, names: bool) -> str:
    """Return the batch as a Markdown table."""
    columns = ["student"] * names + ["assignment", "mark", "outcome"]
    table = [columns, ["---"] * len(columns)]
    for result in _ordered(marks, names=names):
        mark, outcome = f"{result.score}/{result.max_score}", _outcome(result, names=names)
        table.append([cell(result.student)] * names + [cell(result.assignment), mark, outcome])
    told = ", ".join(f"{counts[key]} {key}" for key in ("graded", "refused", "failed"))
    lines = ["## Grading", "", f"{told}.", "", *(f"| {' | '.join(row)} |" for row in table)]
    return "\n".join(lines) + "\n"


def _outcome(result: Result, *, names: bool) -> str:
    if result.status != "graded":
        reason = cell(_reason(result)) if names else ""
        return f"✗ {result.status}{reason and f': {reason}'}"
    if lost := losses(result):
        return f"✗ lost points in {', '.join(map(cell, lost))}"
    return f"✓ {verdict(result)}"


def check_as_markdown(result: Result, hidden: Mapping[str, int] | None) -> str:
    """Return a student's own check without points; ``hidden`` as in the verdict."""
    note = [f"Note: {code(result.reason)}", ""] if result.reason else []
    lines = ["## Visible cases", "", check_verdict(result, hidden), "", *note]
    lines += [f"- {_checked(exercise)}" for exercise in result.exercises]
    return "\n".join(lines) + "\n"


def _checked(exercise: ExerciseResult) -> str:
    names = ", ".join(map(code, failed_cases(exercise)))
    told = "  \n  ".join(filter(None, map(code, exercise.message.split("\n"))))
    head = f"{sign(exercise.status)} {code(exercise.name)}{names and f' ({names})'}"
    return f"{head}: {told}" if told else head
