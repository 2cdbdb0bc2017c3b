"""A live picture says what its still one says; *Show it* brings it where the answer is seen."""

import json
import re
from urllib.parse import unquote

import pytest
from robust_slam_course import pictures

from tests.book.taking_hold import seen, unfold

SAYS = {
    "opening": "GNC rejects 1",
    "cycles": "33 of the 99 other edges",
    "leverage": "pulls up with 1.19 (at most 1.19)",
    "kernels": "Cauchy’s to 0.07 and that of TLS to 0.00",
    "majoriser": "IRLS ends at 0, among the inliers",
    "basins": "From 8 IRLS ends at 0",
    "annealing": "the run ends at 6.00",
    "hardening": "the cost has 2 minima, and the estimate moves from 0.21",
    "factors": "ends at 0.00",
    "consistency": "PCM keeps 8 and 0",
    "certificate": "has untwisted the ring, and the cost falls from 13.82",
    "showcase": "GNC follows the nine with the diamond at pose 3",
    "starts": "GNC follows the nine with the diamond at pose 18",
    "turning": "eigenvalue is 0.00: certified",
    "machine": "bends the map by 2.97\u00a0m, and no lamp lights",
    "graduation": "13 more from least squares than from odometry",
    "robots": "0 of 2 correct and 1 of 1 wrong are rejected",
    "arena": "GNC uses 9 and 0, is 0.27",
    "growing": "was withdrawn at pose 29",
    "proofs": "all 13 certificates succeed, and yet the map ends lost",
    "priors": "Switches use 13 of 13 inliers and 0 of 10 outliers",
}
"""What the words below each picture say of the answer, once it is shown."""


@pytest.mark.long
def test_every_picture_has_one_but_the_game_which_is_to_be_played():
    found = {name for name in pictures.__all__ if getattr(pictures, name)().answer}
    assert found == {*pictures.__all__} - {"breaking"} and found <= SAYS.keys()


@pytest.mark.browser
@pytest.mark.parametrize("name", sorted(pictures.__all__))
@pytest.mark.rest
def test_the_still_picture_and_the_answer_say_what_the_live_one_says(name, tmp_path, open_page):
    """The script computes each number of the still picture's words again, and shows the answer.

    The answer is reached by keys, and is a state that a link holds.
    """
    shown, path = getattr(pictures, name)(), tmp_path / "page.html"
    path.write_text(f'<!doctype html><meta charset="utf-8">{shown.static_html()}', "utf-8")
    page = open_page(path.as_uri(), reduced_motion="reduce").page
    picture = page.locator(".rs-picture")
    first = seen(picture)
    assert len(first.caption) > 40
    for number in re.findall(r"\d+\.\d+", shown.caption):
        assert number in first.caption, (shown.caption, first.caption)
    if name not in SAYS:
        return
    (right,) = (k for k, option in enumerate(shown.question.options) if option.correct)
    picture.locator(".rs-predict input").nth(right).focus()
    for key in ("Space", "Tab", "Enter"):
        page.keyboard.press(key)
    now = seen(picture)
    assert now.drawing != first.drawing and SAYS[name] in now.caption
    assert now.height == first.height
    unfold(picture)
    picture.locator("[data-control=link]").click()
    assert json.loads(unquote(page.url.split("=")[1])) == shown.answer
    page.emulate_media(media="print")
    assert not picture.locator("[data-show]").filter(visible=True).count()


@pytest.mark.browser
@pytest.mark.rest
@pytest.mark.parametrize(
    ("name", "places"), [("showcase", 52), ("starts", 52), ("majoriser", 84), ("proofs", 13)]
)
def test_a_reader_paints_by_hand_what_show_it_shows(name, places, tmp_path, open_page):
    """Each place is tried once, from the first to the last."""
    shown, path = getattr(pictures, name)(), tmp_path / "page.html"
    path.write_text(f'<!doctype html><meta charset="utf-8">{shown.static_html()}', "utf-8")
    page = open_page(path.as_uri(), reduced_motion="reduce").page
    picture = page.locator(".rs-picture")
    if name == "starts":
        picture.locator("[data-control=odometry]").click()
    picture.locator("[data-handle]").focus()
    for key in [*["PageDown"] * 9, *["ArrowRight"] * places]:
        page.keyboard.press(key)
        seen(picture)
    unfold(picture)
    picture.locator("[data-control=link]").click()
    painted = json.loads(unquote(page.url.split("=")[1]))["tried"]
    assert painted == shown.answer["tried"]
