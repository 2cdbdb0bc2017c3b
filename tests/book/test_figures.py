"""Notebooks on a phone, and their figures: large letters, colours of the page, no cards."""

import functools
import re
from collections.abc import Callable

import pytest

from tests.book import test_pages
from tests.book.conftest import CHAPTERS, NOTEBOOKS
from tests.book.test_accessible import leave_alone
from tests.course.contrast import contrast, luminance

pytestmark = pytest.mark.browser

WIDE, PHONE = 1280, test_pages.PHONE["width"]
SMALLEST = 11.0
"""Pixels that a letter stands high on a phone."""

READ = """() => [...document.querySelectorAll(".rs-figure")].map((figure) => {
  const shown = [...figure.children].filter((svg) => svg.getBoundingClientRect().width);
  const here = ({ left, right, top, bottom }) => [left, right, top, bottom];
  return {
    role: figure.getAttribute("role"),
    label: figure.getAttribute("aria-label"),
    kinds: shown.map((svg) => svg.getAttribute("class")),
    font: getComputedStyle(figure).fontFamily,
    ground: getComputedStyle(document.body).backgroundColor,
    texts: shown.flatMap((svg) => [...svg.querySelectorAll("text")]).map((text) => {
      const { fontFamily, fontSize, fill } = getComputedStyle(text);
      const { a, b } = text.getScreenCTM();
      const size = parseFloat(fontSize) * Math.hypot(a, b);
      return { said: text.textContent, font: fontFamily, size, fill,
               box: here(text.getBoundingClientRect()) };
    }),
    grounds: shown.map((svg) => getComputedStyle(svg).backgroundColor),
    told: [".caption-number", ".caption-text"].every((part) => (
      figure.closest("figure")?.querySelector(`figcaption ${part}`)?.textContent.trim())),
  };
})"""

Figure = dict[str, object]
"""What a figure of a page is, as the browser has it."""
Reader = Callable[..., list[Figure]]


@pytest.fixture(scope="module", params=NOTEBOOKS)
def visit(request, site, browser):
    """A page with cells, open while its tests run."""
    with test_pages.opened(request.param, site, browser) as visit:
        yield visit


@pytest.fixture(scope="module")
def read(visit):
    """A function that reads the figures of the page on a screen of a width; it keeps them.

    From here on the page holds nothing else.
    """
    page = visit.page
    leave_alone(page, ".rs-figure")

    @functools.cache
    def figures(width: int, theme: str = "light", media: str = "screen") -> list[Figure]:
        page.set_viewport_size({"width": width, "height": 900})
        page.emulate_media(media=media)
        page.evaluate(f"document.documentElement.dataset.theme = '{theme}'")
        return page.evaluate(READ)

    return figures


@functools.cache
def lightness(colour: str) -> float:
    """The relative luminance of a colour as browsers write it."""
    return luminance([int(part) / 255 for part in re.findall(r"\d+", colour)[:3]])


def touching(texts: list[Figure]) -> list[tuple[object, object]]:
    """Pairs of texts of which a good part lies on the other."""
    found = []
    for number, text in enumerate(texts):
        for other in texts[:number]:
            (left, right, top, bottom), (l2, r2, t2, b2) = text["box"], other["box"]
            if min(right, r2) - max(left, l2) > 1 and min(bottom, b2) - max(top, t2) > 4:
                found.append((other["said"], text["said"]))
    return found


class TestPage(test_pages.EveryPage):
    """What holds for every page, before the figures are left alone on it."""

    def test_it_offers_nothing_that_a_file_cannot_fetch(self, visit):
        assert visit.page.locator(".rs-run").count() == 0


@pytest.mark.rest
class TestFigures:
    def test_each_is_an_image_with_words_a_number_and_a_caption(self, visit, read):
        figures = read(WIDE)
        assert figures or not any(page in visit.page.url for page in CHAPTERS)
        for figure in figures:
            assert figure["role"] == "img" and len(str(figure["label"])) > 20
            assert figure["told"], figure["label"]

    @pytest.mark.parametrize(("width", "kind"), [(WIDE, "rs-wide"), (PHONE, "rs-narrow")])
    def test_there_is_room_for_what_is_drawn(self, read, width, kind):
        for figure in read(width):
            assert figure["kinds"] == [kind]
            assert touching(figure["texts"]) == []

    def test_letters_are_large_enough_on_a_phone(self, read):
        for figure in read(PHONE):
            sizes = {text["said"]: text["size"] for text in figure["texts"]}
            assert {said: size for said, size in sizes.items() if size < SMALLEST} == {}

    @pytest.mark.parametrize(
        ("theme", "media"), [("light", "screen"), ("dark", "screen"), ("dark", "print")]
    )
    def test_letters_are_those_of_the_page_and_paper_is_light(self, read, theme, media):
        for figure in read(WIDE, theme, media):
            assert set(figure["grounds"]) == {"rgba(0, 0, 0, 0)"}
            ground = "rgb(255, 255, 255)" if media == "print" else str(figure["ground"])
            for text in figure["texts"]:
                assert text["font"] == figure["font"]
                assert contrast(*map(lightness, (text["fill"], ground))) >= 4.5, text["said"]


def test_touching_words_are_found():
    one, other = ({"said": said, "box": [x, x + 20, 0, 10]} for said, x in (("a", 0), ("b", 15)))
    assert touching([one, other]) == [("a", "b")]
    assert touching([one, {"said": "c", "box": [25, 40, 0, 10]}]) == []
