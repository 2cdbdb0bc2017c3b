"""The instructor's pages: only read, read by all, on every screen and on paper."""

from __future__ import annotations

import itertools
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from robust_slam_autograder.grading.results import Result, without_grade
from robust_slam_autograder.markup import visible
from robust_slam_autograder.reports import class_pages, class_report
from robust_slam_autograder.reports.class_pages import Entry
from robust_slam_autograder.reports.class_report import Report, Source

from tests.autograder.reports import samples
from tests.autograder.reports.samples import case, exercise, result
from tests.autograder.reports.test_feedback import LOW_CONTRAST, Skeleton
from tests.autograder.test_markup import ANY_TEXT, TEXTS
from tests.book.test_accessible import violations
from tests.chromium import Opener, Visit

LONG = "A sentence that is long enough to go over the end of a line on every phone, number "


def report(*results: Result, **fields: Any) -> Report:
    known = frozenset(each.student for each in results)
    return class_report.report(
        Source("07-toy", "Twice & again", results, students=known, **fields)
    )


def student(n: int) -> Result:
    """One of many, each with another mark and another message."""
    cases = [
        case(f"case-{k}", f"{LONG}{n % 7}." if k > n % 9 else "", visible=k < 2) for k in range(8)
    ]
    status = ("partial", "timeout", "died")[n % 3] if n % 9 < 7 else "passed"
    first = exercise("solve_largest_consistent_set", status, *cases)  # type: ignore[arg-type]
    broken = exercise("broken", "failed", case("first", "Your function raised E: x."))
    return result(first, broken, samples.PASSED, student=f"student {n}", seconds=n * 7.7)


MANY = (
    *(student(n) for n in range(40)),
    result(samples.PASSED, student="early"),
    samples.refused("07-toy.ipynb is not valid JSON: save it again.", student="ben"),
    without_grade("failed", "It died.", student="zoe", assignment="07-toy", max_score=20),
)
LOOK_AT = sum(kind.students for kind in report(*MANY).attention)
LINKS = {each.student: "../feedback/x/07-toy.html" for each in MANY}


def hostile(text: str, name: str | None = None) -> Report:
    """A class whose students wrote this wherever they may."""
    name = text if name is None else name
    said = samples.told(text)
    others = (samples.refused(text, student=f"b{name}"), replace(said, student=f"a{name}"))
    return report(*others, links={f"b{name}": "b.html"})


PAGES = {
    "many": class_pages.html(report(*MANY, links=LINKS)),
    "no-names": class_pages.html(report(*MANY, names=False)),
    "one": class_pages.html(report(result(samples.PASSED))),
    "nothing": class_pages.html(report(samples.refused("No."))),
    "no-points": class_pages.html(report(result())),
    "hostile": class_pages.html(hostile("\n".join(samples.HOSTILE.values()))),
    "index": class_pages.index(
        [
            Entry(report(*MANY), "many.html"),
            Entry(report(result(samples.PASSED)), "one.html"),
            Entry(report(samples.refused("No.")), ""),
            Entry(report(result()), "no-points.html"),
        ],
        names=True,
    ),
}


@pytest.mark.parametrize(
    ("share", "said"),
    [
        (None, "–"),
        (0, "0 %"),
        (0.001, "<1 %"),
        (0.5, "50 %"),
        (0.999, ">99 %"),
        (1, "100 %"),
    ],
)
def test_nothing_and_everything_are_said_of_these_alone(share: float | None, said: str) -> None:
    assert class_pages.percent(share) == said


@pytest.mark.parametrize(
    ("seconds", "said"),
    [
        (0.04, "0.0 s"),
        (9.94, "9.9 s"),
        (9.96, "10 s"),
        (59.6, "1 min 00 s"),
        (125, "2 min 05 s"),
        (3599.7, "1 h 00 min"),
    ],
)
def test_durations_are_for_people(seconds: float, said: str) -> None:
    assert class_pages.duration(seconds) == said


