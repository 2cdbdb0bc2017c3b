"""axe-core finds nothing to say against any page."""

from __future__ import annotations

from importlib.resources import files

import pytest
from playwright.sync_api import Page

from tests.book.conftest import PAGES, Site
from tests.chromium import Opener

pytestmark = pytest.mark.browser

OTHERS = ["404", "genindex", "py-modindex", "search"]
"""Pages that Sphinx adds."""
WORDS_OF_BUTTONS = "rules: {'label-content-name-mismatch': {enabled: true}}"
"""What a button is called holds what is written on it: a rule that axe-core leaves out."""
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
DRAWN_AS_ONE = """() => {
  for (const figure of document.querySelectorAll(".rs-figure svg")) figure.replaceChildren();
  for (const formula of document.querySelectorAll("math")) formula.replaceChildren("x");
}"""
"""A figure has tests of its own, and a formula has one colour: axe-core would look at each of
their thousands of letters."""
STILL = "Promise.allSettled(document.getAnimations().map(a => a.finished)).then(() => 0)"
"""Resolves when nothing fades or moves any more."""


def violations(page: Page, options: str = "") -> list[dict[str, object]]:
    """What axe-core says against a page; of what is well it keeps no record, which is slow."""
    page.evaluate(files("axe_playwright_python").joinpath("axe.min.js").read_text("utf-8"))
    found: list[dict[str, object]] = page.evaluate(
        f"axe.run({{resultTypes: ['violations'], {options}}}).then(ran => ran.violations)"
    )
    return found


def complaints(page: Page, options: str = WORDS_OF_BUTTONS) -> set[tuple[str, str]]:
    """The rule and the place of each violation, however small."""
    return {
        (str(violation["id"]), str(node["target"][0]))
        for violation in violations(page, options)
        for node in violation["nodes"]
    }


@pytest.mark.parametrize("name", [*PAGES, *OTHERS])
def test_a_page_is_open_to_all(name: str, site: Site, open_page: Opener) -> None:
    page = open_page((site.folder / f"{name}.html").as_uri(), color_scheme="light").page
    page.evaluate(STILL)
    page.evaluate(EACH_COLOUR_ONCE)
    page.evaluate(DRAWN_AS_ONE)
    assert complaints(page) == set()
    page.evaluate(DARK)
    page.evaluate(STILL)
    assert complaints(page, COLOURS) == set()


def test_a_faint_colour_is_seen_in_the_dark_too(site: Site, open_page: Opener) -> None:
    page = open_page((site.folder / "chapters/index.html").as_uri(), color_scheme="light").page
    page.add_style_tag(content="html[data-theme='dark'] .keyword { color: #222 }")
    page.evaluate("document.querySelector('article p').innerHTML = '<b class=keyword>word</b>'")
    assert complaints(page, COLOURS) == set()
    page.evaluate(DARK)
    page.evaluate(STILL)
    assert ("color-contrast", "b") in complaints(page, COLOURS)


def test_axe_sees_what_it_looks_for(open_page: Opener) -> None:
    page = open_page("data:text/html,<html lang=en><title>t</title><img src='data:,'>").page
    assert ("image-alt", "img") in complaints(page)
    page = open_page("data:text/html,<html lang=en><button aria-label=Find>Search").page
    assert ("label-content-name-mismatch", "button") in complaints(page)
