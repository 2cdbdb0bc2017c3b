"""Hints, each behind a click that tells how much it says."""

from collections.abc import Iterable, Iterator, Mapping
from html import escape

from robust_slam_autograder.grading.results import Result

STEPS = ("Where to look", "What to compute by hand", "The idea")


def named(hints: Iterable[str]) -> Iterator[tuple[str, str]]:
    """Yield hints, each behind what its click says."""
    for number, hint in enumerate(hints):
        yield STEPS[number] if number < len(STEPS) else "One more hint", hint


def html(result: Result, hints: Mapping[str, tuple[str, ...]]) -> str:
    """Return hints for below a cell, on exercises that did not pass; it may be empty."""
    found = []
    for exercise in result.exercises:
        if exercise.status != "passed" and exercise.name in hints:
            clicks = (
                f"<details><summary>{step}</summary>{escape(hint)}</details>"
                for step, hint in named(hints[exercise.name])
            )
            head = f"<p><code>{escape(exercise.name)}</code>: hints for the whole exercise</p>"
            found.append(head + "".join(clicks))
    return "\n".join(found)