def said_by(name: str) -> str:
    """The page's words, with a space between cells."""
    page = PAGES[name].replace("<wbr>", "").replace("<", " <")
    return " ".join(Skeleton(page).text.split()).replace(" ,", ",").replace(" ;", ";")


def test_a_page_says_that_it_is_the_instructors() -> None:
    for name in PAGES:
        assert "For the instructor. " in said_by(name)
        assert "do not publish it" in said_by(name)


def test_every_number_of_a_picture_stands_in_a_table() -> None:
    text = said_by("many")
    marks = report(*MANY).marks
    assert marks is not None
    for found in marks.bins:
        assert f"{found.label} {found.students}" in text
    apply = next(e for e in report(*MANY).exercises if e.name.startswith("solve"))
    numbers = (apply.whole, apply.partly, apply.none, apply.missing)
    row = " ".join([apply.name, class_pages.percent(apply.share), *map(str, numbers)])
    assert row in text
    assert f"case-1 visible 5 {apply.cases[1].passed}" in text
    assert f"case-7 hidden 5 {apply.cases[7].passed}" in text


def test_other_versions_are_told_at_the_top_and_on_the_index() -> None:
    text = said_by("many")
    assert "the version that graded most, 40 of 41 submissions" in text
    assert "1 submission: 10 points in all in place of 55; without the exercises" in text
    assert "more than one version of the tests" in said_by("index")
    assert "version" not in said_by("one")


def test_what_goes_wrong_with_a_test_is_seen_before_its_cases_are_opened() -> None:
    assert "1 case of broken · 1: nobody passes: is the test right?" in said_by("many")


def test_the_index_names_what_is_hardest_and_links_to_pages_that_there_are() -> None:
    assert "hardest: broken, 0 % of its points" in said_by("index")
    assert said_by("index").count("hardest") == 1
    links = [dict(attrs)["href"] for tag, attrs in Skeleton(PAGES["index"]).tags if tag == "a"]
    assert links == ["many.html", "one.html", "no-points.html"]


def test_texts_that_few_got_are_folded_and_the_rest_counted() -> None:
    texts = [exercise("e", "failed", case("c", f"Text {n:03}.")) for n in range(40)]
    made = report(*(result(one, student=f"s{n}") for n, one in enumerate(texts)))
    text = class_pages.html(made)
    assert "37 more" in text and "Text 029." in text and "Text 030." not in text
    assert "And 10 more, which 1 student or fewer got each." in text


def test_without_names_no_name_is_on_the_page() -> None:
    text = PAGES["no-names"]
    names = {each.student for each in MANY} | {"Your function raised E:", 'href="..'}
    assert not [name for name in names if name in text]
    assert "Students are not named" in text and "Refused: 1" in text


class TestInjection:
    @TEXTS
    def test_hostile_text_makes_no_tag(self, text: str) -> None:
        shown = Skeleton(class_pages.html(hostile(text)))
        assert shown.tags == Skeleton(class_pages.html(hostile("harmless"))).tags
        assert shown.text.count(visible(text)) >= 3

    @settings(max_examples=30)
    @given(ANY_TEXT)
    def test_no_text_makes_a_tag(self, text: str) -> None:
        if text:
            shown = Skeleton(class_pages.html(hostile(text)))
            assert shown.tags == Skeleton(class_pages.html(hostile("harmless"))).tags

    def test_a_title_is_text(self) -> None:
        title = "<b>Twice</b>"
        made = replace(report(result(samples.PASSED)), title=title, assignment=title)
        for page in (class_pages.html(made), class_pages.index([Entry(made, "x")], names=True)):
            assert "<b>" not in page and title in Skeleton(page).text


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("report")
    for name, text in PAGES.items():
        (made / f"{name}.html").write_text(text, encoding="utf-8")
    return made


VISITS = [*((name, "light") for name in PAGES), ("many", "dark"), ("index", "dark")]
"""Pages and colour schemes; what the other pages show is in these two."""


@pytest.fixture(params=VISITS, ids="-".join)
def visit(request: pytest.FixtureRequest, folder: Path, open_page: Opener) -> Visit:
    name, scheme = request.param
    return open_page((folder / f"{name}.html").as_uri(), color_scheme=scheme)


