"""The live pictures of the pages in Chromium: taken hold of by mouse, by touch and by keys."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import quote

import numpy as np
import pytest
import robust_slam_course.pictures
from playwright.sync_api import Browser, Locator, expect
from robust_slam_course.pictures import cycles

from autograder.tests import kernel
from tests.book import taking_hold
from tests.book.conftest import NOTEBOOKS, PAGES, ROOT, place
from tests.book.taking_hold import handles, pictures, reset, seen, take_hold, unfold
from tests.book.test_accessible import leave_alone
from tests.chromium import Visit, visiting

pytestmark = pytest.mark.browser

STATES = """() => [...document.querySelectorAll(".rs-picture script[type='application/json']")]
  .map((script) => JSON.parse(script.textContent)).map(({name, state}) => [name, state])"""
"""The names and first states of a page's pictures."""
FOLDED = """async (picture) => {
  const box = (part) => picture.querySelector(part).getBoundingClientRect();
  const more = picture.querySelector("details");
  more.open = false;
  const texts = [...picture.querySelectorAll("svg text")];
  const found = [picture.getBoundingClientRect().height,
    box(".rs-caption").bottom - box(".rs-controls [data-control]").top,
    Math.min(...texts.map((text) => parseFloat(getComputedStyle(text).fontSize)))];
  more.open = true;
  return found;
}"""
"""The height of a folded picture, from its first control to the end of its words, its letters."""
EXTREMES = Path(__file__).with_name("one_screen.js").read_text(encoding="utf-8")
WITH_PICTURES = [
    PAGES[0],
    *(page for page in NOTEBOOKS if "pictures." in (ROOT / f"{page}.ipynb").read_text("utf-8")),
]

ENDS = ("valuemin", "valuemax")
OF_HANDLE = """(picture, [key, part]) => picture.querySelector(
  `[data-handle="${key}"]`).getAttribute(`aria-${part}`)"""


@dataclass(frozen=True)
class Look:
    """How a page is opened; a phone has touch in place of a mouse."""

    way: str
    theme: str
    width: int

    @property
    def options(self) -> dict[str, object]:
        phone = self.width < 500
        size = {"width": self.width, "height": 900}
        # With less movement each state is drawn at once, so that nothing has to be waited for.
        return {
            "viewport": size, "color_scheme": self.theme, "has_touch": phone,
            "reduced_motion": "reduce",
        }  # fmt: skip

    @property
    def ways(self) -> tuple[Callable[[Locator, str, int], None], ...]:
        """How a handle is moved: on a phone by touch, at the desk by mouse and by keys."""
        desk = (taking_hold.by_mouse, taking_hold.by_keyboard)
        return (taking_hold.by_touch,) if self.width < 500 else desk


DESK, PHONE = Look("http", "light", 1280), Look("file", "dark", 390)

OPENED = {
    look: [pytest.param((page, look), marks=pytest.mark.rest) for page in WITH_PICTURES]
    for look in (DESK, PHONE)
}
"""The same objects for all tests, so that pytest opens each page once."""
DESKS, PHONES = (
    pytest.mark.parametrize("opened", each, indirect=True, ids=WITH_PICTURES, scope="module")
    for each in OPENED.values()
)
"""At the desk alone, or on the phone alone, where the words below a picture take most lines."""


@pytest.fixture(
    scope="module",
    params=[each for looks in zip(*OPENED.values(), strict=True) for each in looks],
    ids=lambda chosen: f"{chosen[0]}-{chosen[1].width}",
)
def opened(request, site, address, browser):
    """A page, open while its tests run: once it is seen to be well, its pictures alone."""
    page, look = request.param
    with visiting(browser, place(site, address, page, look.way), **look.options) as visit:
        visit.page.wait_for_load_state("load")
        assert_well(visit, look)
        leave_alone(visit.page, ".rs-picture")
        for picture in pictures(visit.page):
            unfold(picture)
        yield visit, look


def assert_well(visit: Visit, look: Look) -> None:
    """A picture, be it still, is among the first two screens; the page fits and is well."""
    first = visit.page.locator(".rs-picture, .rs-figure").first
    top = first.evaluate("picture => picture.getBoundingClientRect().top + window.scrollY")
    assert top < 2 * 900, f"{look.width} px: the first picture begins {top:.0f} px down the page"
    assert too_wide(visit) <= 0
    assert visit.complaints == visit.outside == []


