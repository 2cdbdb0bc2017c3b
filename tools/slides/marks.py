"""The marks in the chapters' sources that say what becomes a slide.

A cell's metadata may hold ``slides``, a list with one entry for each slide:

- ``title`` and ``ask``: a claim, and the question above what is shown: what a slide says in words
  that are not the page's. The claim answers the question, so the vote or a key reveals it;
- ``say``: words of each sentence of the page that stands on the slide;
- ``then``: the same, for what the next keys reveal, such as the answer to a question;
- ``show``: what is shown. At a code cell it is ``output`` (where nothing is given), ``code``,
  ``both`` or ``question 2`` of a quiz; at text it is the next ``formula``, ``table``, ``list`` or
  ``box`` after the sentence, or with a minus, as in ``-formula``, the last one before it;
- ``panels``: the numbers of a figure's panels that are shown, each as large as it can be; the
  figure's legend counts as its last;
- ``state``: what differs from the first state of the live picture that is shown;
- ``notes``: for the lecturer alone: the answer, and what to drag;
- ``after``: the cell after whose slides this one comes, where that is not its own.
"""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

KEY = "slides"
NAMES = {"title", "ask", "say", "then", "show", "panels", "state", "notes", "after"}

WORDS = 130
"""Spoken in a minute, those of the slide and of the notes."""
PAUSES = {"vote": 1.25, "ask": 0.75, "drag": 1.0, "look": 1.0}
"""Minutes for a vote, a question, a picture to drag, and anything else to look at."""


class BadMark(ValueError):
    """A mark that cannot become a slide; the message names the chapter and the cell."""


@dataclass(frozen=True)
class Mark:
    """What one slide holds."""

    place: str
    """The notebook and the cell, for messages."""
    code: int | None
    """Which of the page's code cells it stands at; none for text."""
    say: tuple[str, ...]
    then: tuple[str, ...]
    show: str
    title: str
    ask: str
    panels: tuple[int, ...]
    state: dict[str, Any]
    notes: str


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
            if (after := entry.get("after", cell["id"])) not in places:
                raise BadMark(f"{place}: there is no cell {after!r} for it to come `after`")
            mark = _mark(entry, place, code if is_code else None)
            marks.append((places[after], "after" in entry, mark))
    return [mark for *_, mark in sorted(marks, key=lambda each: each[:2])]


def _mark(entry: dict[str, Any], place: str, code: int | None) -> Mark:
    if unknown := set(entry) - NAMES:
        raise BadMark(f"{place}: {sorted(unknown)} is unknown; use {sorted(NAMES)}")
    if not entry.get("title"):
        raise BadMark(f"{place}: give the slide a `title`, a sentence that claims something")
    if code is None and not entry.get("say"):
        raise BadMark(f"{place}: give the words of a sentence in `say`")
    show = entry.get("show", "" if code is None else "output")
    return Mark(
        place, code, _several(entry.get("say")), _several(entry.get("then")), show,
        entry["title"], entry.get("ask", ""), tuple(entry.get("panels", ())),
        entry.get("state", {}), entry.get("notes", ""),
    )  # fmt: skip


def _several(value: str | list[str] | None) -> tuple[str, ...]:
    return (value,) if isinstance(value, str) else tuple(value or ())
