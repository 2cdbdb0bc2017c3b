"""Words beside a picture, and parts of it, light what they name."""

from pathlib import Path

import pytest
from playwright.sync_api import Page
from robust_slam_course import pictures
from robust_slam_course.canvas.picture import Picture

from tests.chromium import Opener

pytestmark = [pytest.mark.browser, pytest.mark.rest]

PATHS = "[...document.querySelectorAll('.rs-stage :is(path, line)')]"
LIT = f"""() => !document.querySelector("[data-lighting]") ? [] : {PATHS}.filter((part) =>
  getComputedStyle(part).opacity === "1").map((part) => part.dataset.part).filter(Boolean)"""
FADED = f"() => {PATHS}.filter((part) => getComputedStyle(part).opacity < 0.5).length"


def between(above: str, picture: Picture, below: str, path: Path, opens: Opener) -> Page:
    """A page with a picture between two paragraphs."""
    cell = f'<div class="cell">{picture.static_html()}</div>'
    path.write_text(f'<!doctype html><meta charset="utf-8">{above}{cell}{below}', "utf-8")
    page = opens(path.as_uri()).page
    page.wait_for_selector(".rs-picture[data-live]")
    return page


@pytest.fixture
def beside(tmp_path, open_page):
    """The picture of chapter 0 and its words."""
    above = "<p>Two wrong closures, a <a href='#'>true path</a>, a wrong closure and μ.</p>"
    below = "<p>The true path and <math><mi>c</mi></math>.</p><h2>An outlier</h2>"
    return between(above, pictures.cycles(), below, tmp_path / "page.html", open_page)


def test_what_a_certificate_is_made_of_is_linked(tmp_path, open_page):
    above = "<p>The eigenvalues are below the cost.</p>"
    page = between(above, pictures.certificate(), "", tmp_path / "page.html", open_page)
    page.locator("p > .rs-word", has_text="eigenvalues").first.hover()
    opacity = "found => [...new Set(found.map((one) => getComputedStyle(one).opacity))]"
    assert page.locator(".rs-eigen").evaluate_all(opacity) == ["1"]
    assert page.locator(".rs-stage path:not(.rs-eigen)").evaluate_all(opacity) == ["0.2"]


def test_words_beside_it_that_name_visible_parts_are_linked_once(beside):
    linked = beside.locator(".rs-word")
    assert linked.all_inner_texts() == ["wrong closures", "wrong closure", "true path"]
    assert beside.locator("p").first.inner_text().startswith("Two wrong closures, a true path")
    colours = linked.evaluate_all("words => words.map((word) => getComputedStyle(word).color)")
    assert len({*colours}) == 2, "those of the closure and of the path"


@pytest.mark.parametrize("way", ["hover", "focus"])
def test_a_word_lights_its_part_and_the_others_fade(way, beside):
    word = beside.locator(".rs-word").first
    getattr(word, way)()
    assert "wrong" in beside.evaluate(LIT)
    assert beside.evaluate(FADED) > 100
    beside.locator("summary").first.hover() if way == "hover" else word.blur()
    assert beside.evaluate(LIT) == [] and beside.evaluate(FADED) == 0


def test_a_bar_lights_its_edge_and_an_edge_its_bar(beside):
    bars, edges = (f'[data-part="{part}"]' for part in ("edge-40", "wrong"))
    for twins in (bars, edges):
        for part in beside.locator(twins).all():
            part.dispatch_event("mouseover")
            assert beside.evaluate(LIT) == [twins.split('"')[1]] * 2
    beside.locator(".rs-stage").dispatch_event("mouseleave")
    assert beside.evaluate(LIT) == []