def too_wide(visit: Visit) -> int:
    return int(visit.page.evaluate("document.documentElement.scrollWidth - window.innerWidth"))


def test_each_handle_is_moved_in_every_way(opened):
    """Handles whose keys differ in their numbers alone are moved alike: the last one is.

    A finger moves them as the mouse does: on the phone it moves the first one.
    """
    visit, look = opened
    for picture in pictures(visit.page):
        reset(picture)
        kinds = {key.rstrip("0123456789"): key for key in handles(picture)}
        for key in list(kinds.values())[: 1 if look is PHONE else None]:
            for way in look.ways:
                follows = taking_hold.follows(picture, key, way)
                assert follows, f"{key}: nothing follows {way.__name__}"
    assert visit.complaints == []


@DESKS
def test_each_handle_says_its_name_and_value_and_more_to_try_is_one_question(opened):
    for picture in pictures(opened[0].page):
        reset(picture)
        found = picture.locator("[data-handle]").evaluate_all(
            """handles => handles.map((handle) => ["label", "valuetext", "valuemin", "valuenow",
              "valuemax"].map((name) => handle.getAttribute(`aria-${name}`)))"""
        )
        for name, text, *values in found:
            assert name and text
            least, now, most = map(float, values)
            assert least <= now <= most, f"{name}: {least} {now} {most}"
        assert len({name for name, *_ in found}) == len(found)
        assert picture.locator("details .rs-ask").count() == 1
        assert picture.locator("details .rs-controls > *").count() <= 1
        assert picture.locator(".rs-icons button").count() == 2


@DESKS
def test_keys_bring_a_handle_to_the_ends_of_its_range_and_a_tenth_of_it_on(opened):
    """Where another end is in the way, or arrows hold one another, as near as that lets it."""
    for picture in pictures(opened[0].page):
        reset(picture)
        for key in {key.rstrip("0123456789"): key for key in handles(picture)}.values():
            least, most = (float(picture.evaluate(OF_HANDLE, [key, end])) for end in ENDS)
            places = {}
            for pressed in ("End", "Home", "PageUp"):
                handle = f"picture.querySelector('[data-handle=\"{key}\"]')"
                picture.evaluate(f"picture => {handle}.focus()")
                picture.page.keyboard.press(pressed)
                seen(picture)
                places[pressed] = float(picture.evaluate(OF_HANDLE, [key, "valuenow"]))
            slack = max(2.0, 0.12 * (most - least))
            slack = most - least if key.startswith("heading") else slack
            assert most - slack <= places["End"] <= most, key
            assert least <= places["Home"] <= least + slack, key
            assert places["Home"] < places["PageUp"] < places["End"] or slack > 300, key
        reset(picture)


def test_only_the_front_page_and_chapter_0_sound(site):
    sound = [
        name
        for name in WITH_PICTURES
        if "Listen to the edges" in (site.folder / f"{name}.html").read_text("utf-8")
    ]
    assert sound == [PAGES[0], "chapters/00-one-lie"]


@PHONES
def test_each_control_changes_the_picture_and_reset_brings_it_back(opened):
    """Each control of each picture is moved and put back; solvers in the page draw it anew."""
    for picture in pictures(opened[0].page):
        reset(picture)
        first = seen(picture)
        for control in taking_hold.controls(picture):
            taking_hold.move(control)
            now, name = seen(picture), control.get_attribute("data-control")
            assert now[:2] != first[:2], f"{name}: drawing and words stay as they were"
            taking_hold.assert_below_stays(first, now)
            reset(picture)
            assert seen(picture) == first, f"{name}: the first state did not come back"
        take_hold(picture, 1)
        picture.locator("[data-control=reset]").click()
        assert seen(picture) == first, "the button did not bring the first state back"


