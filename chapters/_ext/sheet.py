"""The cheat sheet: each row of its tables is a card, and chips lead to the lessons.

A table in a ``{div}`` of the class ``rs-sheet`` has a lesson and an idea in each row, or an idea
and its chapters, and in the cell of the idea a name and, after a ``<br>``, a formula. Where no
lesson is named it is the one in the heading, and there the symbols have the course's colours.
"""

from __future__ import annotations

import re
from typing import Any

from bs4 import BeautifulSoup, Tag
from sphinx.application import Sphinx

SYMBOLS = {"u": "outlier", "w": "estimate", "c": "ochre", "μ": "accent"}
"""The residual, its weight, the threshold and the control of graduation."""


def rewrite(
    app: Sphinx, page: str, template: str, context: dict[str, Any], doctree: object
) -> None:
    """Make cards and chips of the tables of a page that has some."""
    if 'class="rs-sheet' not in context.get("body", ""):
        return
    soup = BeautifulSoup(context["body"], "html.parser")
    for place in soup.select(".rs-sheet"):
        if place.tbody is None:
            continue
        cards = soup.new_tag("ul", attrs={"class": "rs-cards-of-ideas"})
        cards.extend([_card(soup, row) for row in place.tbody.find_all("tr")])
        place.clear()
        place.append(cards)
    _lead(soup)
    context["body"] = str(soup)


def _card(soup: BeautifulSoup, row: Tag) -> Tag:
    card = soup.new_tag("li")
    first, second = row.find_all("td")
    is_numbered = re.fullmatch(r"L\d+", first.get_text(strip=True))
    idea, beside = (second, first) if is_numbered else (first, second)
    for letter in () if is_numbered else idea.select("mi"):
        if letter.get_text() in SYMBOLS:
            letter["class"] = f"rs-is-{SYMBOLS[letter.get_text()]}"
    label = soup.new_tag("span", attrs={"class": "rs-lesson"})
    label.append("" if is_numbered else "Chapter ")
    label.extend(list((beside.p or beside).contents))
    parts = list((idea.p or idea).contents)
    at = next(k for k, part in enumerate(parts) if getattr(part, "name", "") == "br")
    for kind, own in (("rs-name", parts[:at]), ("rs-formula", parts[at + 1 :])):
        part = soup.new_tag("div", attrs={"class": kind})
        part.extend(own)
        card.append(part)
    *_, last = card.div.find_all(string=True)
    last.replace_with(last.rstrip(": "))
    card.insert(0, label)
    return card


def _lead(soup: BeautifulSoup) -> None:
    """Put the chips, one for each lesson, above the first card of all."""
    lessons: dict[str, Tag] = {}
    for cards in soup.select(".rs-cards-of-ideas"):
        heading = cards.find_previous("h2")
        of_all = re.search(r"L\d+", heading.get_text()) if heading else None
        for card in cards.find_all("li"):
            own = card.find(class_="rs-lesson").get_text(strip=True)
            lessons.setdefault(of_all[0] if of_all else own, card)
    chips = soup.new_tag("nav", attrs={"class": "rs-chips", "aria-label": "Lessons"})
    for lesson in sorted(lessons, key=lambda name: int(name[1:])):
        lessons[lesson]["id"] = lesson.lower()
        chip = soup.new_tag("a", attrs={"href": f"#{lesson.lower()}"})
        chip.string = lesson
        chips.append(chip)
    if first := soup.select_one("section section"):
        first.insert_before(chips)


def setup(app: Sphinx) -> dict[str, Any]:
    """Connect the above to the build, behind the formulas and tables of all pages."""
    app.connect("html-page-context", rewrite, priority=600)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
