"""On a phone wide tables are cards, and still tables; what else the markup of pages needs."""

import ast
import re
from itertools import pairwise

import pytest
from bs4 import BeautifulSoup
from docutils import nodes
from docutils.utils import new_document
from playwright.sync_api import expect

from chapters._ext import markup
from tests.book.conftest import NOTEBOOKS
from tests.book.prose import Chapter
from tests.book.test_accessible import complaints

WIDE = ("What it is", "a sentence that is much longer than a word", "and another one, " * 2)


def rewritten(body: str) -> BeautifulSoup:
    context = {"body": body}
    markup.rewrite(None, "", "", context, None)
    return BeautifulSoup(context["body"], "html.parser")


def table(heads: tuple[str, ...], cells: tuple[str, ...]) -> BeautifulSoup:
    head = "".join(f'<th class="head">{word}</th>' for word in heads)
    body = "".join(f"<td>{word}</td>" for word in cells)
    return rewritten(
        f"<p>text</p><table class='table'><thead><tr>{head}</tr></thead>"
        f"<tbody><tr>{body}</tr></tbody></table>"
    )


@pytest.mark.parametrize("text", ["0.88_m off", "4_% of 3.1_GB", "c_=_2, not 1_−_s", "2 machines"])
def test_a_number_stays_with_its_unit(text):
    page, code = new_document(""), nodes.literal("", "", nodes.Text("3 m"))
    page += nodes.paragraph("", "", nodes.Text(text.replace("_", " ")), code)
    markup.keep_together(None, page, "")
    assert page.astext() == text.replace("_", "\u00a0") + "3 m"


def test_a_path_in_a_table_breaks_behind_its_folders():
    code = '<code class="literal"><span class="pre">lib/x/y.py</span></code>'
    assert str(table(("a", "b"), (code, "c")).select_one("td .pre")).count("/<wbr/>") == 2


def first_on_a_line(source: str) -> list[str]:
    """What a cell inserts at the beginning of a line within a paragraph that it shows."""
    strings = ast.walk(ast.parse(source if "Markdown(" in source else ""))
    parts = [pair for s in strings if isinstance(s, ast.JoinedStr) for pair in pairwise(s.values)]
    return [
        ast.unparse(inserted)
        for before, inserted in parts
        if isinstance(before, ast.Constant)
        and isinstance(inserted, ast.FormattedValue)
        and re.search(r"[^\n]\n\Z", str(before.value))
    ]


@pytest.mark.parametrize("page", [page.rpartition("/")[2] for page in NOTEBOOKS])
def test_no_number_that_a_cell_inserts_begins_a_line(page):
    """Where a full stop follows it, Markdown takes the line for an item of a list."""
    assert first_on_a_line('Markdown(f"the lead is only\\n{lead}. PCM")')
    assert not [part for source in Chapter(page).code.values() for part in first_on_a_line(source)]


@pytest.mark.parametrize(
    ("heads", "cells"),
    [
        (("a", "b", "c"), ("1.5", "2.5", "3.5")),
        (("exercise", "you write"), ("weight", "the weight of a residual, " * 5)),
        (("name", '<span class="math">\\(x\\)</span>', "meaning"), WIDE),
    ],
    ids=["numbers", "two columns", "formula above"],
)
def test_other_tables_stay_as_they_are(heads, cells):
    page = table(heads, cells)
    assert not page.select(".rs-cards, [role], [data-label]")


def test_short_values_are_neither_broken_nor_made_cards():
    name = "a method from a start that is long, " * 3
    page = table(("method", "A", "close"), (name, "400 of 400", "97.2 % (95.1 to 98.5)"))
    assert page.select("table.rs-short:not(.rs-cards)")


def test_an_empty_header_is_a_cell_and_a_formula_as_header_is_none():
    page = table(("", "one"), ("a", "1"))
    assert [cell.name for cell in page.select("thead tr > *")] == ["td", "th"]
    assert page.select("th")[0]["scope"] == "col"
    page = table(('<span class="math">\\(\\sigma\\)</span>', "one"), ("a", "1"))
    assert [cell.get_text()[-1] for cell in page.select("th")] == ["\u2060", "e"]


def test_an_entry_of_the_bibliography_is_a_list_item_without_number(site):
    entries = site.parsed("chapters/references").select(".citation-list[role=list] > *")
    assert len(entries) > 50
    assert all(entry["role"] == "listitem" and entry["id"] for entry in entries)
    assert not [entry for entry in entries if entry.get_text().strip().startswith("[")]


@pytest.mark.browser
def test_a_head_cell_with_a_formula_is_one_line(site, open_page):
    page = open_page((site.folder / "chapters/cheat-sheet.html").as_uri()).page
    head = page.locator("thead tr").filter(has=page.locator("math")).first
    assert head.evaluate("row => row.getBoundingClientRect().height") < 50


@pytest.mark.browser
@pytest.mark.rest
def test_on_a_phone_a_row_is_a_card_and_the_table_still_one_with_headers(site, open_page):
    phone = {"width": 390, "height": 800}
    page = open_page((site.folder / "chapters/errata.html").as_uri(), viewport=phone).page
    widths = "cards => cards.map(card => card.getBoundingClientRect().width)"
    cells = page.locator(".rs-cards tbody td").evaluate_all(widths)
    assert len(cells) > 100 and min(cells) > 300
    above = "cell => getComputedStyle(cell, '::before').content"
    assert page.locator(".rs-cards tbody td").first.evaluate(above) == '"Printed"'
    table = page.get_by_role("table", name="What chapter 0 prints, and what is right")
    headers = table.get_by_role("columnheader").all_inner_texts()
    assert headers == ["Printed", "Right", "Computation"]
    assert table.get_by_role("row").count() > 5
    assert complaints(page) == set()


@pytest.mark.browser
@pytest.mark.parametrize("width", [1280, 390])
@pytest.mark.rest
def test_a_citation_shows_what_it_cites_by_mouse_and_keyboard(width, site, open_page):
    address = (site.folder / "chapters/01-m-estimators.html").as_uri()
    page = open_page(address, viewport={"width": width, "height": 800}).page
    cited = page.locator("article a[href*='references.html#']").first
    tip = page.get_by_role("tooltip")
    cited.focus()
    expect(tip).to_contain_text(re.compile(r"\w\. .*, \d{4}\."))
    assert cited.get_attribute("aria-describedby") == tip.get_attribute("id")
    box = tip.bounding_box()
    assert box and box["x"] >= 0 and box["x"] + box["width"] <= width
    page.mouse.move(0, 0)
    page.evaluate("document.activeElement.blur()")
    expect(tip).to_have_count(0)
    cited.hover()
    expect(tip).to_be_visible()
