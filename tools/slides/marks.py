"""The marks in the chapters' sources that say what becomes a slide.

A cell's metadata may hold ``slides``, a list with one entry for each slide:

- ``title`` and ``ask``: the slide's heading, a claim, and the question above what is shown: what a
  slide says in words that are not the page's;
- ``say``: words of each sentence of the page that stands on the slide;
- ``then``: the same, for what the next keys reveal, such as the answer to a question;
- ``show``: what is shown. At a code cell it is ``output`` (where nothing is given), ``code``,
  ``both`` or ``question 2`` of a quiz; at text it is the next ``formula``, ``table``, ``list`` or
  ``box`` after the sentence, or with a minus, as in ``-formula``, the last one before it;
- ``state``: what differs from the first state of the live picture that is shown;
- ``notes`` and ``minutes``: for the lecturer alone.
"""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

KEY = "slides"
NAMES = {"title", "ask", "say", "then", "show", "state", "notes", "minutes"}


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
    state: dict[str, Any]
    notes: str
    minutes: float


def read(notebook: Path) -> list[Mark]:
    """Return a chapter's marks in their order.

    Raises:
        BadMark: an entry has an unknown key, no title, or nothing to say or to show.
    """
    marks, code = [], -1
    for cell in json.loads(notebook.read_text(encoding="utf-8"))["cells"]:
        is_code = cell["cell_type"] == "code"
        code += is_code
        for entry in cell["metadata"].get(KEY, []):
            place = f"{notebook.name}, cell {cell['id']}"
            marks.append(_mark(entry, place, code if is_code else None))
    return marks


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
        entry["title"], entry.get("ask", ""), entry.get("state", {}), entry.get("notes", ""),
        float(entry.get("minutes", 2)),
    )  # fmt: skip


def _several(value: str | list[str] | None) -> tuple[str, ...]:
    return (value,) if isinstance(value, str) else tuple(value or ())
