"""The browser remembers what was read and done, saves it as a file, and forgets it when asked."""

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Locator, Page, expect

from autograder.tests.kernel import leave_out
from tests.book.conftest import ROOT, place
from tests.book.test_quizzes import KEPT, REFUSED
from tests.chromium import Visit, page_in, visiting

pytestmark = [pytest.mark.browser, pytest.mark.rest]

ASSETS = ROOT / "chapters" / "assets"
SCRIPT = "".join((ASSETS / f"{name}.js").read_text("utf-8") for name in ("element", "progress"))
LAB = "../lab/lab/index.html?path={0}.ipynb"
ROW = f"""<tr><td><a href="../assignments/{{0}}.zip"><code>{{0}}.zip</code></a>
(<a href="{LAB}">open in the browser</a>)</td></tr>"""
TABLE = f"""<a href="../other/00-one.zip">other</a> <a href="../lab/index.html">none</a>
<table>{ROW.format("00-one")}{ROW.format("01-two")}</table>"""
ZIP = "00-one.zip"
TO_ASSIGNMENTS = ":is(article a:text('.zip'), article a:text-is('open in the browser'))"
"""A tick that comes changes the text of neither kind."""


@contextmanager
def students(browser: Browser, folder: Path, before: str = "") -> Iterator[Visit]:
    """A page with the links of two assignments; nothing stands behind them."""
    with visiting(browser, "about:blank") as visit:
        visit.page.add_init_script(before)
        visit.page.route("**/*.zip", lambda route: route.fulfill(status=204))
        visit.page.route("**/lab/**", lambda route: route.fulfill(status=204))
        visit.page.goto(written(folder, "students", TABLE))
        yield visit


def ticks(page: Page) -> int:
    """How many links in the text carry a tick."""
    return page.locator("article a .rs-done").count()


def errors(visit: Visit) -> list[str]:
    """What went wrong, but for the links, behind which there is nothing."""
    return [said for said in visit.complaints if not said.startswith("failed: ")]


def test_a_link_that_was_followed_has_a_tick_until_it_is_forgotten(browser, tmp_path):
    with students(browser, tmp_path) as visit:
        page = visit.page
        page.get_by_role("link", name="other").click()
        page.get_by_role("link", name="none").click()
        assert ticks(page) == 0
        page.get_by_role("link", name=ZIP).first.click()
        expect(page.get_by_role("img", name="downloaded")).to_have_count(1)
        page.get_by_role("link", name="open in the browser").nth(1).press("Enter")
        expect(page.get_by_role("img", name="opened")).to_have_count(1)
        page.wait_for_timeout(500)  # what a page writes just before it is left may be lost
        page.reload()
        expect(page.get_by_role("link", name=f"{ZIP} downloaded", exact=True)).to_have_count(1)
        opened = page.get_by_role("link", name="open in the browser opened", exact=True)
        expect(opened).to_have_attribute("href", LAB.format("01-two"))
        assert ticks(page) == 2

        page.get_by_role("button", name="Forget my progress").click()
        assert (ticks(page), page.evaluate(KEPT)) == (0, None)
        expect(page.locator(".rs-forget [role=status]")).to_contain_text("forgotten")
        assert errors(visit) == visit.outside == []


def test_a_middle_click_opens_and_a_right_one_does_not(browser, tmp_path):
    with students(browser, tmp_path) as visit:
        link = visit.page.get_by_role("link", name="open in the browser").first
        link.click(button="right")
        assert ticks(visit.page) == 0
        link.click(button="middle")
        expect(visit.page.get_by_role("img", name="opened")).to_have_count(1)


@pytest.mark.parametrize("kept", ["{", "null", "7", '{"assignments": 3}', '{"quizzes": null}'])
def test_what_else_is_kept_under_the_name_stops_nothing(kept, browser, tmp_path):
    before = f"{KEPT} ?? localStorage.setItem('robust-slam-progress', {kept!r})"
    with students(browser, tmp_path, before) as visit:
        visit.page.get_by_role("link", name=ZIP).click()
        expect(visit.page.get_by_role("img", name="downloaded")).to_have_count(1)
        assert errors(visit) == []


def test_where_nothing_can_be_kept_links_are_as_they_were(browser, tmp_path):
    with students(browser, tmp_path, REFUSED) as visit:
        visit.page.get_by_role("link", name=ZIP).click()
        assert ticks(visit.page) == 0 and errors(visit) == []
        assert visit.page.locator(".rs-forget").count() == 0


SIDEBAR = """<nav class="bd-links"><a href="03-irls.html">3 · IRLS</a>
<a href="04-more.html">4 · More</a></nav>"""
LONG = """<section id="first" style="height: 3000px"><h2>First</h2></section>
<section id="second" style="height: 3000px"><h2>Second</h2></section>"""
PLACE = '<div class="rs-progress" hidden></div><div class="rs-doors"><p>Learn</p></div>'
QUIZ = {"choices": {"a": "B"}, "done": False}


