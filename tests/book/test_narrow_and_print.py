"""Code is copied by keyboard and on touch; what paper and calm readers get."""

import io

import pytest
from playwright.sync_api import Page, expect
from pypdf import PdfReader

from tests.book.conftest import Site
from tests.chromium import Opener, visiting

pytestmark = [pytest.mark.browser, pytest.mark.rest]

CHAPTER = "chapters/03-irls"
WIDTHS = "all => all.map(each => each.getBoundingClientRect().width)"
BREAKS = "node => getComputedStyle(node).breakInside"
HIDDEN = """() => [...document.querySelectorAll("article p:not(.rs-length)")]
  .filter((paragraph) => paragraph.checkVisibility())
  .flatMap((paragraph) => [...paragraph.querySelectorAll(
    ":not(svg *, math *, .rs-predict *, .headerlink, .rs-screen, .rs-screen *)")])
  .filter((part) => part.textContent.trim() && !part.checkVisibility())
  .map((part) => part.textContent)"""
"""Words that are missing in paragraphs which are seen."""


def visit(site: Site, open_page: Opener, name: str, **options: object) -> Page:
    return open_page((site.folder / f"{name}.html").as_uri(), **options).page


@pytest.fixture(scope="module")
def chapter(site, browser):
    """A chapter that calm readers see; its tests bring it to the screen or the paper they need."""
    url = (site.folder / f"{CHAPTER}.html").as_uri()
    with visiting(browser, url, reduced_motion="reduce") as visit:
        yield visit.page


class TestCopying:
    def test_the_button_is_seen_on_touch(self, site, open_page):
        page = visit(site, open_page, CHAPTER, has_touch=True, is_mobile=True)
        button = page.get_by_role("button", name="Copy to clipboard").first
        assert float(button.evaluate("b => getComputedStyle(b).opacity")) > 0.8

    def test_each_code_box_has_a_button_that_keys_reach(self, site, open_page):
        page = visit(site, open_page, CHAPTER, permissions=["clipboard-read", "clipboard-write"])
        expect(page.locator(".copybtn").first).to_be_attached()
        boxes = page.locator(".highlight:not(.cell_output *) > pre")
        assert boxes.count() == page.locator(".copybtn").count() > 20
        page.evaluate("document.documentElement.dataset.code = ''")
        button = page.locator(".cell_input .copybtn:visible").first
        code = button.locator("xpath=preceding-sibling::pre").inner_text()
        button.evaluate("b => b.previousElementSibling.focus()")
        page.keyboard.press("Tab")
        expect(button).to_be_focused()
        expect(button).to_have_css("opacity", "1")
        assert button.evaluate("b => getComputedStyle(b).outlineStyle") == "solid"
        page.keyboard.press("Enter")
        expect(button).to_have_attribute("data-tooltip", "Copied!")
        assert page.evaluate("navigator.clipboard.readText()").strip() == code.strip()
        expect(button).to_be_focused()


def test_nothing_moves_for_a_reader_who_asks_for_that(chapter):
    longest = """(of) => Math.max(...[...document.querySelectorAll("*")].flatMap((node) =>
      getComputedStyle(node)[of + "Duration"].split(",").map(parseFloat)))"""
    assert chapter.evaluate(longest, "animation") < 0.001
    assert chapter.evaluate(longest, "transition") == 0
    chapter.emulate_media(reduced_motion="no-preference")
    assert chapter.evaluate(longest, "transition") > 0.1
    chapter.emulate_media(reduced_motion="reduce")


@pytest.mark.parametrize("width", [768, 1024, 1280, 1920])
def test_lines_are_no_longer_than_eyes_follow_and_cards_stand_in_the_column(width, chapter):
    chapter.set_viewport_size({"width": width, "height": 800})
    texts = chapter.locator("article :is(p, li):not(.rs-picture *, summary *):visible")
    widths = texts.evaluate_all(WIDTHS)
    assert 600 < max(widths) <= 44 * 16
    head, foot = chapter.locator("article h1").bounding_box(), chapter.locator(".prev-next-area a")
    first, last = (foot.nth(k).bounding_box() for k in (0, 1))
    assert head and first and last and first["y"] == last["y"]
    assert first["x"] == pytest.approx(head["x"], abs=1)
    assert last["x"] + last["width"] == pytest.approx(head["x"] + head["width"], abs=1)


