"""The decks: cut from the chapters' pages, whole on the screen, and alive."""

import json
import os
import re

import pytest
from playwright.sync_api import Page, expect

from autograder.tests.kernel import leave_out
from tests.book.conftest import CHAPTERS, ROOT
from tests.book.taking_hold import by_keyboard, by_mouse, follows, handles, pictures
from tests.book.test_accessible import complaints
from tests.chromium import Opener, served
from tools.slides import marks
from tools.slides.__main__ import install, make
from tools.slides.deck import Source

QUICK = (("00", 1280), ("08", 1024))
"""Decks to look through at a width; in ``make soak`` all are, at both."""
NOTEBOOKS = [ROOT / f"{page}.ipynb" for page in CHAPTERS]
SIZES = {1280: 720, 1024: 768}
"""Of a projector: the width and the height."""
SHOWN = [
    pytest.param(
        path.stem, width, marks=() if (path.stem[:2], width) in QUICK else pytest.mark.soak
    )
    for path in NOTEBOOKS
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
  const shown = section.querySelector(".show > div")?.getBoundingClientRect();
  const covers = shown && [...section.querySelectorAll(".words > p")]
    .map((each) => each.getBoundingClientRect())
    .some((words) => words.bottom > shown.top + 1 && words.top < shown.bottom - 1
      && words.right > shown.left + 1 && words.left < shown.right - 1);
  return [...out.map((each) => each.outerHTML.slice(0, 80)), ...(covers ? ["covered"] : [])];
}"""
FILLED = """(section) => {
  const frame = document.querySelector(".slides").getBoundingClientRect();
  const parts = [...section.querySelectorAll("h1, h2, .ask, .words > p, .show > div")];
  const boxes = parts.map((part) => part.getBoundingClientRect());
  const filled = boxes.reduce((sum, box) => sum + box.width * box.height, 0);
  return filled / (frame.width * frame.height);
}"""
"""Which part of a slide holds something."""
ASKED = """(section) => Math.min(Infinity,
  ...[...section.querySelectorAll(".ask, .rs-predict legend")]
  .filter((each) => each.checkVisibility())
  .map((each) => parseFloat(getComputedStyle(each).fontSize)
    * each.getBoundingClientRect().width / each.offsetWidth))"""
"""The letters of the question on a slide, in pixels."""
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
def test_the_words_of_each_mark_stand_in_the_text(notebook):
    """What an edited sentence breaks is seen without a built page."""
    cells = json.loads(notebook.read_text(encoding="utf-8"))["cells"]
    text = "\n\n".join("".join(each["source"]) for each in cells)
    plain = " ".join(re.sub(r"\[([^]]*)\]\([^)]*\)|[*`]", r"\1", text).split())
    words = [words for mark in marks.read(notebook) for words in (*mark.say, *mark.then)]
    assert words and [each for each in words if each not in plain] == []


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
@pytest.mark.rest
def test_a_deck_is_a_lecture_to_which_its_page_leads(notebook, decks):
    """The first one waits for the decks of all chapters, and for npm to install reveal.js."""
    found = marks.read(notebook)
    assert 10 <= len(found) <= 20
    assert 40 <= sum(mark.minutes for mark in found) <= 50
    assert all(mark.notes for mark in found) and len({mark.title for mark in found}) == len(found)
    page = (decks / "chapters" / f"{notebook.stem}.html").read_text(encoding="utf-8")
    assert page.count(f'href="../slides/{notebook.stem}.html"') == 1
    deck = (decks / "slides" / f"{notebook.stem}.html").read_text("utf-8")
    assert deck.count("<section") == len(found)
    shown = re.findall(r'<section class="(?:first )?is-(\w+)"', deck)
    assert sum(kind not in {"picture", "figure"} for kind in shown) <= len(found) / 3, shown


@pytest.mark.parametrize(("name", "width"), SHOWN)
@pytest.mark.browser
@pytest.mark.rest
def test_no_slide_overflows_and_all_can_be_used(name, width, decks, open_page):
    """Every slide is drawn and looked at by axe-core, and its picture's handles are moved."""
    viewport = {"width": width, "height": SIZES[width]}
    with served(decks) as address:  # axe-core reads style sheets, which it may not from a file
        look_through(f"{address}/slides/{name}.html", open_page, viewport)


def look_through(address: str, open_page: Opener, viewport: dict[str, int]) -> None:
    """Show each slide with all that its keys reveal, look at it, and move its picture."""
    visit = open_page(address, viewport=viewport, reduced_motion="reduce")
    page, looks = visit.page, list[str]()
    page.wait_for_function("deck.isReady()")
    for number in range(page.locator("section").count()):
        page.evaluate(f"deck.slide({number}, 0, 99)")
        page.evaluate(DRAWN)
        here = page.locator("section.present")
        assert here.evaluate(BEYOND) == [], f"slide {number + 1}"
        assert here.evaluate(FILLED) >= 0.3, f"slide {number + 1} is mostly white"
        assert here.evaluate(ASKED) >= 28 * viewport["width"] / 1280, f"slide {number + 1}"
        if viewport["height"] == 720:
            assert complaints(page, seen=looks) == set(), f"slide {number + 1}"
        if here.locator(".rs-picture").count():
            take_hold(page)
    assert visit.complaints == visit.outside == []


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
def test_a_deck_opens_from_a_file_and_an_answer_waits_for_a_key(decks, open_page):
    visit = open_page((decks / "slides" / f"{NOTEBOOKS[0].stem}.html").as_uri())
    page = visit.page
    page.wait_for_function("deck.isReady()")
    hidden = page.locator("section:has(.fragment)").first
    number = hidden.evaluate("s => [...s.parentNode.children].indexOf(s)")
    page.evaluate("(k) => deck.slide(k)", number)
    answer = hidden.locator(".fragment").first
    assert answer.evaluate("a => getComputedStyle(a).visibility") == "hidden"
    page.keyboard.press("ArrowRight")
    expect(answer).to_have_class(re.compile(r"\bvisible\b"))
    expect(answer).to_have_css("visibility", "visible")
    assert visit.complaints == visit.outside == []


@pytest.mark.parametrize(
    ("entry", "why"),
    [
        ({"title": "One", "say": "no such words"}, "0 sentences"),
        ({"title": "One", "say": "First", "show": "formula"}, "no formula"),
        ({"say": "First", "shows": "table"}, "unknown"),
        ({"say": "First"}, "give the slide a `title`"),
        ({"title": "One", "show": "table"}, "give the words"),
    ],
)
def test_a_mark_that_finds_nothing_is_named(entry, why, tmp_path):
    cell = {"cell_type": "markdown", "id": "here", "metadata": {"slides": [entry]}}
    notebook = tmp_path / "one.ipynb"
    notebook.write_text(json.dumps({"cells": [cell]}), encoding="utf-8")
    page = Source("<article><h1>One</h1><p>First. Second.</p></article>", "chapters/one")
    with pytest.raises(marks.BadMark, match=f"one.ipynb, cell here: .*{why}"):
        page.slide(marks.read(notebook)[0], first=True)
