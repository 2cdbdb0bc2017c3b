"""A feedback page as HTML and as Markdown.

The HTML page asks for nothing: no script, no font, no picture from elsewhere, and its
policy forbids it. Markdown holds other people's text in code spans alone.
"""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Iterator
from importlib import resources

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from robust_slam_autograder.reports.feedback import Case, Exercise, Page, Reading
from robust_slam_autograder.reports.markup import cell, code, one_line, prose

TEMPLATE = "feedback.html"
STYLE = "feedback.css"


def html(page: Page) -> str:
    """The page as one self-contained file."""
    templates = Environment(
        loader=PackageLoader(__package__),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    style = resources.files(__package__).joinpath("templates", STYLE).read_text("utf-8")
    digest = base64.b64encode(hashlib.sha256(style.encode()).digest()).decode()
    return templates.get_template(TEMPLATE).render(
        page=page, style=Markup(style), style_digest=digest, one_line=one_line
    )


def markdown(page: Page) -> str:
    """The page as Markdown, as GitHub shows it."""
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


def _exercise(exercise: Exercise) -> Iterator[str]:
    yield f"\n### {code(exercise.name)}: {exercise.outcome}, {exercise.points}"
    yield f"\n{exercise.meaning} {exercise.advice}".rstrip()
    if exercise.message:
        yield f"\n{code(exercise.message)}"
    if exercise.reading:
        yield f"\nRead again: {_link(exercise.reading)}"
    yield ""
    yield from map(_case, exercise.cases)


def _case(case: Case) -> str:
    tag = ", checked with other inputs too" if case.other_inputs else ""
    said = "the same as above" if case.as_above else code(case.message)
    message = f": {said}" if said else ""
    return f"- {case.outcome} {code(case.name)} ({case.points}{tag}){message}"


def _link(reading: Reading) -> str:
    text = prose(reading.text)
    # In angle brackets an address may hold all but these.
    address = reading.address.replace("<", "%3C").replace(">", "%3E").replace("\n", "")
    return f"[{text}](<{address}>)" if address else text
