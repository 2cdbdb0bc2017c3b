"""The printed book: contents, bookmarks and links agree, and nothing of the site is lost."""

import io
import re
import shutil
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from bs4 import BeautifulSoup
from playwright.sync_api import Page
from pypdf import PageObject, PdfReader

from autograder.tests.kernel import leave_out
from tests.book.built_site import DRAWN
from tests.book.conftest import PAGES
from tools.print.__main__ import LIVE, book, drawn, places, write

pytestmark = [pytest.mark.browser, pytest.mark.long, pytest.mark.rest]
FEW = ["chapters/00-one-lie", "chapters/how-large-a-map", "chapters/cheat-sheet"]
ID = re.compile(r'<[a-z][^<>]*\sid="([^"]*)"')
LEAD = re.compile(r'<a\b[^<>]*\shref="#([^"]*)"')
NEAR, COLUMN = 36.0, 200.0
"""Points from a heading's upper edge to the first line of its text and less than the second; and
from its left edge to where text of its column may start."""
KINDS = (
    *("figure", "div.math", ".rs-picture", ".rs-predict", ":is(.citation, .footnote)"),
    "h2:not(.rs-answers > h2)",
)
COUNT = """([html, kinds]) => {
  const found = new DOMParser().parseFromString(html, "text/html");
  return kinds.map((kind) => found.querySelectorAll(kind).length);
}"""

STRUCK = """rows => rows.flatMap((row) => [...row.querySelectorAll('path[d$=h24]')]).map((one) => {
  const {left, right, top, bottom} = one.getBoundingClientRect();
  return [...one.closest("svg").querySelectorAll("text")].some((text) => {
    const word = text.getBoundingClientRect();
    return word.left < right && left < word.right && word.top < bottom && top < word.bottom;
  });
})"""
"""Whether each sample of a line in legends on paper lies on a word."""


def counted(page: Page, html: str, below: str) -> list[int]:
    kinds = [f"{below} {kind}" for kind in KINDS]
    return page.evaluate(COUNT, [DRAWN.sub(r"\1", html), kinds])


@pytest.fixture(scope="module")
def printed(site, tmp_path_factory):
    """A book of a few pages, and its PDF."""
    if not (shutil.which("chromium-headless-shell") or shutil.which("chromium")):
        leave_out("chromium-headless-shell is not installed; no book can be printed")
    target = tmp_path_factory.mktemp("print") / "book.pdf"
    # In a thread of its own, because Playwright has one loop in each, and tests have begun theirs.
    with ThreadPoolExecutor(1) as apart:
        joined = book(site.folder, FEW, apart.submit(drawn, site.folder, FEW).result())
        pages = apart.submit(write, joined, target, "letter").result()
    assert pages == len(PdfReader(target).pages)
    return joined, PdfReader(target), target


def test_contents_and_bookmarks_name_the_pages_where_sections_begin(printed):
    """The first one waits until Chromium has printed a book of three pages."""
    joined, reader, target = printed
    listed = places(target)
    contents = "\n".join(page.extract_text() for page in reader.pages[1:3])
    numbers = [listed[line.id] for line in joined.lines]
    assert numbers == sorted(numbers) and len(numbers) > 15
    marks = {
        (" ".join(str(mark.title).split()), reader.get_destination_page_number(mark) + 1)
        for mark in flat(reader.outline)
    }
    for line, number in zip(joined.lines, numbers, strict=True):
        title = BeautifulSoup(line.title, "html.parser").get_text()
        assert re.search(rf"{re.escape(title)}\s*{number}\b", contents), title
        assert (title, number) in marks
        assert title in reader.pages[number - 1].extract_text()


def test_a_line_of_text_holds_as_many_letters_as_eyes_follow(printed):
    _, reader, target = printed
    first, last = (places(target)[page] for page in FEW[:2])
    texts = [page.extract_text() for page in reader.pages[first - 1 : last - 1]]
    lines = [len(line) for text in texts for line in text.splitlines() if len(line.split()) > 8]
    assert len(lines) > 100 and 75 < np.quantile(lines, 0.75) < 93


def test_a_picture_has_its_states_and_is_wider_than_the_text(printed, open_page, tmp_path):
    (source := tmp_path / "book.html").write_text(printed[0].html({}), encoding="utf-8")
    page = open_page(source.as_uri()).page
    page.emulate_media(media="print")
    picture = page.locator(".rs-picture").first
    assert picture.locator(".rs-paper figure svg").count() == 2 > picture.locator("img").count()
    widths = "all => Math.max(...all.map((each) => each.getBoundingClientRect().width))"
    wide = page.locator(".rs-paper").evaluate_all(widths)
    assert wide > page.locator(".page:has(.rs-picture) section > p").evaluate_all(widths) > 400


def test_no_sample_of_a_legend_strikes_a_word(site, open_page):
    """Also where it takes two lines, as on paper; it is laid out before paper is seen."""
    page = open_page("about:blank").page
    for name in ("chapters/01-m-estimators", "chapters/03-irls", "chapters/08-showcase"):
        page.goto((site.folder / f"{name}.html").as_uri())
        page.wait_for_function(LIVE)
        page.evaluate("dispatchEvent(new Event('beforeprint'))")
        page.emulate_media(media="print")
        struck = page.locator(".rs-paper").evaluate_all(STRUCK)
        assert len(struck) > 5 and not any(struck), name
        page.emulate_media(media="screen")


