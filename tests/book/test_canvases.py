"""The canvases and quizzes of the chapters in Chromium, from the disk and over http.

From the disk everything is tried; over http, that a page loads without a complaint and moves.
"""

from __future__ import annotations

import itertools
import json
import re
from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, expect

from tests.book.conftest import NOTEBOOKS, Site, place
from tests.book.moving import (
    assert_shows,
    by_keyboard,
    by_mouse,
    canvases,
    controls,
    frames,
    picture,
    size,
    sweep,
    title,
)
from tests.chromium import Visit, visiting

pytestmark = pytest.mark.browser


@pytest.fixture(scope="module", params=NOTEBOOKS)
def chapter(
    request: pytest.FixtureRequest, site: Site, address: str, browser: Browser
) -> Iterator[Visit]:
    """A chapter, open while its tests run."""
    with visiting(browser, place(site, address, request.param, "file")) as opened:
        opened.page.evaluate("MathJax.startup.promise")
        yield opened


@pytest.mark.parametrize("name", NOTEBOOKS)
def test_over_http_a_page_moves_too(name: str, site: Site, address: str, browser: Browser) -> None:
    with visiting(browser, place(site, address, name, "http")) as opened:
        for canvas in canvases(opened.page):
            control = controls(canvas)[0]
            seen = []
            for position in (0, size(control) - 1):
                by_keyboard(control, position)
                seen.append(picture(canvas))
            assert seen[0] != seen[1]
        assert opened.complaints == []


class TestCanvas:
    """What holds for every canvas of the chapters."""

    def test_a_chapter_has_one(self, chapter: Visit) -> None:
        assert canvases(chapter.page)

    def test_keys_reach_every_state_and_each_shows_its_own_frame(self, chapter: Visit) -> None:
        for canvas in canvases(chapter.page):
            states = sweep(controls(canvas), by_keyboard)
            for frame, _ in zip(frames(canvas), states, strict=True):
                assert_shows(canvas, frame)
        assert chapter.complaints == []

    def test_each_control_moves_the_picture_by_keyboard_and_by_mouse(self, chapter: Visit) -> None:
        for canvas, move in itertools.product(canvases(chapter.page), (by_keyboard, by_mouse)):
            for control in controls(canvas):
                seen = []
                for position in range(size(control)):
                    move(control, position)
                    seen.append(picture(canvas))
                assert len(set(seen)) > 1, (
                    f"{title(canvas)}: the picture stays, whatever is done to "
                    + str(control.evaluate("c => c.closest('label, span').innerText"))
                )
        assert chapter.complaints == []

    def test_pictures_that_differ_have_words_that_differ(self, chapter: Visit) -> None:
        for canvas in canvases(chapter.page):
            looks: dict[str, set[str]] = {}
            for frame in frames(canvas):
                looks.setdefault(frame["text"], set()).add(frame["svg"])
            alike = [text for text, pictures in looks.items() if len(pictures) > 1]
            assert alike == [], f"{title(canvas)}: these words stand under several pictures"

    def test_a_slider_says_its_value_and_a_rest_is_spoken(self, chapter: Visit) -> None:
        for canvas in canvases(chapter.page):
            for slider in canvas.locator("input[type=range]").all():
                texts = json.loads(slider.get_attribute("data-texts") or "[]")
                for position, text in enumerate(texts):
                    by_keyboard(slider, position)
                    assert slider.get_attribute("aria-valuetext") == text
                    assert slider.locator("xpath=following-sibling::*").text_content() == text
            by_keyboard(controls(canvas)[0], 1)
            spoken, words = canvas.locator("[aria-live=polite]"), canvas.locator("figcaption")
            expect(words).not_to_be_empty()
            expect(spoken).to_have_text(words.text_content() or "")

    def test_the_sentence_about_scripts_is_gone(self, chapter: Visit) -> None:
        for canvas in canvases(chapter.page):
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