def test_a_picture_fits_one_screen_and_nothing_leaves_its_panel_or_covers_a_label(opened, request):
    """Folded, it is no taller than a window, and its control is beside its words.

    It is seen in the first state, at both ends of each control, and with a handle in each corner:
    the last on the phone, where there is least room, and in ``make soak`` at the desk too.
    """
    visit, look = opened
    for picture in pictures(visit.page):
        height, apart, letters = picture.evaluate(FOLDED)
        assert height <= (700 if look.width < 500 else 640)
        assert apart <= 200
        assert letters >= 14
    assert too_wide(visit) <= 0
    with_handles = look is PHONE or kernel.is_soak(request.config)
    for picture in pictures(visit.page):
        assert picture.evaluate(EXTREMES, with_handles) == []
    assert visit.complaints == []


@DESKS
def test_a_link_brings_the_state_back_and_a_name_that_every_object_has_stops_no_picture(opened):
    """The links are followed in the open page, as if they were pasted."""
    visit, _ = opened
    for picture in pictures(visit.page):
        reset(picture)
        first = seen(picture)
        moved = move_a_handle(picture)
        picture.locator("[data-control=link]").click()
        reset(picture)
        assert seen(picture) == first != moved
        visit.page.evaluate("() => { dispatchEvent(new HashChangeEvent('hashchange')); }")
        assert seen(picture) == moved
        reset(picture)
    for number, (name, state) in enumerate(visit.page.evaluate(STATES)):
        for key in (key for key, value in state.items() if isinstance(value, str)):
            link = f"#{name}={quote(json.dumps({key: 'constructor'}))}"
            visit.page.evaluate("(link) => { location.hash = link; }", link)
            assert seen(pictures(visit.page)[number])
            assert visit.complaints == []


def move_a_handle(picture: Locator) -> taking_hold.Seen:
    """Move the first handle until something else is seen, and return that."""
    first = seen(picture)
    for toward in (1, -1):
        take_hold(picture, toward)
        if seen(picture) != first:
            break
    return seen(picture)


class TestTown:
    """What the frame does, seen at the opening map."""

    @pytest.fixture
    def at(self, site, address):
        return place(site, address, PAGES[0], "file")

    def test_a_finger_beside_the_handles_scrolls_the_page(self, at, browser):
        with visiting(browser, at, **PHONE.options) as visit:
            stage = visit.page.locator(".rs-stage").first
            stage.scroll_into_view_if_needed()
            before = visit.page.evaluate("window.scrollY")
            box = stage.bounding_box()
            assert box is not None
            taking_hold.swipe(visit.page, box["x"] + 6, box["y"] + box["height"] / 2, 0, -200)
            visit.page.wait_for_function(f"window.scrollY > {before} + 100")

    def test_a_map_glides_but_not_where_motion_is_unwelcome(self, at, browser):
        still, gliding = (states_between(at, browser, how) for how in ("reduce", "no-preference"))
        assert still <= 2 < gliding, "however few frames a busy machine draws"

    def test_a_foreign_link_changes_nothing_that_it_may_not(self, at, browser):
        foreign = quote('{"wrong":[[1,9e9],"x"],"z":1}')
        with visiting(browser, f"{at}#opening={foreign}", **DESK.options) as visit:
            assert pictures(visit.page)
            assert not handles(pictures(visit.page)[0])
            assert visit.complaints == []

    def test_the_caption_is_spoken_once_the_hand_rests(self, at, browser):
        with visiting(browser, at, **DESK.options) as visit:
            picture = pictures(visit.page)[0]
            take_hold(picture, 1)
            seen(picture)
            expect(picture.locator("[aria-live=polite]")).to_have_text(taking_hold.words(picture))

    def test_without_scripts_the_still_picture_stands_with_its_words(self, at, browser):
        with visiting(browser, at, java_script_enabled=False) as visit:
            picture = visit.page.locator(".rs-picture").first
            assert picture.locator("img").is_visible()
            assert picture.locator("img").get_attribute("alt")
            assert picture.locator("figcaption").is_visible()


