"""The marks in the chapters' sources that say what becomes a slide.

A cell's metadata may hold ``slides``, a list with one entry for each slide:

- ``title`` and ``ask``: a claim, and the question above what is shown: what a slide says in words
  that are not the page's. The claim answers the question, so a key reveals it;
- ``setup``: what has to be known before the question: what is seen, and what names mean;
- ``later``: what of the thing shown would answer the question, and waits: for each key a selector
  of style sheets, or ``each li`` for one key an item; of a figure also ``data`` or its ``lines``
  or ``markers`` alone. A text's formula, table or list waits whole where none is given;
- ``claims``: words of each claim of the slides before that stands on a summary again;
- ``show``: what is shown. At a code cell it is its output, or ``question 2`` of a quiz; at text it
  is the ``formula``, ``table`` or ``list`` of the page that has the words after it;
- ``panels``: the numbers of a figure's panels that are shown, each as large as it can be; the
  figure's legend counts as its last;
- ``state`` and ``answer``: what differs from the first state of the live picture that is shown,
  and from this where it answers the question;
- ``notes``: for the lecturer alone: the answer, and what to drag;
- ``work``: minutes that the class works by itself;
- ``after``: the cell after whose slides this one comes, where that is not its own.
"""

import json
from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

KEY = "slides"

WORDS = 130
"""Spoken in a minute, those of the slide and of the notes."""
PAUSES = {"vote": 2.25, "ask": 1.75, "look": 1.0, "key": 0.1}
"""Minutes to look at a slide, with a vote or a question or without, and for a key."""


class BadMark(ValueError):
    """A mark that cannot become a slide; the message names the chapter and the cell."""


@dataclass(frozen=True)
class Mark:
    """What one slide holds."""

    place: str
    """The notebook and the cell, for messages."""
    code: int | None
    """Which of the page's code cells it stands at; none for text."""
    title: str
    show: str
    ask: str = ""
    setup: str = ""
    later: Sequence[str] | None = None
    claims: Sequence[str] = ()
    panels: Sequence[int] = ()
    state: dict[str, Any] = field(default_factory=dict)
    answer: dict[str, Any] = field(default_factory=dict)
    notes: str = ""
    work: float = 0.0
    after: str = ""


NAMES = {each.name for each in fields(Mark)} - {"place", "code"}


def read(notebook: Path) -> list[Mark]:
    """Return a chapter's marks in their order.

    Raises:
        BadMark: an entry has an unknown key, no title, or nothing to say or to show.
    """
    marks, code = [], -1
    cells = json.loads(notebook.read_text(encoding="utf-8"))["cells"]
    places = {cell["id"]: number for number, cell in enumerate(cells)}
    for cell in cells:
        is_code = cell["cell_type"] == "code"
        code += is_code
        for entry in cell["metadata"].get(KEY, []):
            place = f"{notebook.name}, cell {cell['id']}"
            mark = _mark(entry, place, code if is_code else None)
            if (after := mark.after or cell["id"]) not in places:
                raise BadMark(f"{place}: there is no cell {after!r} for it to come `after`")
            marks.append((places[after], bool(mark.after), mark))
    return [mark for *_, mark in sorted(marks, key=lambda each: each[:2])]


def _mark(entry: dict[str, Any], place: str, code: int | None) -> Mark:
    if unknown := set(entry) - NAMES:
        raise BadMark(f"{place}: {sorted(unknown)} is unknown; use {sorted(NAMES)}")
    if not entry.get("title"):
        raise BadMark(f"{place}: give the slide a `title`, a sentence that claims something")
    if code is None and not entry.keys() & {"show", "claims"}:
        raise BadMark(f"{place}: say what of the text it is to `show`")
    return Mark(place, code, **{"show": "" if code is None else "output"} | entry)
