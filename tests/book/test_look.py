"""A page asks for little, is drawn in the course's own letters, and nothing moves."""

import base64
import gzip
import io
import json
import re
from collections.abc import Callable
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from fontTools.ttLib import TTFont
from playwright.sync_api import Browser, Page

from chapters._ext import look
from tests.book.conftest import CHAPTERS, PAGES, place
from tests.book.taking_hold import pictures, take_hold
from tests.chromium import visiting
from tools import fonts

REQUESTS = 15
KILOBYTES = 400
"""What a page may ask for before anything is clicked, compressed as servers do."""
FIRST_SCREENS = ("index", *CHAPTERS, "chapters/labs", "chapters/many-robots")
OTHERS = ("chapters/errata", "chapters/how-large-a-map")
"""In the last one a cell that can be run is near the head of the page."""
PACKED = {".png", ".woff2"}
SHIFT = """() => new Promise((done) => {
  let sum = 0;
  new PerformanceObserver((list) => {
    for (const entry of list.getEntries()) sum += entry.value;
  }).observe({type: "layout-shift", buffered: true});
  setTimeout(() => done(sum), 300);
})"""
FAMILIES = "[...document.fonts].filter(f => f.status === 'loaded').map(f => f.family)"
COLUMNS = """() => [...document.querySelectorAll("article pre")].flatMap((pre) => {
  const lefts = [], crooked = [], range = document.createRange();
  const walk = document.createTreeWalker(pre, NodeFilter.SHOW_TEXT);
  let column = 0;
  while (walk.nextNode()) [...walk.currentNode.data].forEach((sign, k) => {
    if (sign === "\\n") { column = 0; return; }
    range.setStart(walk.currentNode, k);
    range.setEnd(walk.currentNode, k + 1);
    const {left, width} = range.getBoundingClientRect();
    if (width && /[ -~]/.test(sign)) {
      lefts[column] ??= left;
      if (Math.abs(left - lefts[column]) > 1) crooked.push(pre.innerText.slice(0, 40));
    }
    column += 1;
  });
  return crooked.slice(0, 1);
})"""
"""The boxes of code in which a letter stands beside its column."""


def weight(path: Path) -> int:
    """The bytes of a file as a server sends them."""
    data = path.read_bytes()
    return len(data) if path.suffix in PACKED else len(gzip.compress(data, 6))


@pytest.fixture(scope="module", params=[*FIRST_SCREENS, *OTHERS])
def visit(request, address, browser):
    """A page that is open, and the addresses that it asked for until it was loaded."""
    asked: list[str] = []
    with visiting(browser, "about:blank", viewport={"width": 1280, "height": 800}) as visit:
        visit.page.on("request", lambda sent: asked.append(sent.url))
        visit.page.goto(f"{address}/{request.param}.html", wait_until="networkidle")
        yield visit, [url for url in asked if url.startswith("http")], request.param


@pytest.mark.browser
@pytest.mark.rest
class TestVisit:
    def test_it_asks_for_little(self, visit, site):
        asked = visit[1]
        assert len(asked) <= REQUESTS
        paths = [site.folder / urlsplit(url).path.lstrip("/") for url in asked]
        assert sum(map(weight, paths)) < KILOBYTES * 1000

    def test_it_is_drawn_in_the_courses_letters_in_columns_and_keeps_its_shape(self, visit):
        page = visit[0].page
        page.evaluate("document.fonts.ready")
        assert {fonts.SANS, fonts.SERIF} <= {name.strip('"') for name in page.evaluate(FAMILIES)}
        assert page.evaluate(SHIFT) < 0.02
        assert visit[0].complaints == visit[0].outside == []
        assert page.evaluate(COLUMNS) == [], "code, and what it prints"

    def test_title_sentence_and_picture_are_in_the_first_screen(self, visit):
        """The stage begins at most 220 px down the page, and its control and readout follow."""
        for part, lowest in [("stage", 220), ("controls", 800), ("caption", 800)]:
            shown = visit[0].page.locator(f".rs-picture .rs-{part}").first
            edge = "top" if part == "stage" else "bottom"
            if visit[2] in FIRST_SCREENS:
                assert shown.evaluate(f"it => it.getBoundingClientRect().{edge}") <= lowest, part


