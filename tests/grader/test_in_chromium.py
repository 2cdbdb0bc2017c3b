"""The pages in Chromium: only read, read by all, on every screen and on paper."""

import itertools

import pytest
from playwright.sync_api import expect
from robust_slam_autograder import layout

from autograder.tests.reports import pages
from tests.book.test_accessible import COLOURS, violations

pytestmark = [pytest.mark.browser, pytest.mark.rest]

OF_STUDENTS = ("every-status", "passed", "refused", "hostile")
OF_CLASSES = (
    *("many", "by-people", "no-names", "one", "nothing", "no-points", "class-hostile"),
    *("index", "student"),
)
DARK = (*OF_STUDENTS, "many", "by-people", "index", "student")
"""Looked at in the dark too; what the instructor's other pages show is in these."""
OPEN_ALL = "document.querySelectorAll('details').forEach(one => { one.open = true })"
WIDTH = "document.documentElement.scrollWidth"
TOO_WIDE = """() => [...document.querySelectorAll("code, td, th, dd, p, summary")]
  .filter(one => getComputedStyle(one).display !== "inline")
  .filter(one => one.scrollWidth > one.clientWidth + 1)
  .map(one => one.textContent)"""
FOCUSED = "document.activeElement.textContent"
IDS = "[...document.querySelectorAll('[id]')].map(one => one.id)"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("pages")
    for name, text in (pages.of_students() | pages.of_classes()).items():
        (made / f"{name}.html").write_text(text, encoding="utf-8")
    return made


@pytest.fixture
def opened(folder, open_page):
    def visit(name, scheme="light"):
        return open_page((folder / f"{name}.html").as_uri(), color_scheme=scheme)

    return visit


@pytest.mark.parametrize("name", [*OF_STUDENTS, *OF_CLASSES])
def test_a_page_asks_for_nothing_fits_and_is_read_by_all(opened, name):
    visit = opened(name)
    page = visit.page
    page.evaluate(OPEN_ALL)
    assert (visit.complaints, visit.outside) == ([], [])
    assert page.evaluate("performance.getEntriesByType('resource').length") == 0
    assert page.evaluate("document.scripts.length") == 0
    assert page.locator("img:not([src^='data:'])").count() == 0
    assert page.locator("header").count() == page.locator("main").count() == 1
    # Else Chromium rounds the space between words, and they run together.
    assert page.evaluate("getComputedStyle(document.body).textRendering") == "geometricprecision"
    assert page.locator("th:not([scope])").count() == 0
    ids = page.evaluate(IDS)
    assert len(ids) == len(set(ids))
    for width in (1280, 390):
        page.set_viewport_size({"width": width, "height": 900})
        assert page.evaluate(WIDTH) <= width
        if name in OF_CLASSES:
            assert page.evaluate(TOO_WIDE) == []
    assert violations(page) == []
    if name in DARK:
        page.emulate_media(color_scheme="dark")
        assert violations(page, COLOURS) == []


def test_partial_has_a_sign_and_a_colour_of_its_own_and_keys_lead_to_where_to_start(opened):
    page = opened("every-status").page
    read = "one => [one.textContent[0], getComputedStyle(one).color].join()"
    kinds = ("passed", "partial", "lost")
    looks = [page.locator(f"td.{kind}").first.evaluate(read) for kind in kinds]
    assert len(set(looks)) == 3 and [look[0] for look in looks] == ["✓", "◐", "✗"]
    page.keyboard.press("Tab")
    assert page.evaluate(FOCUSED) == "apply"
    page.keyboard.press("Enter")
    page.wait_for_url("**#exercise-2")
    assert page.locator("#exercise-2").text_content() == "apply"


def test_a_page_carries_the_fonts_and_the_sign_that_are_there(tmp_path, monkeypatch, opened):
    face = '@font-face {\n  font-family: "%s";\n  src: url(data:font/woff2;base64,AA);\n}\n'
    (tmp_path / "fonts.css").write_text(face % "Course Sans" + face % "STIX Two Math")
    (tmp_path / "sign.svg").write_text('<svg xmlns="http://www.w3.org/2000/svg"/>')
    monkeypatch.setattr(layout, "FONTS", tmp_path / "fonts.css")
    monkeypatch.setattr(layout, "LOGO", tmp_path / "sign.svg")
    (tmp_path / "page.html").write_text(pages.of_students()["passed"], encoding="utf-8")
    page = opened(tmp_path / "page").page
    assert page.evaluate("[...document.fonts].map(face => face.family)") == ["Course Sans"]
    assert page.locator("header img.logo").evaluate("one => one.complete")
    sign, title = (page.locator(one).bounding_box() for one in ("img.logo", "h1"))
    assert title["x"] >= sign["x"] + sign["width"]  # in all its lines


