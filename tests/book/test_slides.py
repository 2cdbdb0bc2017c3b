"""The decks: cut from the chapters' pages, whole on the screen, and alive."""

import json
import os
import re

import pytest
from bs4 import BeautifulSoup
from playwright.sync_api import Locator, Page, expect

from autograder.tests.kernel import leave_out
from tests.book.conftest import CHAPTERS, ROOT
from tests.book.taking_hold import by_keyboard, by_mouse, follows, handles, pictures
from tests.book.test_accessible import complaints
from tests.chromium import served
from tools.slides import marks
from tools.slides.__main__ import install, make
from tools.slides.deck import Source

QUICK = (("00", 1280), ("08", 1024))
"""Decks to look through at a width; in ``make soak`` all are, at both."""
NOTEBOOKS = [ROOT / f"{page}.ipynb" for page in CHAPTERS]
SIZES = {1280: 720, 1024: 768}
"""Of a projector: the width and the height."""
SHOWN = [
    pytest.param(nb.stem, width, marks=() if (nb.stem[:2], width) in QUICK else pytest.mark.soak)
    for nb in NOTEBOOKS
    for width in SIZES
]
BEYOND = """(section) => {
  const frame = document.querySelector(".slides").getBoundingClientRect();
  const out = [...section.querySelectorAll("h1, h2, p, li, td, pre, math, label, button")]
    .filter((each) => !each.closest("aside") && each.checkVisibility())
    .filter((each) => {
      const box = each.getBoundingClientRect();
      const cut = each.closest(".show")?.getBoundingClientRect() ?? frame;
      return box.left < cut.left - 1 || box.right > cut.right + 1
        || box.top < frame.top - 1 || box.bottom > frame.bottom - 20;
    });
  const said = document.createRange();
  said.selectNodeContents(section.querySelector(".rs-caption") ?? section.querySelector("aside"));
  const setup = section.querySelector(".is-picture .setup")?.getBoundingClientRect();
  const covers = setup && said.getBoundingClientRect().bottom > setup.top;
  return [...out.map((each) => each.outerHTML.slice(0, 80)), ...(covers ? ["covered"] : [])];
}"""
FILLED = """(section) => {
  const frame = document.querySelector(".slides").getBoundingClientRect();
  const boxes = [...section.querySelectorAll("h1, h2, .setup, .ask, .show > div")]
    .map((part) => part.getBoundingClientRect());
  return boxes.reduce((sum, box) => sum + box.width * box.height / frame.width / frame.height, 0);
}"""
"""Which part of a slide holds something."""
READ = """(section) => {
  const found = [], words = document.createTreeWalker(section, NodeFilter.SHOW_TEXT);
  while (words.nextNode()) {
    const [text, part] = [words.currentNode.data.trim(), words.currentNode.parentElement];
    if (!text || part.closest("aside, script, style, .rs-spoken")
      || !part.checkVisibility({ visibilityProperty: true, opacityProperty: true })) continue;
    const sized = part.closest("math, text") ?? part;
    const box = sized.closest("text, p, h1, h2, li, td, th, legend, label, button, div");
    const { a, b } = box.getScreenCTM?.()
      ?? { a: box.getBoundingClientRect().width / box.offsetWidth, b: 0 };
    const size = parseFloat(getComputedStyle(sized).fontSize) * Math.hypot(a, b);
    const onScale = box.localName === "text" && /^[−\\d.,]+$/.test(text);
    found.push([onScale ? "" : text, size, box.matches(".ask, legend")]);
  }
  return found;
}"""
"""The words that are seen on a slide, "" on a scale: text, letters' size in pixels, if it asks."""
SPELLED = {
    "ATE": "absolute trajectory error", "DCS": "dynamic covariance scaling",
    "GM": "geman–mcclure", "GNC": "graduated non-convexity",
    "IRLS": "iteratively reweighted least squares", "PCM": "pairwise consistency maximisation",
    "RANSAC": "random sample consensus", "TLS": "truncated least squares",
}  # fmt: skip
DRAWN = """new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(
  () => requestAnimationFrame(done))))"""


@pytest.fixture(scope="module")
def decks(site, tmp_path_factory):
    """A site with the chapters' pages and their decks."""
    try:
        reveal = install()
    except OSError as error:
        leave_out(str(error))
    folder = tmp_path_factory.mktemp("decks")
    (folder / "chapters").mkdir()
    for page in CHAPTERS:
        built = (site.folder / f"{page}.html").read_text(encoding="utf-8")
        # Cells have an address only where the runtime was there.
        built = built.replace(' id="code-', ' data-was="code-')
        (folder / f"{page}.html").write_text(built, encoding="utf-8")
    os.symlink(site.folder / "_static", folder / "_static")
    assert len(make(folder, reveal)) == len(CHAPTERS)
    return folder


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
@pytest.mark.rest
def test_a_deck_is_a_lecture_to_which_its_page_leads(notebook, decks):
    """The first one waits for the decks of all chapters, and for npm to install reveal.js."""
    found = marks.read(notebook)
    assert 10 <= len(found) <= 20
    assert all(mark.notes for mark in found) and len({mark.title for mark in found}) == len(found)
    page = (decks / "chapters" / f"{notebook.stem}.html").read_text(encoding="utf-8")
    link = rf'href="../slides/{notebook.stem}.html".*: (\d+) slides, about (\d+) minutes'
    ((count, minutes),) = re.findall(link, page)
    deck = (decks / "slides" / f"{notebook.stem}.html").read_text("utf-8")
    slides = BeautifulSoup(deck, "html.parser").select("section")
    shown, so_far = [slide["class"][0] for slide in slides], ""
    assert int(count) == len(found) == len(shown) and 20 <= int(minutes) <= 35
    assert sum(each not in {"is-picture", "is-figure"} for each in shown) <= len(found) / 3, shown
    for slide in slides:
        for unseen in slide.select("aside, script, style, figcaption, [role='status']"):
            unseen.decompose()
        so_far += slide.get_text(" ").lower()
        short = {each for each in SPELLED if re.search(rf"\b{each}\b", slide.get_text(" "))}
        assert [each for each in short if SPELLED[each] not in so_far] == [], slide.get_text(" ")


