"""A chapter says how long it is and what for, and at its foot what the next one asks."""

from __future__ import annotations

import re

import pytest
from bs4 import BeautifulSoup

from tests.book.conftest import CHAPTERS, PAGES, Site


def read(site: Site, name: str) -> BeautifulSoup:
    return BeautifulSoup((site.folder / f"{name}.html").read_text("utf-8"), "html.parser")


@pytest.mark.parametrize("name", CHAPTERS)
def test_a_chapter_begins_with_its_length_and_its_goals(name: str, site: Site) -> None:
    page = read(site, name)
    line = page.select_one("article h1 + .rs-length")
    assert line
    minutes = re.match(r"(\d+) minutes to read", line.get_text())
    assert minutes and 10 <= int(minutes[1]) <= 60
    goals = page.select_one(line.a["href"])
    assert goals and goals.find_next_sibling().name == "ul"


def test_the_way_on_is_a_chapter_with_its_question(site: Site) -> None:
    rows = read(site, PAGES[0]).select("table tbody tr")
    asked = {row.a["href"]: row.find_all("td")[1].get_text() for row in rows}
    for before in CHAPTERS[:-1]:
        following = read(site, before).select_one(".right-next")
        assert following.select_one(".rs-question").get_text() == asked[following["href"]]


def test_the_map_unfolds_from_the_first_chapter_to_the_last(site: Site) -> None:
    first, last, lost = (
        read(site, name).select_one(".rs-map path")["d"]
        for name in (CHAPTERS[0], CHAPTERS[-1], "404")
    )
    assert first == lost != last


def test_every_map_has_its_wrong_closure_which_the_last_one_shows_at_its_length(
    site: Site,
) -> None:
    lengths = []
    for name in (CHAPTERS[0], CHAPTERS[-1], "404"):
        (wrong,) = read(site, name).select("article .rs-map .rs-is-wrong")
        x, y, to_x, to_y = map(int, wrong["d"].removeprefix("M").split())
        lengths.append(abs(to_x - x) + abs(to_y - y))
    assert 0 < lengths[0] == lengths[2] < lengths[1] / 5