OPEN_ALL = "document.querySelectorAll('details').forEach(one => { one.open = true })"
FITS = "document.documentElement.scrollWidth <= innerWidth"
TOO_WIDE = """() => [...document.querySelectorAll("code, td, th, dd, p, summary")]
  .filter(one => getComputedStyle(one).display !== "inline")
  .filter(one => one.scrollWidth > one.clientWidth + 1)
  .map(one => one.textContent)"""


@pytest.mark.browser
class TestPage:
    """The pages in Chromium."""

    def test_it_is_quiet_and_is_read_by_all(self, visit: Visit) -> None:
        page = visit.page
        page.evaluate(OPEN_ALL)
        assert page.evaluate("performance.getEntriesByType('resource').length") == 0
        assert page.evaluate("document.scripts.length + document.images.length") == 0
        assert (visit.complaints, visit.outside) == ([], [])
        assert page.evaluate(LOW_CONTRAST) == []
        for width in (1280, 390):
            page.set_viewport_size({"width": width, "height": 900})
            assert page.evaluate(FITS) and page.evaluate(TOO_WIDE) == []
        assert violations(page) == []

    def test_labels_of_a_histogram_do_not_meet(self, folder: Path, open_page: Opener) -> None:
        page = open_page((folder / "many.html").as_uri()).page
        for width in (1280, 390):
            page.set_viewport_size({"width": width, "height": 900})
            boxes = page.locator("figure text[y='212']").all()
            shown = [box for one in boxes if (box := one.bounding_box()) and box["width"]]
            assert len(shown) >= 6
            for left, right in itertools.pairwise(shown):
                assert left["x"] + left["width"] < right["x"]

    def test_patterns_are_drawn_and_not_colour_alone(
        self, folder: Path, open_page: Opener
    ) -> None:
        page = open_page((folder / "many.html").as_uri()).page
        fill = "kind => getComputedStyle(document.querySelector(`.key .${kind}`)).fill"
        fills = [page.evaluate(fill, kind) for kind in ("whole", "partly", "none", "missing")]
        assert len(set(fills)) == 4
        assert [f for f in fills if "url" in f] == ['url("#some")', 'url("#lost")']
        assert page.locator("pattern#some").count() == page.locator("pattern#lost").count() == 1

    def test_keys_open_what_is_folded(self, folder: Path, open_page: Opener) -> None:
        page = open_page((folder / "many.html").as_uri()).page
        found = []
        for _ in range(3):
            page.keyboard.press("Tab")
            found.append(page.evaluate("document.activeElement.textContent"))
        assert found == ["All assignments", str(LOOK_AT), "The same as a table"]
        assert not page.get_by_role("cell", name="0–4").is_visible()
        page.keyboard.press("Enter")
        assert page.locator("figure + details[open]").count() == 1

    def test_landmarks_headings_and_tables_say_what_they_are(
        self, folder: Path, open_page: Opener
    ) -> None:
        page = open_page((folder / "many.html").as_uri()).page
        assert page.locator("header").count() == page.locator("main").count() == 1
        assert page.locator("h2").all_text_contents() == [
            "Marks",
            "Exercises, hardest first",
            "What students were told",
            "Time of grading",
            "Who needs attention",
        ]
        assert page.locator("th:not([scope])").count() == 0
        ids = page.evaluate("[...document.querySelectorAll('[id]')].map(n => n.id)")
        assert len(ids) == len(set(ids))

    def test_on_paper_all_is_dark_on_white(self, folder: Path, open_page: Opener) -> None:
        page = open_page((folder / "many.html").as_uri(), color_scheme="dark").page
        page.emulate_media(media="print", color_scheme="dark")
        assert page.evaluate("getComputedStyle(document.body).backgroundColor") == (
            "rgb(255, 255, 255)"
        )
        assert page.evaluate(LOW_CONTRAST) == []
        assert page.pdf(format="A4").startswith(b"%PDF")
