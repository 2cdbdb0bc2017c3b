"""Text, tables, citations, bibliography and folded code that screen readers and phones can use.

A table of sentences becomes a list of cards where the window is narrow: each cell then shows the
name of its column, and the roles say that it still is a table. A citation that is pointed at, or
that the keyboard has reached, shows what is cited.

On the cheat sheet each row of a table is a card, and chips lead to the lessons. Its tables stand
in a ``{div}`` of the class ``rs-sheet``, and have a lesson and an idea in each row, or an idea and
its chapters, and in the cell of the idea a name and, after a ``<br>``, a formula. Where no lesson
is named it is the one in the heading, and there the symbols have the course's colours.
"""

import re
from typing import Any

from bs4 import BeautifulSoup, Tag
from docutils import nodes
from sphinx.application import Sphinx

from . import TEMPLATES

COLUMNS, LETTERS, SHORT = 3, 80, 26
"""From how many columns, and letters in the longest cells of a row, a table becomes cards; up to
how many letters in each cell behind the first it is one of short values, which are not broken."""
WORD_JOINER = "\u2060"
"""Stands beside a formula that is a header: to axe-core a formula alone is an empty cell."""
CITATION = re.compile(
    r'<a (?=class="reference internal" href="[^"]*references\.html#[^"]*" title)'
)
TOOLTIP = r'<a data-bs-toggle="tooltip" '
"""The theme shows the title of such a link by mouse and keyboard."""
ENTRY = re.compile(r'role="doc-biblioentry">\s*<span class="label">.*?</span></span>')
TOGETHER = re.compile(
    r"(?<=\d) (?=(?:m|cm|km|s|ms|rad|Hz|kB|MB|GB)\b|[%°])"
    r"|(?<=\w) (?=[=≤≥<>≈−] \S)|(?<=\w [=≤≥<>≈−]) "
)
"""A space between a number and its unit, or beside the sign of a relation or of a difference."""
SHEET = 'class="rs-sheet'
LESSON = re.compile(r"L\d+")
SYMBOLS = {"u": "outlier", "w": "estimate", "c": "ochre", "μ": "accent"}
"""The residual, its weight, the threshold and the control of graduation."""
COLON = re.compile(r"[: ]+((?:</\w+>)*)$")
ROLES = {"thead": "rowgroup", "tbody": "rowgroup", "tr": "row", "td": "cell"}


def keep_together(app: Sphinx, doctree: nodes.document, page: str) -> None:
    """Let no line end between a number and its unit, in the text outside code and formulas."""
    apart = nodes.literal | nodes.literal_block | nodes.math | nodes.math_block | nodes.raw
    for text in list(doctree.findall(nodes.Text)):
        if (kept := TOGETHER.sub("\u00a0", text)) != text and not isinstance(text.parent, apart):
            text.parent.replace(text, nodes.Text(kept))


def rewrite(app: Sphinx, page: str, template: str, context: dict[str, Any], *_: object) -> None:
    """Rewrite the tables, citations, bibliography and folded code of a page."""
    if "body" in context:
        body = re.sub(r"<table.*?</table>", _table, context["body"], flags=re.S)
        # The name that MyST-NB gives to a folded cell is not what is written on it.
        body = body.replace(' aria-label="Toggle hidden content"', "")
        # An entry is an item of the list, without its number, by which no page cites it.
        context["body"] = ENTRY.sub(r'role="listitem">', CITATION.sub(TOOLTIP, body))


