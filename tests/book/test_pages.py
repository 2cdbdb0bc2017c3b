"""Each page in Chromium without network: it works, is whole, fits a phone and is open to all."""

import functools
import re
from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from playwright.sync_api import Browser, ViewportSize

from autograder.tests import kernel
from chapters._ext import look
from tests.book.conftest import NOTEBOOKS, PAGES, Site
from tests.book.test_accessible import assert_open_to_all
from tests.chromium import Visit, visiting
from tools import fonts

pytestmark = pytest.mark.browser

SHOWN = """() => {
  const walk = document.createTreeWalker(document.querySelector("main"), NodeFilter.SHOW_TEXT);
  const apart = "pre, code, math, svg, script, style, .rs-picture, .rs-quiz, button, mark";
  const signs = new Set();
  while (walk.nextNode()) {
    if (!walk.currentNode.parentElement.closest(apart)) [...walk.currentNode.data].forEach(
      (sign) => signs.add(sign));
  }
  return [...signs].filter((sign) => sign.trim()).join("");
}"""
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
OTHERS = ["404", "genindex", "py-modindex", "search"]
"""Pages that Sphinx adds."""
FROM_OTHERS = set("✗∘ᵀ⁻⪰\u2060")
"""Rare signs that the packaged font does not have either, and one that is never drawn."""

DEBOUNCE = 600
"""Milliseconds, twice as many as the theme waits until it looks at a window of another size."""
PHONE: ViewportSize = {"width": 390, "height": 800}
DESK: ViewportSize = {"width": 1280, "height": 720}


@functools.cache
def narrowest(style: str) -> list[int]:
    """The least width of each kind of window that a style sheet tells apart, and a large one.

    From one to the next a page only gets more room.
    """
    asked = "".join(re.findall(r"@media[^{]*", style))
    bounds = re.findall(r"(min|max)-width: ?([\d.]+)px", asked)
    return sorted({320, 1920, *(int(float(px)) + (kind == "max") for kind, px in bounds)})


@contextmanager
def opened(page: str, site: Site, browser: Browser) -> Iterator[Visit]:
    """Open a page from the disk, on a phone, where nothing fades or glides."""
    url = (site.folder / f"{page}.html").as_uri()
    calm = {"color_scheme": "light", "reduced_motion": "reduce"}
    with visiting(browser, url, viewport=PHONE, **calm) as visit:
        yield visit


@pytest.fixture(
    scope="module", params=[*(page for page in PAGES if page not in NOTEBOOKS), *OTHERS]
)
def visit(request, site, browser):
    """A page without cells, open while its tests run."""
    with opened(request.param, site, browser) as visit:
        yield visit


class EveryPage:
    def test_nothing_fails_and_nothing_asks_for_the_network(self, visit):
        assert visit.complaints == []
        assert visit.outside == []

    def test_the_text_needs_no_other_font(self, visit):
        signs = {sign for sign in visit.page.evaluate(SHOWN) if ord(sign) not in fonts.TEXT}
        assert signs <= FROM_OTHERS

    def test_every_picture_is_there_and_has_words(self, visit):
        broken = (
            "[...document.images].filter(i => !i.naturalWidth || !(i.alt || i.closest('.logo')))"
            ".map(i => i.outerHTML)"
        )
        assert visit.page.evaluate(broken) == []

    def test_it_is_no_wider_than_the_window(self, visit):
        page = visit.page
        for script in (TOO_WIDE, IMAGES_OUT, KNOBS_OUT, CUT_FORMULAS, LONELY_PUNCTUATION):
            assert page.evaluate(script) == []

    @pytest.mark.rest
    def test_nothing_is_wider_than_any_window_with_every_box_open(self, visit, site, request):
        """Of some widths, and in ``make soak`` of each."""
        page = visit.page
        page.evaluate("document.querySelectorAll('details').forEach(box => { box.open = true; })")
        wider = {}
        widths = narrowest((site.folder / "_static" / look.STYLE).read_text("utf-8"))
        if not kernel.is_soak(request.config):
            # Of all but the least every third, so that a third of the pages has each.
            first = 1 + sum(page.url.rpartition("/")[2].encode()) % 3
            widths = [widths[0], *widths[first::3]]
        for width in widths:
            page.set_viewport_size({"width": width, "height": 800})
            wider[width] = page.evaluate(TOO_WIDE)
        assert not any(wider.values()), wider

    @pytest.mark.rest
    def test_on_a_desk_it_is_open_to_all(self, visit):
        """axe-core looks at every element in the light, and at the colours again in the dark."""
        visit.page.set_viewport_size(DESK)
        # Only then does the theme let keys reach what scrolls at this width.
        visit.page.wait_for_timeout(DEBOUNCE)
        assert_open_to_all(visit.page)


class TestPage(EveryPage):
    """The notebooks are opened with their figures."""


@pytest.mark.rest
def test_what_is_too_wide_is_found_and_paper_is_white(site, open_page):
    address = (site.folder / "chapters" / "03-irls.html").as_uri()
    page = open_page(address, color_scheme="dark", viewport=PHONE).page
    theme = "document.documentElement.dataset.theme"
    page.evaluate(f"addEventListener('beforeprint', () => {{ window.printed = {theme}; }})")
    before = page.evaluate(theme)
    page.pdf()
    themes = (before, page.evaluate("window.printed"), page.evaluate(theme))
    assert themes == ("dark", "light", "dark")
    page.add_style_tag(content="article h1 { width: 500px }")
    assert "the page" in page.evaluate(TOO_WIDE)


def test_the_watch_sees_what_it_looks_for(tmp_path, open_page):
    path = tmp_path / "bad.html"
    path.write_text("<img src=https://example.org/a.png><script>console.error('oh')</script>")
    visit = open_page(path.as_uri())
    assert visit.outside == ["https://example.org/a.png"]
    assert "oh" in visit.complaints
