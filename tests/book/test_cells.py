"""What cells show: a printed table is one, code stands below, and no grey box is left."""

import json

import pytest
from bs4 import BeautifulSoup

from chapters._ext.cells import NUMBERS, Table, parts
from tests.book.conftest import NOTEBOOKS, ROOT
from tests.book.test_accessible import DARK

SWEEP = "lost towns:\n       20 %  40 %\nleast     5     4\nIRLS      0     1\nworst 0.92"
LOST = Table("lost towns", ["", "20 %", "40 %"], [["least", "5", "4"], ["IRLS", "0", "1"]])


@pytest.mark.parametrize(
    ("text", "found"),
    [
        (SWEEP, [LOST, "worst 0.92"]),
        ("c      error\n1.000  0.17 m\n2.666  0.15 m",
         [Table("told", ["c", "error"], [["1.000", "0.17 m"], ["2.666", "0.15 m"]])]),
        ("      a    b\none  1.0\ntwo  2.0  3.0",
         [Table("told", ["", "a", "b"], [["one", "1.0", ""], ["two", "2.0", "3.0"]])]),
        *((text, [text]) for text in (
            "12 measurements, one is wrong\nerror, odometry    0.32 m\nerror, closures    0.15 m",
            "[[ 9. -1.]\n [-1.  2.]\n [-8.  -1.]]",
            "huber    w = 0.5   top = 1\ncauchy   w = 0.2   2.0\ntls      w = 0.0   3.0",
            "a  b\n1  2",
        )),
    ],
)  # fmt: skip
def test_a_line_of_heads_above_lines_of_numbers_is_a_table(text, found):
    assert parts(text, "told") == found


def test_what_a_cell_printed_is_text_and_not_markup():
    html = Table("a<b", ["<i>", "b"], [["1", "x&y"], ["22", "z"]]).html()
    soup = BeautifulSoup(html, "html.parser")
    assert soup.caption.get_text() == "a<b"
    cells = [cell.get_text() for cell in soup.select("th, td")]
    assert cells == ["<i>", "b", "1", "x&y", "22", "z"]
    assert [cell.get_text() for cell in soup.select(".rs-number")] == ["<i>", "1", "22"]


@pytest.mark.parametrize("name", NOTEBOOKS)
def test_folded_code_stands_below_what_it_makes_and_is_named(name, site):
    """What it prints is with it, or is a table with a caption; neighbours have one bar."""
    soup = site.parsed(name)
    for table in soup.select(".rs-printed"):
        assert table.caption and table.caption.get_text(), table.get_text()[:80]
        below = table.parent.find_next_sibling() if table.parent else None
        left_out = below.get_text().split("\n")[0] if below and below.pre else ""
        assert "  " not in left_out.strip(), f"a row that is not in its table: {left_out}"
    for cell in soup.select(".cell:is(.tag_hide-input, .rs-merged):not(details > *)"):
        (folded,) = cell.select(":scope > details")
        assert folded.find_next_sibling() is None
        (said,) = {title.get_text() for title in folded.summary.select(".admonition-title")}
        assert said.startswith("Code")
        if numbers := [number.get_text().strip() for number in cell.select(".caption-number")]:
            assert said == f"Code for {' and '.join(numbers)}"
        shown = cell.select_one(":scope > .cell_output")
        assert shown is None or shown.select_one("table, svg, .rs-picture, img, p"), cell["class"]
        if shown and shown.select(".rs-printed"):
            assert said == "Code for this table"
        before, behind = cell.find_previous_sibling(), cell.find_next_sibling()
        if said == NUMBERS and before:
            assert not before.select(":scope > details.hide"), "neighbours have one bar"
        if not cell.select(".cell_output") and behind and behind.select("details"):
            assert behind.select(".cell_output"), "neighbours have one bar"


@pytest.mark.parametrize("name", NOTEBOOKS)
def test_no_shown_cell_asks_whether_the_text_is_right(name):
    away = {"hide-input", "hide-cell", "remove-input", "remove-cell"}
    for cell in json.loads((ROOT / f"{name}.ipynb").read_text("utf-8"))["cells"]:
        if cell["cell_type"] == "code" and not away & {*cell["metadata"].get("tags", ())}:
            assert "check_text" not in "".join(cell["source"]), cell["id"]


@pytest.mark.browser
def test_the_code_of_a_chapter_is_behind_one_link(site, open_page):
    page = open_page((site.folder / "chapters/05-gnc.html").as_uri()).page
    bars = page.locator("article .cell > details.hide > summary")
    assert bars.count() > 5 and not [bar for bar in bars.all() if bar.is_visible()]
    page.get_by_role("link", name="the code of this chapter").click()
    assert bars.filter(visible=True).count() > 5
    page.get_by_role("link", name="The loop").first.click()
    assert bars.filter(visible=True).count() > 5, "it stays in sight"


@pytest.mark.browser
def test_what_a_cell_printed_has_the_ground_of_the_page(site, open_page):
    address = (site.folder / "chapters/00-one-lie.html").as_uri()
    page = open_page(address, color_scheme="light").page
    for theme in ("0", DARK):
        page.evaluate(theme)
        grounds = page.locator(".cell_output :is(.stream, .stream div, .stream pre)").evaluate_all(
            "found => found.map(node => getComputedStyle(node).backgroundColor)"
        )
        assert set(grounds) == {"rgba(0, 0, 0, 0)"}
