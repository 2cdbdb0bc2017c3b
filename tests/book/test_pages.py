"""The pages in Chromium without network, over http and from the disk: they work and are whole."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser

from chapters._ext.look import TEXT
from tests.book.conftest import PAGES, WAYS, Site, place
from tests.chromium import Opener, Visit, visiting

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
FROM_OTHERS = set("✗∘ᵀ⁻⪰\u2060")
"""Rare signs that the packaged font does not have either, and one that is never drawn."""


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

    def test_the_text_needs_no_other_font(self, visit: Visit) -> None:
        signs = {sign for sign in visit.page.evaluate(SHOWN) if ord(sign) not in TEXT}
        assert signs <= FROM_OTHERS

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
