"""Text, tables, citations, bibliography and folded code that screen readers and phones can use.

A table of sentences becomes a list of cards where the window is narrow: each cell then shows the
name of its column, and the roles say that it still is a table. A citation that is pointed at, or
that the keyboard has reached, shows what is cited.
"""

from __future__ import annotations

import re
from typing import Any

from bs4 import BeautifulSoup, Tag
from docutils import nodes
from sphinx.application import Sphinx

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
ROLES = {"thead": "rowgroup", "tbody": "rowgroup", "tr": "row", "td": "cell"}


def keep_together(app: Sphinx, doctree: nodes.document, page: str) -> None:
    """Let no line end between a number and its unit, in the text outside code and formulas."""
    apart = nodes.literal | nodes.literal_block | nodes.math | nodes.math_block | nodes.raw
    for text in list(doctree.findall(nodes.Text)):
        if (kept := TOGETHER.sub("\u00a0", text)) != text and not isinstance(text.parent, apart):
            text.parent.replace(text, nodes.Text(kept))


def rewrite(
    app: Sphinx, page: str, template: str, context: dict[str, Any], doctree: nodes.document | None
) -> None:
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


def setup(app: Sphinx) -> dict[str, Any]:
    """Connect the above to the build."""
    app.connect("doctree-resolved", keep_together)
    app.connect("html-page-context", rewrite)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
