"""The quizzes of the chapters in Chromium."""

from __future__ import annotations

import re
from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser

from tests.book.conftest import CHAPTERS, Site, place
from tests.chromium import Visit, visiting

pytestmark = pytest.mark.browser


@pytest.fixture(scope="module", params=CHAPTERS)
def chapter(
    request: pytest.FixtureRequest, site: Site, address: str, browser: Browser
) -> Iterator[Visit]:
    """A chapter, open while its tests run."""
    with visiting(browser, place(site, address, request.param, "file")) as opened:
        opened.page.evaluate("MathJax.startup.promise")
        yield opened


def test_every_option_opens_and_answers(chapter: Visit) -> None:
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


def test_every_question_has_a_name_and_a_right_option(chapter: Visit) -> None:
    for question in chapter.page.locator(".rs-quiz fieldset").all():
        assert question.locator("legend").inner_text()
        assert question.locator(".rs-right").count() >= 1
