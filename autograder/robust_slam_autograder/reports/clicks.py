"""Hints below a cell of a notebook, each behind a click."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape

from robust_slam_autograder.grading.results import Result

STEPS = ("Where to look", "What to compute by hand", "The idea")


def html(result: Result, hints: Mapping[str, tuple[str, ...]]) -> str:
    """Return the hints for exercises that did not pass, as a piece of a page; it may be empty."""
    found = []
    for exercise in result.exercises:
        if exercise.status != "passed" and exercise.name in hints:
            steps = zip(STEPS, hints[exercise.name], strict=False)
            clicks = (
                f"<details><summary>{step}</summary>{escape(hint)}</details>"
                for step, hint in steps
            )
            head = f"<p><code>{escape(exercise.name)}</code>: hints for the whole exercise</p>"
            found.append(head + "".join(clicks))
    return "\n".join(found)