def test_on_paper_what_fits_stays_whole_and_nothing_can_be_pressed(chapter):
    page = chapter
    page.emulate_media(media="print")
    short = "table:not(.rs-cards, :has(tbody tr:nth-child(9)))"
    for kind in ("pre", "figure", short, ".rs-picture", ".admonition", ".rs-quiz fieldset"):
        breaks = page.locator(f"article {kind}").evaluate_all(f"all => all.map({BREAKS})")
        assert set(breaks) == {"avoid"}, kind
    assert page.locator(".cell_output:has(.rs-quiz)").first.evaluate(BREAKS) == "auto"
    after = BREAKS.replace("Inside", "After")
    assert set(page.locator("article h2").evaluate_all(f"all => all.map({after})")) == {"avoid"}
    assert page.locator(".rs-word").count() and page.evaluate(HIDDEN) == []
    assert page.locator("h1:visible").count() == 1
    pressed = "button:not(.rs-word), nav, input[type=range], select, form.bd-search, .copybtn"
    expect(page.locator(f":is({pressed}):visible")).to_have_count(0)


def test_a_chapter_on_paper_has_margins_and_numbers(chapter):
    page = chapter
    places: list[tuple[float, float, str]] = []
    second = PdfReader(io.BytesIO(page.pdf(prefer_css_page_size=True))).pages[1]
    second.extract_text(
        visitor_text=lambda text, here, to, *_: places.append(
            (here[0] * to[4] + here[4], here[3] * to[5] + here[5], text.strip())
        )
    )
    wide, high = second.mediabox[2:]
    texts = [(x, y, text) for x, y, text in places if text]
    (number,) = (x for x, y, text in texts if text == "2" and not 40 < y < high - 40)
    assert abs(number - wide / 2) < 5
    assert min(x for x, *_ in texts) == pytest.approx(17 / 25.4 * 72, abs=9)
    page.emulate_media(media="print")
    lefts = [
        page.locator(part).first.bounding_box()["x"]
        for part in ("h1:visible", "article h2", "article section > p")
    ]
    assert len(set(lefts)) == 1
    widths = page.locator("article section > p").evaluate_all(WIDTHS)
    assert max(widths) == page.locator("article").bounding_box()["width"]


def test_answers_are_printed_at_the_end_and_put_back(chapter):
    chapter.locator(".rs-picture[data-live]").first.wait_for()
    before = chapter.locator("article section").all_text_contents()
    chapter.emulate_media(media="screen")
    chapter.evaluate("dispatchEvent(new Event('beforeprint'))")
    answers = chapter.locator("article > .rs-answers:last-child")
    assert answers.locator("details[open]").count() > 3
    assert "✓ Right" in (answers.text_content() or "")
    assert chapter.locator("article .rs-paper").count() > 0
    chapter.evaluate("dispatchEvent(new Event('afterprint'))")
    assert chapter.locator("article section").all_text_contents() == before


@pytest.mark.parametrize("name", ["benchmark", "references"])
def test_the_head_of_the_list_and_the_page_that_is_read_are_both_seen(name, site, open_page):
    """Also where the list was scrolled to its end on another page."""
    page = visit(site, open_page, "chapters/00-one-lie", viewport={"width": 1280, "height": 800})
    for here in (name, "02-four-costs"):
        page.goto((site.folder / f"chapters/{here}.html").as_uri())
        sidebar = page.locator(".bd-sidebar-primary")
        for part in (".navbar-brand", ".search-button-field", ".current > a"):
            expect(sidebar.locator(part)).to_be_in_viewport(ratio=1)
        foot = sidebar.locator(".search-button-field").bounding_box()
        current = sidebar.locator(".current > a").bounding_box()
        assert foot and current and current["y"] > foot["y"] + foot["height"]


def test_the_first_key_leads_to_the_text(site, open_page):
    page = visit(site, open_page, CHAPTER)
    page.keyboard.press("Tab")
    link = page.get_by_role("link", name="Skip to main content")
    expect(link).to_be_focused()
    expect(link).to_be_in_viewport()
    page.keyboard.press("Enter")
    page.keyboard.press("Tab")
    assert page.evaluate("document.querySelector('main').contains(document.activeElement)")


def test_on_a_phone_the_way_on_is_no_narrow_column(site, open_page):
    phone = {"width": 390, "height": 844}
    page = visit(site, open_page, "chapters/00-one-lie", viewport=phone)
    box = page.locator(".prev-next-area .right-next").bounding_box()
    assert box and box["width"] > 300
