"""The pages in Chromium without network, over http and from the disk: they work and are whole."""

from __future__ import annotations

import itertools
import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from matplotlib import pyplot as plt
from matplotlib.figure import Figure
from playwright.sync_api import Locator, Page
from robust_slam.canvas import Canvas, Checkbox, Slider, Stepper

from tests.book.conftest import NOTEBOOKS, PAGES, Site
from tests.book.moving import by_keyboard, by_mouse, controls, frames, picture, size, sweep
from tests.chromium import Opener, Visit

pytestmark = pytest.mark.browser

WAYS = ("http", "file")


@pytest.fixture(scope="module")
def visits(site: Site, address: str, open_page: Opener) -> Callable[..., Visit]:
    """Return a function that opens a page of the site once, and waits until math is set."""
    known: dict[tuple[str, str, str], Visit] = {}

    def visit(page: str, way: str, query: str = "") -> Visit:
        if (page, way, query) not in known:
            base = address if way == "http" else site.folder.as_uri()
            opened = open_page(f"{base}/{page}.html{query}")
            opened.page.evaluate("MathJax.startup.promise")
            known[page, way, query] = opened
        return known[page, way, query]

    return visit


@pytest.fixture(params=list(itertools.product(PAGES, WAYS)), ids="-".join)
def visit(request: pytest.FixtureRequest, visits: Callable[..., Visit]) -> Visit:
    return visits(*request.param)


@pytest.fixture(params=list(itertools.product(NOTEBOOKS, WAYS)), ids="-".join)
def chapter(request: pytest.FixtureRequest, visits: Callable[..., Visit]) -> Visit:
    return visits(*request.param)


class TestPage:
    """What holds for every page of the contents."""

    def test_nothing_fails_and_nothing_asks_for_the_network(self, visit: Visit) -> None:
        assert visit.complaints == []
        assert visit.outside == []

    def test_all_math_is_set(self, visit: Visit) -> None:
        page = visit.page
        assert page.locator("mjx-container").count() == page.locator(".math").count()
        assert page.locator("mjx-merror, [data-mjx-error]").count() == 0

    def test_it_fits_a_phone(self, visit: Visit) -> None:
        page = visit.page
        usual = page.viewport_size
        page.set_viewport_size({"width": 390, "height": 844})
        assert page.evaluate("document.documentElement.scrollWidth") <= 390
        widths = "[...document.images].map(i => i.getBoundingClientRect().right)"
        assert all(right <= 390 for right in page.evaluate(widths))
        for knob in page.locator(".rs-canvas :is(select, input, button)").all():
            card = "c => c.closest('.rs-canvas').getBoundingClientRect().right"
            assert knob.evaluate("c => c.getBoundingClientRect().right") <= knob.evaluate(card)
        page.set_viewport_size(usual)

    def test_every_picture_is_there_and_has_words(self, visit: Visit) -> None:
        broken = (
            "[...document.images].filter(i => !i.naturalWidth || !i.alt).map(i => i.outerHTML)"
        )
        assert visit.page.evaluate(broken) == []


@pytest.mark.parametrize("way", WAYS)
def test_the_search_finds_a_word_of_the_chapters(visits: Callable[..., Visit], way: str) -> None:
    found = visits("search", way, "?q=huber")
    # Results are listed one after another: wait for the second page that has the word.
    found.page.locator("#search-results > ul > li").nth(1).wait_for()
    assert found.complaints == []


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


# Canvases


SHOWN = """group => {
  const image = group.querySelector("img");
  const rows = [...group.querySelectorAll("tr")].map(r => [...r.cells].map(c => c.textContent));
  const caption = group.querySelector("figcaption").textContent;
  return {svg: decodeURIComponent(image.src.split(/,(.*)/s)[1]), alt: image.alt, caption, rows};
}"""


def assert_shows(canvas: Locator, frame: dict[str, Any]) -> None:
    """Fail unless picture, alternative text, caption and numbers are those of the frame."""
    svg, text, rows = frame["svg"], frame["text"], frame["rows"]
    assert canvas.evaluate(SHOWN) == {"svg": svg, "alt": text, "caption": text, "rows": rows}


def canvases(visit: Visit) -> list[Locator]:
    return visit.page.locator(".rs-canvas").all()


class TestCanvas:
    """What holds for every canvas of the chapters."""

    def test_a_chapter_has_one(self, chapter: Visit) -> None:
        assert canvases(chapter)

    def test_keys_reach_every_state_and_each_shows_its_own_frame(self, chapter: Visit) -> None:
        for canvas in canvases(chapter):
            states = sweep(controls(canvas), by_keyboard)
            for frame, _ in zip(frames(canvas), states, strict=True):
                assert_shows(canvas, frame)
        assert chapter.complaints == []

    def test_each_control_moves_the_picture_by_keyboard_and_by_mouse(self, chapter: Visit) -> None:
        for canvas, move in itertools.product(canvases(chapter), (by_keyboard, by_mouse)):
            for control in controls(canvas):
                seen = []
                for position in range(size(control)):
                    move(control, position)
                    seen.append(picture(canvas))
                assert len(set(seen)) > 1, control.evaluate("c => c.outerHTML")
        assert chapter.complaints == []

    def test_a_slider_says_its_value_and_a_rest_is_spoken(self, chapter: Visit) -> None:
        for canvas in canvases(chapter):
            for slider in canvas.locator("input[type=range]").all():
                texts = json.loads(slider.get_attribute("data-texts") or "[]")
                for position, text in enumerate(texts):
                    by_keyboard(slider, position)
                    assert slider.get_attribute("aria-valuetext") == text
                    assert slider.locator("xpath=following-sibling::*").text_content() == text
            by_keyboard(controls(canvas)[0], 1)
            spoken, words = canvas.locator("[aria-live=polite]"), canvas.locator("figcaption")
            chapter.page.wait_for_timeout(700)
            assert spoken.text_content() == words.text_content() != ""

    def test_the_sentence_about_scripts_is_gone(self, chapter: Visit) -> None:
        for canvas in canvases(chapter):
            assert not canvas.locator(".rs-note").is_visible()
            assert canvas.locator("fieldset").is_enabled()


