"""The front page: what the course is, a map, the doors; then the cards of the chapters."""

import re

import pytest

from tests.book.conftest import PAGES, TITLE

pytestmark = pytest.mark.browser

SCREENS = {"desk": (1280, 800), "phone": (390, 844)}
END = "element => element.getBoundingClientRect().bottom"


@pytest.mark.parametrize("screen", SCREENS)
def test_the_first_screen_has_three_doors_and_the_map_and_cards_follow(screen, site, open_page):
    width, height = SCREENS[screen]
    view = {"width": width, "height": height}
    page = open_page((site.folder / f"{PAGES[0]}.html").as_uri(), viewport=view).page
    doors = page.locator(".rs-doors li").all()
    assert len(doors) == 3
    assert all(door.evaluate(END) <= height for door in doors)
    assert all(door.locator("a").get_attribute("href") for door in doors)
    handles = page.locator(".rs-picture").first.locator("[data-handle]")
    assert min(handle.evaluate(END) for handle in handles.all()) <= height
    assert page.locator(".rs-facts").evaluate(END) <= height
    switch = page.get_by_role("checkbox", name="Reject outliers")
    box = switch.bounding_box()
    assert box and box["width"] >= 48 and box["height"] >= 30
    cards = page.locator(".rs-chapters tbody tr").all()
    places = {round(box["x"]) for card in cards if (box := card.bounding_box())}
    assert len(cards) == 10 and len(places) == (2 if screen == "desk" else 1)
    doors[0].click(position={"x": 12, "y": 12})  # beside the words
    page.wait_for_url("**/00-one-lie.html")


def test_the_name_stands_once_in_the_title_of_the_front_page(site):
    html = (site.folder / f"{PAGES[0]}.html").read_text(encoding="utf-8")
    (title,) = re.findall(r"<title>([^<]*)</title>", html)
    assert title.count(TITLE) == 1
