"""axe-core finds nothing serious in what we wrote; what only the theme causes is listed here."""

from __future__ import annotations

from importlib.resources import files

import pytest
from playwright.sync_api import Page

from tests.book.conftest import PAGES, Site
from tests.chromium import Opener

pytestmark = pytest.mark.browser

GRAVE = ("serious", "critical")
FROM_THE_THEME = {
    # docutils gives a bibliography the role of a list, and its entries another one.
    ("aria-required-children", ".citation-list"),
    # The search button's own words fade in, and may be caught half-way.
    ("color-contrast", ".search-button__default-text"),
}
COLOURS = "runOnly: ['color-contrast', 'link-in-text-block']"
"""What axe-core looks for in the dark: only the colours differ."""
DARK = "document.documentElement.dataset.theme = 'dark'"
EACH_COLOUR_ONCE = """() => {
  const seen = new Set();
  for (const code of document.querySelectorAll("pre, dt.sig")) {
    const kinds = Array.from(code.querySelectorAll("*"), (part) => part.className);
    if (kinds.every((kind) => seen.has(kind))) code.textContent = code.textContent;
    for (const kind of kinds) seen.add(kind);
  }
}"""
"""Code of which every colour stands further up becomes plain text: axe-core takes twice as long
where it meets each of some thousand keywords."""
NO_GLYPHS = "document.querySelectorAll('mjx-container svg').forEach(s => s.replaceChildren())"
"""Half of a chapter's elements are strokes of formulas, of which axe-core says nothing."""
STILL = "Promise.allSettled(document.getAnimations().map(a => a.finished)).then(() => 0)"
"""Resolves when nothing fades or moves any more."""


def violations(page: Page, options: str = "") -> list[dict[str, object]]:
    """What axe-core says against a page; of what is well it keeps no record, which is slow."""
    page.evaluate(files("axe_playwright_python").joinpath("axe.min.js").read_text("utf-8"))
    found: list[dict[str, object]] = page.evaluate(
        f"axe.run({{resultTypes: ['violations'], {options}}}).then(ran => ran.violations)"
    )
    return found


def grave(page: Page, options: str = "") -> set[tuple[str, str]]:
    """The rule and the place of each violation that is serious or critical."""
    return {
        (str(violation["id"]), str(node["target"][0]))
        for violation in violations(page, options)
        if violation["impact"] in GRAVE
        for node in violation["nodes"]
    }


@pytest.mark.parametrize("name", PAGES)
def test_a_page_is_open_to_all(name: str, site: Site, open_page: Opener) -> None:
    page = open_page((site.folder / f"{name}.html").as_uri(), color_scheme="light").page
    page.evaluate("MathJax.startup.promise")
    page.evaluate(STILL)
    page.evaluate(EACH_COLOUR_ONCE)
    page.evaluate(NO_GLYPHS)
    assert grave(page) - FROM_THE_THEME == set()
    page.evaluate(DARK)
    page.evaluate(STILL)
    assert grave(page, COLOURS) - FROM_THE_THEME == set()


def test_a_faint_colour_is_seen_in_the_dark_too(site: Site, open_page: Opener) -> None:
    page = open_page((site.folder / "chapters/index.html").as_uri(), color_scheme="light").page
    page.add_style_tag(content="html[data-theme='dark'] .keyword { color: #222 }")
    page.evaluate("document.querySelector('article p').innerHTML = '<b class=keyword>word</b>'")
    assert grave(page, COLOURS) - FROM_THE_THEME == set()
    page.evaluate(DARK)
    page.evaluate(STILL)
    assert ("color-contrast", "b") in grave(page, COLOURS)


def test_axe_sees_what_it_looks_for(open_page: Opener) -> None:
    page = open_page("data:text/html,<html lang=en><title>t</title><img src='data:,'>").page
    assert grave(page) == {("image-alt", "img")}
