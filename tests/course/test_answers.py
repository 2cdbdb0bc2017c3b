"""A live picture says what its still one says; *Show it* brings it where the answer is seen."""

import json
import re
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import pytest
from playwright.sync_api import Locator
from robust_slam_course import pictures
from robust_slam_course.canvas.picture import Picture

from tests.book.taking_hold import seen, unfold
from tests.chromium import Opener

SAYS = {
    "opening": "Least squares trusts the wrong closure",
    "cycles": "bends 33 of the 99 other edges",
    "leverage": "Cauchy lets this reading pull with 1.2",
    "kernels": "Cauchy’s to 0.07 and that of TLS to 0.00",
    "majoriser": "IRLS ends at 0, among the inliers",
    "basins": "From 8 the descent ends at 0",
    "annealing": "the run goes to 6 in 14 solves",
    "hardening": "moves the estimate from 0.21",
    "factors": "the run goes to 0 in 39 solves",
    "consistency": "PCM keeps 8 of the 8 inliers",
    "certificate": "has untwisted the ring, and the cost falls from 13.82",
    "showcase": "GNC follows the nine with the diamond at pose 3",
    "starts": "GNC follows the nine with the diamond at pose 18",
    "turning": "eigenvalue is 0.00: certified",
    "machine": "bends the map by 2.97\u00a0m, and no lamp lights",
    "graduation": "13 more from least squares than from odometry",
    "robots": "C rejects its wrong closure.",
    "arena": "GNC lets no outlier in",
    "growing": "withdrew the outlier at pose 29",
    "proofs": "all 13 certificates succeed, and yet the map ends lost",
    "priors": "keeps all 10 outliers out, beside 13 of 13 inliers",
    "breaking": "Fooled: 2 outliers",
}
"""What the words below each picture say of the answer, once it is shown."""

SAID = """picture => [...picture.querySelectorAll(
    ".rs-stage text:not(.rs-tick), .rs-caption, .rs-value, .rs-stage [aria-label]")]
  .flatMap((part) => [part.textContent, part.ariaLabel, part.getAttribute("aria-valuetext")])
  .filter(Boolean)"""
"""What a picture says beside its question and the numbers of its axes."""
NUMBER = re.compile(r"\d+(?:\.\d+)?")


def tells(shown: Picture, said: str) -> list[str]:
    """What of the right answer is said: its number where it has one alone, else its words.

    Numbers that the question has, or that the reader takes hold of, are given and tell nothing;
    nor do words where those of all options stand, such as names of curves.
    """
    if all(option.text in said for option in shown.question.options):
        return []
    (right,) = (option.text for option in shown.question.options if option.correct)
    numbers = NUMBER.findall(right)
    given = NUMBER.findall(f"{shown.question.prompt} {json.dumps(dict(shown.state))}")
    secret = numbers if len(numbers) == 1 else [right]
    return [
        each
        for each in secret
        if each not in {f"{float(number):g}" for number in given}
        and re.search(rf"(?<![\w.]){re.escape(each)}(?!\w|\.\d)", said)
    ]


def test_what_tells_an_answer_is_found():
    shown = pictures.cycles()
    assert tells(shown, "The wrong closure bends 33 of the 99 other edges.") == ["33"]
    assert tells(shown, "It bends 103 of 99; 33.4 m.") == []


def opened(name: str, folder: Path, open_page: Opener) -> tuple[Picture, Locator]:
    """A picture, and the same on a page that has nothing else."""
    shown, path = getattr(pictures, name)(), folder / "page.html"
    path.write_text(f'<!doctype html><meta charset="utf-8">{shown.static_html()}', "utf-8")
    return shown, open_page(path.as_uri(), reduced_motion="reduce").page.locator(".rs-picture")


def linked(picture: Locator) -> dict[str, Any]:
    """The state that a link to the picture holds."""
    unfold(picture)
    picture.locator("[data-control=link]").click()
    return json.loads(unquote(picture.page.url.split("=")[1]))


@pytest.mark.browser
@pytest.mark.parametrize("name", sorted(pictures.__all__))
@pytest.mark.rest
def test_the_still_picture_and_the_answer_say_what_the_live_one_says(name, tmp_path, open_page):
    """The script computes each number of the still picture's words again, and shows the answer.

    The answer is reached by keys, and is a state that a link holds.
    """
    shown, picture = opened(name, tmp_path, open_page)
    first = seen(picture)
    assert len(first.caption) > 40
    assert tells(shown, "\n".join(picture.evaluate(SAID))) == []
    for number in re.findall(r"\d+\.\d+", shown.caption):
        assert number in first.caption, (shown.caption, first.caption)
    (right,) = (k for k, option in enumerate(shown.question.options) if option.correct)
    picture.locator(".rs-predict input").nth(right).focus()
    picture.page.keyboard.press("Space")
    picture.locator("[data-show]:visible").press("Enter")
    now = seen(picture)
    assert now.drawing != first.drawing and SAYS[name] in now.caption
    assert now.height == first.height
    found = linked(picture)
    assert {key: found.get(key, shown.state[key]) for key in shown.answer} == shown.answer
    picture.page.emulate_media(media="print")
    assert not picture.locator("[data-show]").filter(visible=True).count()


@pytest.mark.browser
@pytest.mark.rest
@pytest.mark.parametrize(("name", "places"), [("showcase", 52), ("starts", 52), ("proofs", 13)])
def test_a_reader_paints_by_hand_what_show_it_shows(name, places, tmp_path, open_page):
    """Each place is tried once, from the first to the last."""
    shown, picture = opened(name, tmp_path, open_page)
    if name == "starts":
        picture.locator("[data-control=odometry]").click()
    picture.locator("[data-handle]").first.focus()
    for key in ["Home", *["ArrowRight"] * places]:
        picture.page.keyboard.press(key)
        seen(picture)
    assert linked(picture)["tried"] == shown.answer["tried"]