def written(folder: Path, name: str, body: str) -> str:
    """Write a page of the chapters, with the sidebar, and give its address."""
    path = folder / "chapters" / f"{name}.html"
    path.parent.mkdir(exist_ok=True)
    head = f'<!doctype html><title>t</title><link rel="icon" href="data:,">{SIDEBAR}'
    script = f'const DOCUMENTATION_OPTIONS = {{pagename: "chapters/{name}"}};\n{SCRIPT}'
    text = f"{head}<article>{body}</article><script>{script}</script>"
    path.write_text(text, encoding="utf-8")
    return path.as_uri()


def test_a_chapter_is_read_at_its_end_and_the_last_place_is_kept(browser, tmp_path):
    chapter, place = written(tmp_path, "03-irls", LONG), written(tmp_path, "progress", PLACE)
    with visiting(browser, place) as visit:
        # In a tab of its own: what a page writes right before it is left may be lost.
        page, chapter_tab = visit.page, visit.page.context.new_page()
        chapter_tab.goto(chapter)
        chapter_tab.evaluate("scrollTo(0, 3200)")  # a wheel before the first frame is lost
        reload_until(page.locator(".rs-progress p a[href$='chapters/03-irls.html#second']"))
        row = page.get_by_role("row", name="3 · IRLS")
        assert row.get_by_role("cell").all_inner_texts() == ["3 · IRLS", "", "", ""]
        assert page.locator(".rs-doors").inner_text() == "Go on with 3 · IRLS"
        chapter_tab.keyboard.press("End")
        reload_until(row.get_by_role("cell", name="read", exact=True))
        assert page.locator(".bd-links a [title=read]").count() == 1
        assert visit.complaints == visit.outside == []


def reload_until(shown: Locator) -> None:
    """Reload a page until it shows what another tab has kept, which may come late."""
    for _ in range(100):
        shown.page.reload()
        if shown.count():
            return
        shown.page.wait_for_timeout(100)
    raise AssertionError(f"{shown} never came")


def test_what_is_kept_goes_to_another_browser_as_a_file(browser, tmp_path):
    place, saved = written(tmp_path, "progress", PLACE), tmp_path / "saved.json"
    kept = {
        "quizzes": {"chapters/03-irls": QUIZ},
        "assignments": {"03-irls": {"checked": True}},
        "read": {"chapters/04-more": True},
        "last": {"page": "chapters/04-more", "id": "x"},
    }
    with visiting(browser, "about:blank") as visit:
        # Not by the page before it is left: what it writes then may be lost.
        keep = f"localStorage.setItem('robust-slam-progress', '{json.dumps(kept)}')"
        visit.page.add_init_script(keep)
        visit.page.goto(place)
        with visit.page.expect_download() as waiting:
            visit.page.get_by_role("button", name="Save as a file").click()
        waiting.value.save_as(saved)
    assert json.loads(saved.read_text(encoding="utf-8")) == kept
    with visiting(browser, place) as visit:
        page = visit.page
        other = '{"quizzes": {"chapters/04-more": {"choices": {}, "done": true}}}'
        page.evaluate(f"localStorage.setItem('robust-slam-progress', '{other}')")
        broken = tmp_path / "broken.json"
        for text in ("{", "[]", "null", '{"quizzes": 1}'):
            broken.write_text(text, encoding="utf-8")
            page.locator("input[type=file]").set_input_files(broken)
            status = page.locator(".rs-progress [role=status]")
            expect(status).to_contain_text("broken.json is no file of progress")
            assert page.evaluate(KEPT) == other
        page.locator("input[type=file]").set_input_files(saved)
        expect(status).to_have_text("saved.json is loaded.")
        below = page.get_by_role("row").all()[1:]
        rows = [row.get_by_role("cell").all_inner_texts() for row in below]
        first = ["3 · IRLS", "", "1 answered", "checked"]
        assert rows == [first, ["4 · More", "read", "all right", ""]]


@pytest.mark.parametrize("name", ["students", "03-irls"])
def test_every_link_to_an_assignment_is_known(name, site, address, browser):
    with page_in(browser) as page:
        page.goto(place(site, address, f"chapters/{name}", "http"))
        links = page.locator(TO_ASSIGNMENTS)
        if not links.count():
            leave_out("no assignment's zip is there (make release); no page links to one")
        page.evaluate("addEventListener('click', (event) => event.preventDefault())")
        for link in links.all():
            link.evaluate("link => link.click()")
        assert ticks(page) == links.count()
        assert page.locator(".rs-forget").count() == 1
