"""A feedback page as HTML and as Markdown.

Markdown holds other people's text in code spans alone.
"""

from __future__ import annotations

from collections.abc import Iterator

from robust_slam_autograder.markup import cell, code, prose
from robust_slam_autograder.reports import documents
from robust_slam_autograder.reports.feedback import Page, Reading, ShownCase, ShownExercise


def html(page: Page, notice: str = "") -> str:
    """Return the page as one self-contained file, with a notice at its top where there is one."""
    return documents.html("feedback", page=page, notice=notice)


def markdown(page: Page) -> str:
    """Return the page as Markdown, as GitHub shows it."""
    return "\n".join(_lines(page)) + "\n"


def _lines(page: Page) -> Iterator[str]:
    yield f"## {prose(page.title)}: {page.score} of {page.max_score} points"
    if page.student:
        yield f"\nStudent: {code(page.student)}"
    yield f"\n{page.verdict}"
    if page.note:
        yield f"\n{page.note_kind}: {code(page.note)}"
    start = f"Start with {code(page.start.name)}. " if page.start else ""
    yield f"\n**What to do next:** {start}{page.next}"
    if page.exercises:
        yield "\n| exercise | outcome | points |\n| --- | --- | --- |"
    for exercise in page.exercises:
        yield f"| {cell(exercise.name)} | {exercise.outcome} | {exercise.points} |"
    for exercise in page.exercises:
        yield from _exercise(exercise)


def _exercise(exercise: ShownExercise) -> Iterator[str]:
    yield f"\n### {code(exercise.name)}: {exercise.outcome}, {exercise.points}"
    yield f"\n{exercise.meaning} {exercise.advice}".rstrip()
    if exercise.message:
        yield f"\n{code(exercise.message)}"
    if exercise.reading:
        yield f"\nRead again: {_link(exercise.reading)}"
    yield ""
    yield from map(_case, exercise.cases)


def _case(case: ShownCase) -> str:
    tag = ", checked with other inputs too" if case.other_inputs else ""
    said = "the same as above" if case.as_above else code(case.message)
    message = f": {said}" if said else ""
    return f"- {case.outcome} {code(case.name)} ({case.points}{tag}){message}"


def _link(reading: Reading) -> str:
    text = prose(reading.text)
    # In angle brackets an address may hold all but these.
    address = reading.address.replace("<", "%3C").replace(">", "%3E").replace("\n", "")
    return f"[{text}](<{address}>)" if address else text
