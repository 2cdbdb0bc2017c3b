"""The pages in Chromium without network, over http and from the disk: they work and are whole."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser

from tests.book.conftest import PAGES, WAYS, Site, place
from tests.chromium import Opener, Visit, visiting

pytestmark = pytest.mark.browser

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


@pytest.fixture(scope="module", params=list(itertools.product(PAGES, WAYS)), ids="-".join)
def visit(
    request: pytest.FixtureRequest, site: Site, address: str, browser: Browser
) -> Iterator[Visit]:
    """A page of the contents, open while its tests run."""
    with visiting(browser, place(site, address, *request.param)) as opened:
        yield opened


class TestPage:
    """What holds for every page of the contents."""

    def test_nothing_fails_and_nothing_asks_for_the_network(self, visit: Visit) -> None:
        assert visit.complaints == []
        assert visit.outside == []

    def test_it_fits_a_phone(self, visit: Visit) -> None:
        page = visit.page
        usual = page.viewport_size
        page.set_viewport_size({"width": 390, "height": 844})
        assert page.evaluate("document.documentElement.scrollWidth") <= 390
        widths = "[...document.images].map(i => i.getBoundingClientRect().right)"
        assert all(right <= 390 for right in page.evaluate(widths))
        for knob in page.locator(".rs-picture :is(select, input, button)").all():
            card = "c => c.closest('.rs-picture').getBoundingClientRect().right"
            assert knob.evaluate("c => c.getBoundingClientRect().right") <= knob.evaluate(card)
        assert page.evaluate(CUT_FORMULAS) == []
        assert page.evaluate(LONELY_PUNCTUATION) == []
        page.set_viewport_size(usual)

    def test_every_picture_is_there_and_has_words(self, visit: Visit) -> None:
        broken = (
            "[...document.images].filter(i => !i.naturalWidth || !(i.alt || i.closest('.logo')))"
            ".map(i => i.outerHTML)"
        )
        assert visit.page.evaluate(broken) == []


def test_paper_is_white(site: Site, open_page: Opener) -> None:
    address = (site.folder / "chapters" / "03-irls.html").as_uri()
    page = open_page(address, color_scheme="dark").page
    theme = "document.documentElement.dataset.theme"
    page.evaluate(f"addEventListener('beforeprint', () => {{ window.printed = {theme}; }})")
    before = page.evaluate(theme)
    page.pdf()
    assert (before, page.evaluate("window.printed"), page.evaluate(theme)) == (
        "dark",
        "light",
        "dark",
    )


def test_the_watch_sees_what_it_looks_for(tmp_path: Path, open_page: Opener) -> None:
    path = tmp_path / "bad.html"
    path.write_text("<img src=https://example.org/a.png><script>console.error('oh')</script>")
    visit = open_page(path.as_uri())
    assert visit.outside == ["https://example.org/a.png"]
    assert "oh" in visit.complaints
