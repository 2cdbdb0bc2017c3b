"""The benchmark of a site: what its server gives, what it sees on a page, what it prints."""

from __future__ import annotations

import gzip
import urllib.request
from collections import Counter
from pathlib import Path

import pytest
from playwright.sync_api import Browser

from benchmarks.site import __main__ as site
from benchmarks.site import page, tables
from benchmarks.site.server import LEVEL, Given, serving

SVG = "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 100 50'></svg>"
SHIFT = "setTimeout(() => { document.getElementById('late').style.height = '300px'; }, 200);"
PAGE = f"""<!doctype html><html lang="en"><head><title>t</title>
<link rel="icon" href="data:,"></head><body>
<main><article><h1>One title</h1><div id="late"></div><p>Four words stand here.</p>
<img src="a.svg" width="200" height="600">
</article></main><script>{SHIFT}</script></body></html>"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A site of one page and a picture."""
    (tmp_path / "chapters").mkdir()
    (tmp_path / "chapters" / "00-one.html").write_text(PAGE)
    (tmp_path / "chapters" / "a.svg").write_text(SVG)
    (tmp_path / "search.html").write_text(
        "<link rel=icon href='data:,'><input type=search oninput=\"fetch('a' + value)\">"
    )
    (tmp_path / "ah").write_bytes(b"x" * 500)
    return tmp_path


def test_text_is_given_gzipped_and_other_files_whole(folder: Path) -> None:
    with serving(folder) as served:
        for name in ("chapters/00-one.html", "ah"):
            urllib.request.urlopen(f"{served.address}/{name}").read()
        small = len(gzip.compress(PAGE.encode(), LEVEL))
        assert served.take() == [Given("/chapters/00-one.html", small), Given("/ah", 500)]
        assert served.take() == []


@pytest.mark.browser
def test_a_page_is_measured(folder: Path, browser: Browser) -> None:
    one = site.measured(browser, folder, "")
    (found,) = one.pages
    assert found.weight == sum(each.size for each in found.given)
    assert [each.path for each in found.given] == ["/chapters/00-one.html", "/chapters/a.svg"]
    assert found.tasks >= found.scripts > 0 < found.paint and found.in_first_response
    assert min(found.shifts) > 0.02
    assert [each["image-alt"] for each in found.violations] == [1, 1]
    # Each letter that is typed makes a request; after the first the file is there.
    assert [each for each in one.query if each.size] == [Given("/ah", 500)]
    assert tables.of_pages(one).splitlines()[2].startswith("| 00-one | ")


def test_a_page_that_is_not_there_is_refused(folder: Path, browser: Browser) -> None:
    with pytest.raises(FileNotFoundError, match=r"no page chapters/\*07\*\.html"):
        site.measured(browser, folder, "07")


def test_the_front_page_comes_first(tmp_path: Path) -> None:
    (tmp_path / "chapters").mkdir()
    for name in ("09-last", "index", "api"):
        (tmp_path / "chapters" / f"{name}.html").touch()
    assert site.names(tmp_path, "") == ["chapters/index", "chapters/09-last", "chapters/api"]
    assert site.names(tmp_path, "09") == ["chapters/09-last"]


def figures(name: str, size: int, rule: str) -> page.Figures:
    """A page that weighs this much and breaks a rule in the dark."""
    given = [Given(f"/{name}.html", size), Given("/a.js", 3 * size)]
    broken = Counter[str](), Counter({rule: 2})
    return page.Figures(name, given, 0.5, 0.2, 0.1, True, (0.0, 0.1), broken)


def test_the_summary_has_a_column_for_each_site() -> None:
    pages = [figures(f"chapters/0{k}-x", 1_000 * k, "region") for k in (1, 2, 3)]
    sites = [tables.Site(name, pages, [Given("/q", 2_500)]) for name in ("a", "b")]
    lines = dict(line[2:-2].split(" | ", 1) for line in tables.summary(sites).splitlines()[2:])
    assert lines["chapter, KB gzipped"] == "8 (4 to 12) | 8 (4 to 12)"
    assert lines["front page, requests"] == "– | –"
    assert lines["largest files of a chapter, KB"].startswith("a.js 6, the page 2")
    assert lines["axe, light"] == "none | none"
    assert lines["axe, dark"].startswith("region 6 on 3 pages")


@pytest.mark.parametrize(
    ("html", "text", "there"),
    [
        ("<p>Two <b>words</b>\n here</p>", "Two words here", True),
        ("<p>a &amp; b</p>", "a & b", True),
        ("<p></p><script src=x></script>", "drawn later", False),
    ],
)
def test_a_text_is_found_whatever_the_marks_between(html: str, text: str, there: bool) -> None:
    assert page.holds(html, text) == there