@pytest.mark.browser
@pytest.mark.parametrize("width", [390, 1280])
@pytest.mark.rest
def test_nothing_moves_when_the_progress_is_shown(width, address, browser):
    view = {"width": width, "height": 1600}
    with visiting(browser, "about:blank", viewport=view) as visit:
        page = visit.page
        # As over a slow connection, where the page is drawn before its script has come.
        page.route("**/course.js", lambda route: (page.wait_for_timeout(300), route.continue_()))
        page.goto(f"{address}/chapters/students.html", wait_until="networkidle")
        assert page.locator(".rs-progress tr").count() > 10
        assert page.evaluate(SHIFT) < 0.02


@pytest.mark.browser
@pytest.mark.parametrize(("style", "crooked"), [("", 0), ("pre {word-spacing: 0.05em}", 1)])
def test_letters_beside_their_column_are_found(style, crooked, browser):
    with visiting(browser, "about:blank") as visit:
        page: Page = visit.page
        page.set_content(f"<style>{style}</style><article><pre>a b c\nlong  d\n</pre></article>")
        assert len(page.evaluate(COLUMNS)) == crooked


@pytest.mark.browser
@pytest.mark.parametrize("name", [CHAPTERS[0], CHAPTERS[8], "chapters/labs"])
@pytest.mark.rest
def test_what_a_picture_draws_does_not_style_the_page_again(name, site, browser):
    """As a rule would for each section that has a certain child."""
    with visiting(browser, "about:blank", viewport={"width": 1280, "height": 800}) as visit:
        page = visit.page
        loading = styled(browser, page, lambda: page.goto(place(site, "", name, "file")))
        elements = page.evaluate("document.querySelectorAll('*').length")
        moving = styled(browser, page, lambda: take_hold(pictures(page)[0], 1))
    assert 0 < loading < 5 * elements
    assert 0 < moving < elements


def styled(browser: Browser, page: Page, act: Callable[[], object]) -> int:
    """How many elements get their style, some of them often, while something is done."""
    browser.start_tracing(categories=["devtools.timeline"])
    act()
    # A font that comes while a picture is moved would style all of the page.
    idle = "new Promise(requestIdleCallback)"
    page.evaluate(f"document.fonts.ready.then(() => {idle}).then(() => 0)")
    events = json.loads(browser.stop_tracing())["traceEvents"]
    found = [each["args"] for each in events if each["name"] == "UpdateLayoutTree"]
    return sum(each.get("elementCount", 0) for each in found)


@pytest.mark.browser
def test_from_the_disk_it_is_drawn_in_the_same_letters(site, browser):
    with visiting(browser, place(site, "", CHAPTERS[3], "file")) as visit:
        visit.page.evaluate("document.fonts.ready")
        loaded = {name.strip('"') for name in visit.page.evaluate(FAMILIES)}
        assert {fonts.SANS, fonts.SERIF, fonts.MATH} <= loaded


def test_a_page_has_a_long_script_once_and_a_short_one_as_often_as_it_stands_there():
    long, short = f"<script>{'x' * 1000}</script>", "<script>y</script>"
    assert look.once(f"{long}a{short}{short}{long}b") == f"{long}a{short}{short}b"


@pytest.mark.parametrize("name", [*PAGES, "search", "genindex"])
def test_a_page_links_the_prepared_files(name, site):
    html = (site.folder / f"{name}.html").read_text(encoding="utf-8")
    linked = set(re.findall(r'(?:href|src)="[^"]*_static/([^"?]+\.(?:css|js))', html))
    assert linked == {look.STYLE, look.SCRIPT, "documentation_options.js"}


def test_the_style_has_the_icons_of_the_pages_alone(site):
    style = (site.folder / "_static" / look.STYLE).read_text(encoding="utf-8")
    assert ".fa-sun:before" in style and ".fa-rocket:before" not in style
    (solid,) = re.findall(r"font-weight:900;src:url\(data:font/woff2;base64,([^)]*)\)", style)
    signs = TTFont(io.BytesIO(base64.b64decode(solid))).getBestCmap()
    assert 0xF185 in signs and len(signs) < 60
    local = set(re.findall(r"url\(['\"]?(?!['\"]|data:|#)([^)'\"]+)", style))
    assert not [path for path in local if not (site.folder / "_static" / path).is_file()]


def test_fonts_are_light_and_have_their_licence_and_not_the_name_that_is_reserved(carried):
    assert len(carried) == len(fonts.FACES)
    assert sum(map(len, carried[:-1])) <= 60_000 and len(carried[-1]) <= 60_000
    for font in carried:
        names = TTFont(io.BytesIO(font))["name"]
        assert "Open Font License" in names.getDebugName(13)
        assert "Source" not in names.getDebugName(1)
