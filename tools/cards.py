"""``python -m tools.cards``: flash cards for Anki, one for each row of two pages' tables.

The pages are *Symbols*, whose terms and kernels each make a card, and the *Cheat sheet*, whose
ideas ask for their formulas. Nothing is written twice: a row that changes is a card that changes,
and keeps what Anki knows about it as long as its front stays.
"""

import re
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path

import genanki
from markdown_it import MarkdownIt
from markdown_it.token import Token
from mdit_py_plugins.dollarmath import dollarmath_plugin

ROOT = Path(__file__).resolve().parents[1]
PAGES = {"Symbols": "chapters/symbols.md", "Cheat sheet": "chapters/cheat-sheet.md"}
TARGET = ROOT / "build" / "cards" / "robust-slam.apkg"
IDEA = "Idea and formula"
"""The column of the cheat sheet whose first line is a question."""
DECK, MODEL = 1_705_340_114, 1_705_340_115
"""Numbers by which Anki knows the deck and the kind of card again."""
_CITED = re.compile(r"\s*\{cite:p\}`[^`]*`")


@dataclass(frozen=True)
class Card:
    """Two sides in HTML, with TeX between brackets; ``page`` and ``heading`` are its place."""

    front: str
    back: str
    page: str
    heading: str


def cards(root: Path = ROOT) -> list[Card]:
    """Return a card for each row of the pages' tables, but for kernels that come a second time."""
    found: dict[str, Card] = {}
    for page, path in PAGES.items():
        for card in _of_page(root / path, page):
            found.setdefault(card.front, card)
    return list(found.values())


def _of_page(path: Path, page: str) -> Iterator[Card]:
    """Yield the cards of a page.

    Raises:
        ValueError: the page has no tables.
    """
    text = _CITED.sub("", path.read_text(encoding="utf-8"))
    lines = [line for line in text.splitlines() if not line.startswith(":::")]
    parser = MarkdownIt("commonmark").enable("table").use(dollarmath_plugin)
    tokens = parser.parse("\n".join(lines))
    heading, header, row = "", [""], [""]
    count = 0
    for token, before in zip(tokens[1:], tokens, strict=False):
        if before.type == "heading_open":
            heading = _html(token)
        elif before.type == "tr_open":
            row = []
        elif before.type in ("th_open", "td_open"):
            row.append(_html(token))
        elif before.type == "thead_close":
            header = row
        elif before.type == "tr_close" and row is not header and token.type != "thead_close":
            count += 1
            yield Card(*_sides(header, row), page, heading)
    if not count:
        raise ValueError(f"{path}: no table; cards are made of the rows of tables")


def _sides(header: Sequence[str], row: Sequence[str]) -> tuple[str, str]:
    """Return what a row asks, and the answer."""
    if IDEA in header:
        front, _, back = row[header.index(IDEA)].partition("<br>")
        return front.removesuffix(":"), back
    named = zip(header[1:], row[1:], strict=True)
    return row[0], "<br>".join(
        text if name == "Meaning" else f"{name}: {text}" for name, text in named if text
    )


def _html(inline: Token) -> str:
    """Return a cell as HTML; of links it has the text."""
    made = {"math_inline": r"\({}\)", "code_inline": "<code>{}</code>", "text": "{}"}
    parts = [
        made[each.type].format(escape(each.content, quote=False))
        if each.type in made
        else each.content
        if each.type == "html_inline"
        else f"<{'/' if each.nesting < 0 else ''}{each.tag}>"
        if each.type.startswith(("em_", "strong_"))
        else ""
        for each in inline.children or ()
    ]
    return "".join(parts).strip()


def deck(found: Sequence[Card]) -> genanki.Deck:
    """Return Anki's deck of the cards."""
    model = genanki.Model(
        MODEL,
        "Robust SLAM",
        fields=[{"name": name} for name in ("Front", "Back", "From")],
        templates=[
            {
                "name": "Card",
                "qfmt": "{{Front}}<p><small>{{From}}</small></p>",
                "afmt": "{{FrontSide}}<hr id=answer>{{Back}}",
            }
        ],
        css=".card { font: 20px sans-serif; text-align: center; }",
    )
    made = genanki.Deck(DECK, "Robust SLAM")
    for card in found:
        fields = [card.front, card.back, f"{card.page}: {card.heading}"]
        guid = genanki.guid_for(card.page, card.front)
        made.add_note(genanki.Note(model=model, fields=fields, guid=guid))
    return made


def main() -> int:
    """Write the deck and say where it is."""
    found = cards()
    TARGET.parent.mkdir(parents=True, exist_ok=True)
    genanki.Package(deck(found)).write_to_file(TARGET)
    print(f"{len(found)} cards are in {TARGET.relative_to(ROOT)}; open it with Anki.")
    return 0


if __name__ == "__main__":
    sys.exit(main())
