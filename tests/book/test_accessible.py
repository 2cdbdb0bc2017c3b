"""axe-core finds nothing serious in what we wrote; what only the theme causes is listed here."""

from __future__ import annotations

import itertools
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
SCHEMES = {"light": "", "dark": "runOnly: ['color-contrast', 'link-in-text-block']"}
"""What axe-core looks for: in the dark only colours are others."""
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


@pytest.mark.parametrize(("name", "scheme"), list(itertools.product(PAGES, SCHEMES)))
def test_a_page_is_open_to_all(name: str, scheme: str, site: Site, open_page: Opener) -> None:
    page = open_page((site.folder / f"{name}.html").as_uri(), color_scheme=scheme).page
    page.evaluate("MathJax.startup.promise")
    page.evaluate(STILL)
    assert grave(page, SCHEMES[scheme]) - FROM_THE_THEME == set()


def test_axe_sees_what_it_looks_for(open_page: Opener) -> None:
    page = open_page("data:text/html,<html lang=en><title>t</title><img src='data:,'>").page
    assert grave(page) == {("image-alt", "img")}
