"""The search finds sections and shows their text; a query loads little."""

import re
from xml.etree import ElementTree

import pytest

from chapters._ext import finding, formulas
from tests.book.conftest import NOTEBOOKS, WAYS, place

WEIGHT = """performance.getEntriesByType("resource").filter(e => e.name.includes("pagefind"))
.reduce((sum, e) => sum + e.encodedBodySize, 0) / 1000"""


@pytest.mark.browser
@pytest.mark.parametrize("way", WAYS)
def test_a_word_of_the_chapters_is_found(way, site, address, open_page):
    found = open_page(place(site, address, "search", way) + "?q=huber")
    # Results are listed one after another: wait for the second page that has the word.
    found.page.locator("#search-results > ul > li").nth(1).wait_for()
    assert found.complaints == []


@pytest.mark.browser
@pytest.mark.rest
class TestOverTheNetwork:
    def test_a_result_leads_to_its_section_and_shows_text(self, address, open_page):
        page = open_page(f"{address}/search.html?q=leverage").page
        section = page.locator("#search-results ul ul li").first
        section.wait_for()
        assert "leverage" in section.locator("mark").first.inner_text().lower()
        assert "\\" not in page.locator("#search-results").inner_text()
        assert page.evaluate(WEIGHT) < 300, "what a query loads beyond the page itself"
        assert page.locator(".bd-content input[name=q]").input_value() == "leverage"
        anchor = section.locator("a").get_attribute("href") or ""
        section.locator("a").click()
        page.wait_for_url("**/chapters/**")
        assert page.locator(f"[id='{anchor.partition('#')[2]}']").is_visible()

    def test_results_are_listed_while_one_types(self, address, open_page):
        page = open_page(f"{address}/chapters/05-gnc.html").page
        page.keyboard.press("Control+k")
        page.keyboard.type("leverage", delay=20)
        results = page.locator("#pst-search-dialog .rs-found > ul > li")
        results.first.wait_for()
        assert "leverage" in results.locator("mark").first.inner_text().lower()
        page.keyboard.press("Tab")
        assert page.evaluate("document.activeElement.closest('.rs-found') !== null")
        for key in ("ArrowUp", "ArrowDown", "ArrowDown"):
            page.keyboard.press(key)
        assert results.locator("a").nth(1).evaluate("a => a === document.activeElement")
        page.keyboard.press("Enter")
        page.wait_for_url(lambda url: not url.endswith("05-gnc.html"))

    @pytest.mark.parametrize(
        ("query", "page", "section"),
        [
            ("how is the minimizer certified", "7 · Cert", ""),
            ("how do I choose the threshold", "2 · Four", "Choosing the threshold"),
            ("loss function", "2 · Four", "Redescending costs"),
            ("where do I begin", "For students", "Install"),
            ("\\rho", "Symbols", "Costs"),
            ("kernel", "Symbols", "Words"),
        ],
    )
    def test_what_explains_is_first(self, query, page, section, address, open_page):
        found = open_page(f"{address}/search.html?q={query}")
        first = found.page.locator("#search-results > ul > li").first
        assert page in first.locator("a").first.inner_text()
        assert section in first.locator("li a").first.inner_text()
        assert found.complaints == []

    def test_more_results_are_shown_on_demand_and_none_is_said(self, address, open_page):
        page = open_page(f"{address}/search.html?q=outlier").page
        results = page.locator("#search-results > ul > li")
        results.nth(4).wait_for()
        assert results.count() == 5
        page.get_by_role("button", name="Show more").click()
        results.nth(9).wait_for()
        page = open_page(f"{address}/search.html?q=xylophone").page
        page.get_by_text("No page has “xylophone”.").wait_for()


@pytest.mark.parametrize("name", NOTEBOOKS)
def test_a_page_is_indexed_to_its_end(name, site):
    """An element that ended too early would end the article, and all behind it be left out."""
    page = (site.folder / f"{name}.html").read_text("utf-8")
    made = finding.for_the_index(page)
    for tag in ("div", "section", "td"):
        assert made.count(f"</{tag}>") == page.count(f"</{tag}>")
        assert len(re.findall(rf"<{tag}\b", made)) == len(re.findall(rf"<{tag}\b", page))


@pytest.mark.parametrize(
    ("tex", "text"),
    [
        (r"\tfrac12 u^2", "1/2u²"),
        (r"\frac{a+b}{c}", "a+b/c"),
        (r"w_i \ge 0", "w_i ≥ 0"),
        (r"\hat x = e^x", "x = e^x"),
    ],
)
def test_a_formula_is_text_in_the_index(tex, text):
    formula = ElementTree.fromstring(formulas.mathml(tex, False))
    assert finding.in_a_line(formula) == text


def test_a_formula_or_number_that_is_a_line_or_a_cell_is_not_in_the_index():
    formula, cell = '<span class="math"><math><mi>y</mi></math></span>', "<td><p>{}</p></td>"
    display = '<div class="math"><math>9</math></div>'
    for alone in (cell.format(formula), cell.format("9.5"), display):
        assert not {*"y9"} & {*finding.for_the_index(alone)}
    assert "y</span> is 9" in finding.for_the_index(cell.format(f"{formula} is 9"))