def flat(outline: list[object]) -> list[object]:
    return [each for one in outline for each in (flat(one) if isinstance(one, list) else [one])]


def lone(printed: PdfReader) -> list[tuple[int, str]]:
    """Page and title of each heading with at most one line of text between it and the foot.

    The text's place decides, because its order in the file is not that on the page.
    """
    starts: dict[int, list[tuple[float, float]]] = {}
    found = []
    for mark in flat(printed.outline):
        number = printed.get_destination_page_number(mark)
        if number not in starts:
            starts[number] = places_of_text(printed.pages[number])
        left, top = float(mark.left), float(mark.top)
        if not any(abs(x - left) < COLUMN and y < top - NEAR for x, y in starts[number]):
            found.append((number + 1, str(mark.title)))
    return found


def places_of_text(page: PageObject) -> list[tuple[float, float]]:
    """Where each piece of a page's text starts, in points from the lower left corner."""
    found = []

    def see(text: str, now: list[float], line: list[float], *_: object) -> None:
        if text.strip():
            x, y = np.array([*line[4:], 1.0]) @ np.reshape(now, (3, 2))
            found.append((float(x), float(y)))

    page.extract_text(visitor_text=see)
    return found


def test_it_is_tagged_named_and_carries_its_fonts(printed):
    _, reader, _ = printed
    root = reader.trailer["/Root"]
    assert root["/MarkInfo"]["/Marked"] and root["/Lang"] == "en"
    assert reader.metadata and reader.metadata.title == "Robust SLAM" and reader.metadata.author
    fonts = (page["/Resources"].get("/Font", {}).values() for page in reader.pages)
    for font in (font.get_object() for of_page in fonts for font in of_page):
        for each in (each.get_object() for each in font.get("/DescendantFonts", [font])):
            described = each.get("/FontDescriptor", {})
            embedded = {"/FontFile", "/FontFile2", "/FontFile3"} & set(described)
            assert embedded or font["/Subtype"] == "/Type3", font["/BaseFont"]


def test_each_link_leads_within_the_document_or_to_the_web(printed):
    _, reader, target = printed
    known = places(target)
    notes = [note.get_object() for page in reader.pages for note in page.get("/Annots", [])]
    leads = [note for note in notes if note["/Subtype"] == "/Link"]
    inside = [note["/Dest"] for note in leads if "/Dest" in note]
    assert len(inside) > 20 and {str(name).removeprefix("/") for name in inside} <= set(known)
    outside = [str(note["/A"]["/URI"]) for note in leads if "/A" in note]
    assert all(uri.startswith(("https:", "http:", "mailto:")) for uri in outside)


def test_no_figure_formula_picture_or_reference_of_the_site_is_lost(site, open_page):
    """All pages of the site are joined into one document and counted in the browser."""
    joined = book(site.folder)
    assert sorted(joined.pages) == sorted(PAGES)
    document = joined.html({})
    ids = ID.findall(document)
    assert len(set(ids)) == len(ids)
    assert set(LEAD.findall(document)) - set(ids) == set()
    browser = open_page("about:blank").page
    pages = [(site.folder / f"{page}.html").read_text(encoding="utf-8") for page in PAGES]
    contents = document.partition('class="lines"')[2].partition("</nav>")[0]
    assert "Gauge freedom" in contents and "Quiz" not in contents
    on_site = np.sum([counted(browser, page, "article") for page in pages], axis=0)
    assert counted(browser, document, "section.page") == on_site.tolist()
    assert on_site.min() > 10, dict(zip(KINDS, on_site, strict=True))


@pytest.mark.soak
@pytest.mark.parametrize("paper", ["A4", "Letter"])
def test_the_whole_book_has_at_most_250_pages_and_no_heading_alone_at_a_foot(
    paper, site, open_page, tmp_path
):
    source = tmp_path / "book.html"
    source.write_text(book(site.folder).html({}), encoding="utf-8")
    page = open_page(source.as_uri()).page
    page.set_default_timeout(600_000)
    printed = PdfReader(io.BytesIO(page.pdf(format=paper, tagged=True, outline=True)))
    assert 200 < len(printed.pages) <= 250
    assert len(flat(printed.outline)) > 200 and lone(printed) == []


def test_answers_to_questions_and_exercises_stand_at_the_end_of_their_chapter(printed):
    chapter = printed[0].articles[FEW[0]]
    (last,) = chapter.select(".rs-answers")
    assert not last.find_next_siblings() and last.h2.get_text() == "Answers"
    told = " ".join(last.get_text().split())
    assert "how many of the 99 odometry edges are still bent? ✓ Right: 33." in told
    assert len(last.select("details")) == len(chapter.select("details.sd-dropdown")) > 3
    letters = dict(
        re.findall(r"(\d) (\w(?: and \w)*)", last.find(string="Quiz: ").find_parent("p").text)
    )
    questions = chapter.select(".rs-quiz fieldset")
    assert len(letters) == len(questions) > 1
    for number, question in enumerate(questions, 1):
        verdicts = [option.strong.get_text() for option in question.select(".rs-option")]
        right = [name for name, said in zip("ABCDEF", verdicts, strict=False) if "Right" in said]
        assert letters[str(number)] == " and ".join(right)
