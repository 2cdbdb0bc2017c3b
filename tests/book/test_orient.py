"""A chapter says how long it is and what for, and at its foot what its neighbours ask."""

import re
from itertools import pairwise

import pytest
from bs4 import BeautifulSoup

from tests.book.conftest import CHAPTERS, PAGES


@pytest.mark.parametrize("name", CHAPTERS)
def test_a_chapter_begins_with_its_length_and_its_goals(name, site):
    page = site.parsed(name)
    line = page.select_one("article h1 + .rs-length")
    assert line
    minutes = re.match(r"\d+(?= minutes )", line.get_text())
    alone = sum(bool(re.fullmatch(r"\d+\.", bold.get_text())) for bold in page.find_all("strong"))
    assert alone and minutes and 30 + 3 * alone <= int(minutes[0]) <= 150
    place = line.a["href"].removeprefix("students.html")
    table = site.parsed("chapters/students").select_one(place)
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


@pytest.mark.parametrize(
    ("name", "opened"), [(CHAPTERS[4], [1, 0, 0, 0]), ("chapters/labs", [1, 1, 0, 0])]
)
def test_of_the_list_of_pages_the_first_part_and_the_one_that_is_read_are_open(name, opened, site):
    parts = site.parsed(name).select(".bd-links details")
    assert [part.has_attr("open") for part in parts] == opened
    assert all(part.summary.get_text(strip=True) and part.select("a") for part in parts)


def test_the_map_unfolds_to_the_last_chapter_and_its_wrong_closure_to_its_length(site):
    pages = ((site.folder / f"{name}.html").read_text("utf-8") for name in (PAGES[0], "404"))
    front, (lost,) = (BeautifulSoup(page, "html.parser").select("svg.rs-map") for page in pages)
    chosen, lengths = (front[0], front[len(CHAPTERS) - 1], lost), []
    drawn = [each.path["d"] for each in chosen]
    assert drawn[0] == drawn[2] != drawn[1]
    for each in chosen:
        x, y, to_x, to_y = map(int, each.select_one(".rs-is-wrong")["d"][1:].split())
        lengths.append(abs(to_x - x) + abs(to_y - y))
    assert 0 < lengths[0] == lengths[2] < lengths[1] / 5