@pytest.mark.parametrize(("name", "width"), SHOWN)
@pytest.mark.browser
@pytest.mark.rest
def test_no_slide_tells_or_overflows_and_all_can_be_used(name, width, decks, open_page):
    """Each is seen at first and with all that keys reveal, by axe-core too; its handles move."""
    view, unit, looks = {"width": width, "height": SIZES[width]}, width / 1280, list[str]()
    with served(decks) as address:  # axe-core reads style sheets, which it may not from a file
        visit = open_page(f"{address}/slides/{name}.html", viewport=view, reduced_motion="reduce")
        page = visit.page
        page.wait_for_function("deck.isReady()")
        for number in range(page.locator("section").count()):
            here, slide = page.locator("section.present"), f"slide {number + 1}"
            page.evaluate(f"deck.slide({number}, 0, -1)")
            page.evaluate(DRAWN)
            assert tells(here) == set(), f"{slide} tells its answer at once"
            page.evaluate(f"deck.slide({number}, 0, 99)")
            page.evaluate(DRAWN)
            assert here.evaluate(BEYOND) == [], slide
            assert here.evaluate(FILLED) >= 0.3, f"{slide} is mostly white"
            sizes = here.evaluate(READ)
            assert [each for each in sizes if each[1] < (28 if each[2] else 22) * unit] == [], (
                slide
            )
            if view["height"] == 720:
                assert complaints(page, seen=looks) == set(), slide
            if here.locator(".rs-picture").count():
                take_hold(page)
        assert visit.complaints == visit.outside == []


def tells(slide: Locator) -> set[str]:
    """The numbers of a claim that waits that can be read already, and not on a scale."""
    claim = slide.locator(":is(h1, h2).fragment").all_text_contents()
    asked = slide.locator(".ask, .setup, form").all_text_contents()
    assert not (claim and slide.locator(".rs-caption:visible").count())
    read = [text for text, *_ in slide.evaluate(READ)]
    number = re.compile(r"\d+(?:[.,/]\d+)*")
    told, known, seen = (set(number.findall(" ".join(each))) for each in (claim, asked, read))
    return (told - known) & seen


def take_hold(page: Page) -> None:
    """Move each kind of handle of the picture on the slide; a presenter's keys alone turn it."""
    number = page.evaluate("deck.getIndices().h")
    (picture,) = [each for each in pictures(page) if each.is_visible()]
    for key in {key.rstrip("0123456789"): key for key in handles(picture)}.values():
        for way in (by_mouse, by_keyboard):
            assert follows(picture, key, way), f"{key}: nothing follows {way.__name__}"
    assert page.evaluate("deck.getIndices().h") == number
    page.keyboard.press("PageDown")
    assert page.evaluate("deck.getIndices().h") == number + 1


@pytest.mark.rest
def test_a_key_after_a_vote_shows_the_answer_and_the_pointer_gives_the_keys_back(decks, open_page):
    page = open_page((decks / "slides" / f"{NOTEBOOKS[2].stem}.html").as_uri()).page
    page.wait_for_function("deck.isReady()")
    here = page.locator("section.present")
    expect(here.locator("h1")).to_have_css("visibility", "hidden")
    here.locator(".rs-choices label").last.click()
    said = here.locator(".rs-caption").inner_text()
    page.keyboard.press("ArrowRight")
    expect(here.locator("h1")).to_have_css("visibility", "visible")
    expect(here.locator(".rs-caption")).not_to_have_text(said)
    for shown in (1, 2):
        page.keyboard.press("ArrowRight")
        assert page.evaluate("deck.getIndices().h") == shown
        (picture,) = [each for each in pictures(page) if each.is_visible()]
        assert follows(picture, handles(picture)[0], by_mouse)
        page.keyboard.press("ArrowRight")
        expect(here.locator("h2")).to_have_css("visibility", "visible")
    slider = here.locator("input[type=range]").first
    page.keyboard.press("Tab")
    slider.focus()
    before = slider.input_value()
    page.keyboard.press("ArrowLeft")
    assert slider.input_value() != before and page.evaluate("deck.getIndices().h") == 2


@pytest.mark.parametrize(
    ("entry", "why"),
    [
        ({"title": "One", "show": "list no such words"}, "0 times the page has a list no such"),
        ({"title": "One", "claims": ["Two"]}, "0 slides before it claim 'Two'"),
        ({"title": "One", "show": "list First", "later": ["td"]}, "nothing that it shows is 'td'"),
        ({"show": "list First", "shows": "table"}, "unknown"),
        ({"show": "list First"}, "give the slide a `title`"),
        ({"title": "One"}, "say what of the text"),
        ({"title": "One", "show": "list First", "after": "there"}, "no cell 'there'"),
    ],
)
def test_a_mark_that_finds_nothing_is_named(entry, why, tmp_path):
    cell = {"cell_type": "markdown", "id": "here", "metadata": {"slides": [entry]}}
    notebook = tmp_path / "one.ipynb"
    notebook.write_text(json.dumps({"cells": [cell]}), encoding="utf-8")
    page = Source("<article><h1>One</h1><ul><li>First.</li></ul></article>", "chapters/one")
    with pytest.raises(marks.BadMark, match=f"one.ipynb, cell here: .*{why}"):
        page.slide(marks.read(notebook)[0], first=True)