class TestAlone:
    @pytest.fixture
    def alone(self, open_page):
        """Open a picture alone, by a link to a state."""

        def opened(name: str, **state: object) -> Locator:
            link = f"about:blank#{name}={quote(json.dumps(state))}"
            page = open_page(link, **DESK.options).page
            page.set_content(getattr(robust_slam_course.pictures, name)().static_html())
            return pictures(page)[0]

        return opened

    @pytest.mark.parametrize(
        ("state", "shown"), [({"sigma": 1}, True), ({"correct": False}, False)]
    )
    def test_a_link_to_a_folded_setting_unfolds_it(self, alone, state, shown):
        more = alone("cycles", **state).locator("details")
        assert more.evaluate("it => it.open") == shown

    def test_the_scale_of_a_town_stays_whatever_bends(self, alone):
        picture = alone("cycles")
        truth = picture.locator("path.is-ghost").first
        before = truth.get_attribute("d")
        picture.locator("[data-control=correct]").click()
        seen(picture)
        assert truth.get_attribute("d") == before

    def test_the_view_stays_until_the_hand_leaves_the_drawing(self, alone):
        picture = alone("showcase", place=11)
        truth = picture.locator("path.is-ghost").first
        before = truth.get_attribute("d")
        taking_hold.by_mouse(picture, "place", -1)
        folded = seen(picture)
        assert truth.get_attribute("d") == before
        picture.page.mouse.move(0, 0)
        assert seen(picture).drawing != folded.drawing and truth.get_attribute("d") != before

    def test_where_the_drive_crosses_itself_a_handle_stays_on_its_visit(self, alone):
        places = np.reshape(cycles().data["truth"], (-1, 3))[:, :2]
        apart = np.linalg.norm(places[:, None] - places, axis=2)
        late = next(k for k in range(40, 98) if (apart[k, : k - 5] < 0.01).any())
        picture = alone("cycles", wrong=[late, 5])
        there = taking_hold.middle(picture, "closure-0-0")
        taking_hold.by_keyboard(picture, "closure-0-0", 1)
        seen(picture)
        mouse = picture.page.mouse
        mouse.move(*taking_hold.middle(picture, "closure-0-0"))
        mouse.down()
        mouse.move(*there, steps=12)
        seen(picture)
        assert abs(int(picture.evaluate(OF_HANDLE, ["closure-0-0", "valuenow"])) - late) <= 6

    @pytest.mark.parametrize("key", ["offset", "closure-0-0"])
    def test_of_handles_at_one_place_the_last_one_is_taken_again(self, alone, key):
        picture = alone("breaking", ends=[2, 9], offset=[-1, 0])
        assert taking_hold.middle(picture, "offset") == pytest.approx(
            taking_hold.middle(picture, "closure-0-0"), abs=1
        )
        picture.locator(f"[data-handle={key}]").focus()
        taking_hold.by_mouse(picture, key, 1)
        assert picture.evaluate("() => document.activeElement.dataset.handle") == key

    def test_the_best_attack_is_told_once_the_question_is_answered(self, alone):
        picture = alone("breaking", offset=[0, 1], count=3)
        told = taking_hold.words(picture)
        assert told.startswith("Fooled") and "best attack" not in told
        picture.locator(".rs-predict label").first.click()
        picture.locator("[data-control=count]").press("ArrowRight")
        expect(picture.locator(".rs-caption")).to_contain_text("The best attack has 2 outliers")

    def test_a_tie_is_named(self, alone):
        told = taking_hold.words(alone("consistency", count=8))
        assert told.startswith("8 against 8 is a tie: PCM happens to keep the outliers")

    def test_an_answer_joins_the_closure_and_changes_nothing_else(self, alone):
        picture = alone("opening")
        picture.locator("[data-control=robust]").click()
        picture.locator(".rs-predict label").first.click()
        assert seen(picture).caption.startswith("GNC rejects the wrong closure")


def states_between(at: str, browser: Browser, motion: str) -> int:
    """How many maps are seen on the way from one state to the next."""
    size = {"width": 1280, "height": 900}
    with visiting(browser, at, viewport=size, reduced_motion=motion) as visit:
        found = visit.page.evaluate(
            """async () => {
              const picture = document.querySelector('.rs-picture[data-live]');
              const drive = 'path.rs-drive.is-estimate';
              const line = () => picture.querySelector(drive).getAttribute('d');
              const seen = new Set([line()]);
              picture.querySelector('.rs-predict input').click();
              for (let k = 0; k < 40; k += 1) {
                await new Promise(requestAnimationFrame);
                seen.add(line());
              }
              return seen.size;
            }"""
        )
    return int(found)
