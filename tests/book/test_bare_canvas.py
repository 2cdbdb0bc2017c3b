"""A page that holds nothing but canvases: what the chapters need not show."""

from __future__ import annotations

from pathlib import Path

import pytest
from matplotlib import pyplot as plt
from matplotlib.figure import Figure
from playwright.sync_api import Locator, Page
from robust_slam_course.canvas import Canvas, Checkbox, Slider, Stepper

from tests.book.moving import by_keyboard, canvases, controls, picture
from tests.chromium import Opener

pytestmark = pytest.mark.browser


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
        first, second = canvases(visit.page)
        before = picture(second)
        by_keyboard(controls(first)[0], 2)
        assert picture(first) != before == picture(second)
        assert visit.complaints == visit.outside == []

    def test_without_scripts_the_first_state_stands_and_says_so(
        self, bare: str, open_page: Opener
    ) -> None:
        canvas = canvases(open_page(bare, java_script_enabled=False).page)[0]
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
        assert picture(canvases(open_page(path.as_uri()).page)[0]) != picture(
            page.locator("div").first
        )
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