def test_a_page_that_would_not_do_is_found(folder, opened):
    """The policy stops what autoescape would have let through, and grey on white is seen."""
    text = (folder / "told.html").read_text(encoding="utf-8")
    bad = text.replace("A MESSAGE", "<script>document.title = 'taken'</script>")
    bad = bad.replace("</header>", "<p><font color=#999>grey</font></p></header>")
    (folder / "bad.html").write_text(bad, encoding="utf-8")
    visit = opened("bad")
    assert visit.page.title() != "taken"
    assert any("Content Security Policy" in said for said in visit.complaints)
    assert [one["id"] for one in violations(visit.page)] == ["color-contrast"]


@pytest.mark.parametrize("name", ["every-status", "many"])
def test_on_paper_all_is_dark_on_white(opened, name):
    page = opened(name, "dark").page
    page.emulate_media(media="print", color_scheme="dark")
    colour = "getComputedStyle(document.body).backgroundColor"
    assert page.evaluate(colour) == "rgb(255, 255, 255)"
    assert violations(page, "runOnly: ['color-contrast']") == []
    assert page.pdf(format="A4").startswith(b"%PDF")


class TestManyStudents:
    @pytest.fixture
    def many(self, opened):
        return opened("many").page

    def test_keys_open_what_is_folded(self, many):
        found = []
        for _ in range(3):
            many.keyboard.press("Tab")
            found.append(many.evaluate(FOCUSED))
        attention = sum(kind.students for kind in pages.report(*pages.MANY).attention)
        assert found == ["All assignments", str(attention), "The marks as a table"]
        assert not many.get_by_role("cell", name="0–4").is_visible()
        many.keyboard.press("Enter")
        assert many.locator("figure + details[open]").count() == 1

    def test_labels_of_a_histogram_do_not_meet_and_patterns_are_drawn(self, many):
        for width in (1280, 390):
            many.set_viewport_size({"width": width, "height": 900})
            boxes = many.locator("figure text[y='212']").all()
            shown = [box for one in boxes if (box := one.bounding_box()) and box["width"]]
            assert len(shown) >= 6
            for left, right in itertools.pairwise(shown):
                assert left["x"] + left["width"] < right["x"]
        fill = "kind => getComputedStyle(document.querySelector(`.key .${kind}`)).fill"
        fills = [many.evaluate(fill, kind) for kind in ("whole", "partly", "none", "missing")]
        assert len(set(fills)) == 4
        assert [f for f in fills if "url" in f] == ['url("#some")', 'url("#lost")']
        assert many.locator("pattern#some").count() == many.locator("pattern#lost").count() == 1


class TestHeatMap:
    @pytest.fixture
    def index(self, opened):
        return opened("index").page

    def test_on_a_phone_it_scrolls_in_its_own_box_by_keys(self, index):
        index.set_viewport_size({"width": 390, "height": 900})
        box = index.locator(".scroll")
        assert box.evaluate("box => box.scrollWidth > box.clientWidth")
        assert index.evaluate(WIDTH) <= 390
        box.focus()
        index.keyboard.press("ArrowRight")
        expect(box).not_to_have_js_property("scrollLeft", 0)
        name = index.locator(".heat tbody th").first.bounding_box()
        assert name["x"] == pytest.approx(box.bounding_box()["x"], abs=1), "names stay in sight"

    def test_each_level_has_a_colour_of_its_own_and_a_number_or_sign(self, index):
        read = "all => all.map(one => [one.className.split(' ')[0], getComputedStyle(one)\
.backgroundColor, one.textContent])"
        squares = index.locator(".heat tbody td[class]").evaluate_all(read)
        colours = {(level, colour) for level, colour, _ in squares}
        assert {level for level, _ in colours} == {"all", "most", "some", "zero", "unmarked"}
        assert len(colours) == len({colour for _, colour in colours}) == 5
        assert all(text.isdigit() or text in "–✗" for _, _, text in squares)