class TestQuiz:
    """What holds for every quiz of the chapters."""

    def test_every_option_opens_and_answers(self, chapter: Visit) -> None:
        options = chapter.page.locator(".rs-quiz details").all()
        assert options
        for option in options:
            answer = option.locator("p")
            assert not answer.is_visible()
            option.locator("summary").press("Enter")
            assert answer.is_visible()
            assert re.match(r"(✓ Right\.|✗ Not quite\.) .+", answer.inner_text(), re.S)
            option.locator("summary").click()
            assert not answer.is_visible()

    def test_every_question_has_a_name_and_a_right_option(self, chapter: Visit) -> None:
        for question in chapter.page.locator(".rs-quiz fieldset").all():
            assert question.locator("legend").inner_text()
            assert question.locator(".rs-right").count() >= 1


# A page that holds nothing but canvases: what the chapters need not show


def draw(c: float, lie: bool, step: int) -> Figure:
    figure, ax = plt.subplots()
    ax.plot([0, c], [lie, step])
    return figure


def describe(c: float, lie: bool, step: int) -> str:
    return f"c = {c}, lie {lie}, step {step}"


@pytest.fixture(scope="module")
def bare(tmp_path_factory: pytest.TempPathFactory) -> str:
    """The address of a page with two canvases and no script but theirs."""
    knobs = [
        Slider("c", "c", [1, 2, 3], 2),
        Checkbox("lie", "lie"),
        Stepper("step", count=2, play=True),
    ]
    html = Canvas("Alone", knobs, draw, describe).static_html()
    path: Path = tmp_path_factory.mktemp("bare") / "index.html"
    page = f"<!doctype html><meta charset=utf-8><title>Two</title><body>{html}{html}"
    path.write_text(page, encoding="utf-8")
    return path.as_uri()


def steps(page: Page) -> Locator:
    return page.locator("data").first


class TestBarePage:
    """A canvas needs nothing from its page."""

    def test_two_of_them_do_not_meet(self, bare: str, open_page: Opener) -> None:
        visit = open_page(bare)
        first, second = canvases(visit)
        before = picture(second)
        by_keyboard(controls(first)[0], 2)
        assert picture(first) != before == picture(second)
        assert visit.complaints == visit.outside == []

    def test_without_scripts_the_first_state_stands_and_says_so(
        self, bare: str, open_page: Opener
    ) -> None:
        canvas = canvases(open_page(bare, java_script_enabled=False))[0]
        assert canvas.locator("img").get_attribute("alt") == "c = 2, lie False, step 0"
        assert canvas.locator(".rs-note").is_visible()
        assert canvas.locator("button").first.is_disabled()

    def test_play_steps_to_the_end_and_can_be_paused(self, bare: str, open_page: Opener) -> None:
        page = open_page(bare).page
        play = page.locator("[data-does=play]").first
        play.press("Enter")
        assert play.text_content() == "Pause"
        play.press("Enter")
        assert (play.text_content(), steps(page).text_content()) == ("Play", "0 of 2")
        play.click()
        page.wait_for_function("document.querySelector('data').value === '2'")
        assert (play.text_content(), steps(page).text_content()) == ("Play", "2 of 2")
        assert page.locator("[data-does=step]").first.get_attribute("aria-disabled") == "true"

    def test_a_slider_plays_to_its_end_and_a_hand_stops_it(
        self, tmp_path: Path, open_page: Opener
    ) -> None:
        knob = Slider("step", "step", [0, 1, 2], 1, play=True)
        alone = Canvas(
            "Alone", [knob], lambda step: draw(1, False, step), lambda step: f"step {step}"
        )
        path = tmp_path / "index.html"
        path.write_text(f"<!doctype html><meta charset=utf-8><body>{alone.static_html()}")
        page = open_page(path.as_uri()).page
        play, slider = page.locator("[data-does=play]"), page.locator("input")
        play.press("Enter")
        page.wait_for_function("document.querySelector('input').value === '2'")
        assert (play.text_content(), slider.get_attribute("aria-valuetext")) == ("Play", "2")
        assert picture(canvases(open_page(path.as_uri()))[0]) != picture(page.locator("div").first)
        play.press("Enter")
        assert (play.text_content(), slider.input_value()) == ("Pause", "0")
        slider.press("ArrowRight")
        assert (play.text_content(), slider.input_value()) == ("Play", "1")

    def test_play_is_not_offered_where_motion_is_unwelcome(
        self, bare: str, open_page: Opener
    ) -> None:
        page = open_page(bare, reduced_motion="reduce").page
        assert not page.locator("[data-does=play]").first.is_visible()
        assert page.locator("[data-does=step]").first.is_visible()
