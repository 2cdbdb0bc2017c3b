"""A chapter says how long it is and what for, and at its foot what its neighbours ask."""

import re
from itertools import pairwise

import pytest
from bs4 import BeautifulSoup, Tag

from tests.book.conftest import CHAPTERS, PAGES, Site


@pytest.mark.parametrize("name", CHAPTERS)
def test_a_chapter_begins_with_its_length_and_its_goals(name, site):
    page = site.parsed(name)
    line = page.select_one("article h1 + .rs-length")
    assert line
    minutes = re.match(r"\d+(?= minutes )", line.get_text())
    alone = sum(bool(re.fullmatch(r"\d+\.", bold.get_text())) for bold in page.find_all("strong"))
    assert alone and minutes and 30 + 3 * alone <= int(minutes[0]) <= 150
    table = site.parsed("chapters/students").select_one(
        line.a["href"].removeprefix("students.html")
    )
    row = table.select_one(f'tr:has(a[href="{name.split("/")[1]}.html"])')
    assert row.find_all("td")[-1].get_text() == minutes[0]
    assert page.select_one(line.find_all("a")[2]["href"]), "the one link to the code"
    goals = page.select_one(line.find_all("a")[1]["href"])
    assert goals and goals.find_next_sibling().name == "ul"


def test_the_front_page_has_the_map_and_the_time_of_each_chapter(site):
    front = BeautifulSoup((site.folder / f"{PAGES[0]}.html").read_text("utf-8"), "html.parser")
    times = []
    for name, row in zip(CHAPTERS, front.select(".rs-chapters tbody tr"), strict=True):
        assert row.a["href"] == f"{name.split('/')[1]}.html"
        assert row.select_one(".rs-map").path["d"]
        times.append(site.parsed(name).select_one(".rs-length a").get_text())
        assert row.find_all("td")[-1].get_text() == times[-1]
    assert f"Chapter 0, {times[0]}:" in " ".join(front.select_one(".rs-doors").get_text().split())


def test_the_ways_back_and_on_are_chapters_with_their_questions(site):
    rows = site.parsed(PAGES[0]).select("table tbody tr")
    asked = {row.a["href"]: row.find_all("td")[1].get_text() for row in rows}
    for before, after in pairwise(CHAPTERS):
        for name, way in ((before, ".right-next"), (after, ".left-prev")):
            card = site.parsed(name).select_one(way)
            assert card.select_one(".rs-question").get_text() == asked[card["href"]]
            assert card.select_one(".rs-map")


def own(site: Site, name: str) -> Tag:
    """The map of a chapter on the front page, or the only one of a page."""
    front = PAGES[0] if name in CHAPTERS else name
    html = (site.folder / f"{front}.html").read_text("utf-8")
    maps = BeautifulSoup(html, "html.parser").select("svg.rs-map")
    return maps[CHAPTERS.index(name) if name in CHAPTERS else 0]


@pytest.mark.parametrize(
    ("name", "opened"), [(CHAPTERS[4], [1, 0, 0, 0]), ("chapters/labs", [1, 1, 0, 0])]
)
def test_of_the_list_of_pages_the_first_part_and_the_one_that_is_read_are_open(name, opened, site):
    parts = site.parsed(name).select(".bd-links details")
    assert [part.has_attr("open") for part in parts] == opened
    assert all(part.summary.get_text(strip=True) and part.select("a") for part in parts)


def test_the_map_unfolds_from_the_first_chapter_to_the_last(site):
    first, last, lost = (own(site, name).path["d"] for name in (CHAPTERS[0], CHAPTERS[-1], "404"))
    assert first == lost != last


def test_every_map_has_its_wrong_closure_which_the_last_one_shows_at_its_length(site):
    lengths = []
    for name in (CHAPTERS[0], CHAPTERS[-1], "404"):
        wrong = own(site, name).select_one(".rs-is-wrong")
        x, y, to_x, to_y = map(int, wrong["d"].removeprefix("M").split())
        lengths.append(abs(to_x - x) + abs(to_y - y))
    assert 0 < lengths[0] == lengths[2] < lengths[1] / 5