def _table(match: re.Match[str]) -> str:
    soup = BeautifulSoup(match[0], "html.parser")
    table = soup.table
    if table is None or table.thead is None or table.select("[rowspan], [colspan]"):
        return match[0]
    for code in table.select("td code .pre"):
        for text in code.find_all(string=re.compile("/.")):  # a path breaks where it must
            parts = text.split("/")
            text.replace_with(
                *(part for name in parts[:-1] for part in (f"{name}/", soup.new_tag("wbr"))),
                parts[-1],
            )
    for header in table.thead.find_all("th"):
        if not header.get_text(strip=True):
            header.name = "td"
        else:
            header["scope"] = "col"
        for formula in header.select(".math")[-1:]:
            formula.insert_after(WORD_JOINER)  # behind its paragraph it would be a second line
    rows = [row.find_all(["td", "th"]) for row in table.find_all("tr")]
    lengths = [max(len(_words(cell)) for cell in column) for column in zip(*rows, strict=True)]
    formulas = table.thead.select("math, .math")  # a label is plain text
    if len(lengths) < COLUMNS:
        return str(soup)
    if max(lengths[1:]) <= SHORT:
        table["class"] = [*table.get_attribute_list("class"), "rs-short"]
    elif sum(lengths) > LETTERS and not formulas:
        _make_cards(table, [_words(cell) for cell in rows[0]])
    return str(soup)


def _make_cards(table: Tag, labels: list[str]) -> None:
    table["class"] = [*table.get_attribute_list("class"), "rs-cards"]
    table["role"] = "table"
    for part in table.find_all(list(ROLES)):
        part["role"] = ROLES[part.name]
    for header in table.find_all("th"):
        header["role"] = "columnheader"
    for row in table.tbody.find_all("tr") if table.tbody else ():
        for cell, label in zip(row.find_all("td"), labels, strict=True):
            cell["data-label"] = label


def _words(cell: Tag) -> str:
    """Return the text of a cell, as it stands above its value on a card."""
    return cell.get_text(" ", strip=True)


def lay_out_the_sheet(
    app: Sphinx, page: str, template: str, context: dict[str, Any], doctree: nodes.document | None
) -> None:
    """Make cards of the tables of the cheat sheet, below a chip for each lesson."""
    if SHEET not in context.get("body", ""):
        return
    soup = BeautifulSoup(context["body"], "html.parser")
    lessons: list[str] = []
    for place in soup.select(".rs-sheet"):
        of_all = LESSON.search(place.find_previous("h2").get_text())
        cards = [_card(row) for row in place.select("tbody tr")]
        for card in cards:
            lesson = of_all[0] if of_all else card["label"]
            if lesson not in lessons:
                lessons.append(lesson)
                card["id"] = lesson.lower()
        html = TEMPLATES.get_template("sheet.html").render(cards=cards)
        place.clear()
        place.append(BeautifulSoup(html, "html.parser"))
    lessons.sort(key=lambda lesson: int(lesson[1:]))
    chips = "".join(f'<a href="#{lesson.lower()}">{lesson}</a>' for lesson in lessons)
    chips = f'<nav class="rs-chips" aria-label="Lessons">{chips}</nav>'
    soup.select_one("section section").insert_before(BeautifulSoup(chips, "html.parser"))
    context["body"] = str(soup)


def _card(row: Tag) -> dict[str, str]:
    """Return what a card shows, as HTML."""
    first, second = (cell.p or cell for cell in row.find_all("td"))
    is_numbered = LESSON.fullmatch(first.get_text(strip=True))
    idea, beside = (second, first) if is_numbered else (first, second)
    for letter in () if is_numbered else idea.select("mi"):
        if letter.get_text() in SYMBOLS:
            letter["class"] = f"rs-is-{SYMBOLS[letter.get_text()]}"
    name, _, formula = idea.decode_contents().partition("<br/>")
    label = beside.decode_contents()
    return {
        "label": label if is_numbered else f"Chapter {label}",
        "name": COLON.sub(r"\1", name),
        "formula": formula,
    }


def setup(app: Sphinx) -> dict[str, Any]:
    """Connect the above to the build."""
    app.connect("doctree-resolved", keep_together)
    app.connect("html-page-context", rewrite)
    app.connect("html-page-context", lay_out_the_sheet, priority=600)  # behind the formulas
    return {"parallel_read_safe": True, "parallel_write_safe": True}
