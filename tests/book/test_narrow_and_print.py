"""No page is wider than a phone; code is copied by keyboard; what paper and calm readers get."""

from __future__ import annotations

import pytest
from playwright.sync_api import Page, expect

from tests.book.conftest import PAGES, Site
from tests.book.test_accessible import OTHERS
from tests.chromium import Opener

pytestmark = pytest.mark.browser

CHAPTER = "chapters/03-irls"
TOO_WIDE = """() => {
  const over = (node) => node.getBoundingClientRect().right > innerWidth + 1;
  const scrolls = (node) => getComputedStyle(node).overflowX !== "visible";
  const boxed = (node) => node && (scrolls(node) || boxed(node.parentElement));
  const found = [...document.querySelectorAll("article *")].filter(
    (node) => over(node) && !boxed(node.parentElement));
  const page = document.documentElement.scrollWidth > innerWidth;
  return [...(page ? ["the page"] : []), ...found.map((node) => node.outerHTML.slice(0, 80))];
}"""
"""What stands beyond the right edge, outside of a box that scrolls by itself."""

# The theme hides what sticks out of a formula in a line. Hidden formulas have no width.
CUT_FORMULAS = """[...document.querySelectorAll(".math")].filter((math) => {
  const drawn = math.querySelector("math").getBoundingClientRect().width;
  return math.clientWidth && drawn > math.clientWidth + 1;
}).map((math) => math.textContent)"""

# Punctuation right behind a formula that stands further left than where the formula ends.
LONELY_PUNCTUATION = """[...document.querySelectorAll("span.math")].filter((math) => {
  const next = math.nextSibling;
  if (next?.nodeType !== Node.TEXT_NODE || !/^[.,;:!?)]/.test(next.data)) return false;
  const mark = document.createRange();
  mark.setStart(next, 0);
  mark.setEnd(next, 1);
  const { left, width } = mark.getBoundingClientRect();
  return width && left < math.getBoundingClientRect().right - 1;
}).map((math) => math.parentElement.textContent)"""
KNOBS_OUT = """[...document.querySelectorAll(".rs-picture :is(select, input, button)")].filter(
  (knob) => knob.getBoundingClientRect().right
    > knob.closest(".rs-picture").getBoundingClientRect().right).map((knob) => knob.outerHTML)"""
IMAGES_OUT = """[...document.images].filter(
  (image) => image.getBoundingClientRect().right > innerWidth).map((image) => image.outerHTML)"""


def visit(site: Site, open_page: Opener, name: str, **options: object) -> Page:
    return open_page((site.folder / f"{name}.html").as_uri(), **options).page


class TestOnAPhone:
    @pytest.mark.parametrize("name", [*PAGES, *OTHERS])
    def test_a_page_is_no_wider_than_the_window(
        self, name: str, site: Site, open_page: Opener
    ) -> None:
        page = visit(site, open_page, name, viewport={"width": 390, "height": 800})
        for script in (TOO_WIDE, IMAGES_OUT, KNOBS_OUT, CUT_FORMULAS, LONELY_PUNCTUATION):
            assert page.evaluate(script) == []
        page.set_viewport_size({"width": 320, "height": 800})
        assert page.evaluate(TOO_WIDE) == []

    def test_what_is_too_wide_is_found(self, site: Site, open_page: Opener) -> None:
        page = visit(site, open_page, CHAPTER, viewport={"width": 390, "height": 800})
        page.add_style_tag(content="article h1 { width: 500px }")
        assert "the page" in page.evaluate(TOO_WIDE)

    def test_the_button_that_copies_code_is_seen_on_touch(
        self, site: Site, open_page: Opener
    ) -> None:
        page = visit(site, open_page, CHAPTER, has_touch=True, is_mobile=True)
        button = page.get_by_role("button", name="Copy to clipboard").first
        assert float(button.evaluate("b => getComputedStyle(b).opacity")) > 0.8


class TestCopying:
    def test_each_code_box_has_a_button_that_keys_reach(
        self, site: Site, open_page: Opener
    ) -> None:
        page = visit(site, open_page, CHAPTER, permissions=["clipboard-read", "clipboard-write"])
        expect(page.locator(".copybtn").first).to_be_attached()
        assert page.locator(".highlight > pre").count() == page.locator(".copybtn").count() > 20
        button = page.locator(".cell_input .copybtn:visible").first
        code = button.locator("xpath=preceding-sibling::pre").inner_text()
        button.evaluate("b => b.previousElementSibling.focus()")
        page.keyboard.press("Tab")
        expect(button).to_be_focused()
        expect(button).to_have_css("opacity", "1")
        assert button.evaluate("b => getComputedStyle(b).outlineStyle") == "solid"
        page.keyboard.press("Enter")
        expect(button).to_have_attribute("data-tooltip", "Copied!")
        assert page.evaluate("navigator.clipboard.readText()").strip() == code.strip()


class TestOnPaper:
    @pytest.fixture
    def page(self, site: Site, open_page: Opener) -> Page:
        page = visit(site, open_page, CHAPTER)
        page.emulate_media(media="print")
        return page

    @pytest.mark.parametrize("kind", ["pre", "figure", "table", ".rs-picture", ".admonition"])
    def test_what_fits_stays_whole(self, kind: str, page: Page) -> None:
        breaks = page.locator(f"article {kind}").evaluate_all(
            "found => found.map(node => getComputedStyle(node).breakInside)"
        )
        assert set(breaks) == {"avoid"}

    def test_nothing_is_there_to_be_pressed(self, page: Page) -> None:
        assert page.locator("h1:visible").count() == 1
        for kind in ("button", "nav", "input[type=range]", "select", "form.bd-search", ".copybtn"):
            assert page.locator(f"{kind}:visible").count() == 0, kind


def test_the_first_key_leads_to_the_text(site: Site, open_page: Opener) -> None:
    page = visit(site, open_page, CHAPTER)
    page.keyboard.press("Tab")
    link = page.get_by_role("link", name="Skip to main content")
    expect(link).to_be_focused()
    expect(link).to_be_in_viewport()
    page.keyboard.press("Enter")
    page.keyboard.press("Tab")
    assert page.evaluate("document.querySelector('main').contains(document.activeElement)")


def test_nothing_moves_for_a_reader_who_asks_for_that(site: Site, open_page: Opener) -> None:
    page = visit(site, open_page, CHAPTER, reduced_motion="reduce")
    longest = """(of) => Math.max(...[...document.querySelectorAll("*")].flatMap((node) =>
      getComputedStyle(node)[of + "Duration"].split(",").map(parseFloat)))"""
    assert page.evaluate(longest, "animation") < 0.001
    assert page.evaluate(longest, "transition") == 0
    page.emulate_media(reduced_motion="no-preference")
    assert page.evaluate(longest, "transition") > 0.1
