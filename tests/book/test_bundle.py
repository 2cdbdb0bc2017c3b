"""A page is light: one style sheet, one script, and no icons but those that it shows."""

from __future__ import annotations

import gzip
import re
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from playwright.sync_api import Browser

from chapters._ext import robust_slam_bundle, robust_slam_rules
from tests.book.conftest import CHAPTERS, PAGES, Site

REQUESTS = 12
KILOBYTES = 350
"""What a page may ask for before anything is clicked, compressed as servers do."""
PACKED = {".png", ".woff2"}


def weight(path: Path) -> int:
    """The bytes of a file as a server sends them."""
    data = path.read_bytes()
    return len(data) if path.suffix in PACKED else len(gzip.compress(data, 6))


@pytest.fixture(scope="module", params=["index", *CHAPTERS])
def asked(request: pytest.FixtureRequest, address: str, browser: Browser) -> Iterator[list[str]]:
    """The addresses that a page asks for until it is loaded."""
    page = browser.new_page(viewport={"width": 1280, "height": 800})
    asked: list[str] = []
    page.on("request", lambda sent: asked.append(sent.url))
    page.goto(f"{address}/{request.param}.html", wait_until="networkidle")
    yield [url for url in asked if url.startswith("http")]
    page.close()


@pytest.mark.browser
def test_a_page_asks_for_little(asked: list[str], site: Site) -> None:
    assert len(asked) <= REQUESTS
    paths = [site.folder / urlsplit(url).path.lstrip("/") for url in asked]
    assert sum(map(weight, paths)) < KILOBYTES * 1000


@pytest.mark.parametrize("name", [*PAGES, "search", "genindex"])
def test_a_page_links_the_joined_files_and_draws_its_icons(name: str, site: Site) -> None:
    html = (site.folder / f"{name}.html").read_text(encoding="utf-8")
    linked = re.findall(r'(?:href|src)="[^"]*_static/([^"?]+\.(?:css|js))', html)
    assert sorted(set(linked) - {"search.js"}) == ["bundle.css", "bundle.js"]
    assert not re.search(r'<(i|span) [^>]*class="[^"]*\bfa-', html)
    assert html.count('<svg class="svg-inline--fa') >= 5


def test_the_style_has_the_rules_for_icons_that_the_build_draws(site: Site) -> None:
    style = (site.folder / "_static" / "bundle.css").read_text(encoding="utf-8")
    assert ".svg-inline--fa{" in style
    assert ".fa-spin" not in style


def test_addresses_in_a_style_sheet_are_seen_from_the_joined_one(tmp_path: Path) -> None:
    (tmp_path / "styles").mkdir()
    (tmp_path / "basic.css").write_text("a { background: url(file.png) }")
    (tmp_path / "styles" / "theme.css").write_text(
        '@import "../basic.css";\nb { background: url("../a.svg"), url(data:x,y) }'
    )
    sheet = robust_slam_bundle.sheet(tmp_path, "styles/theme.css")
    assert "url(file.png)" in sheet and "url(a.svg)" in sheet and "url(data:x,y)" in sheet


def test_an_icon_keeps_its_classes_and_its_data() -> None:
    page = '<i class="theme-switch fa-solid fa-sun fa-lg" data-mode="light" title="Light"></i>'
    icons = {"sun": ("512", "512", "M0 0")}
    drawn = robust_slam_bundle.lighter(page, "", icons)
    assert drawn == (
        '<svg class="svg-inline--fa theme-switch fa-sun fa-lg" aria-hidden="true"'
        ' data-mode="light" viewBox="0 0 512 512"><path fill="currentColor" d="M0 0"></path></svg>'
    )


@pytest.mark.parametrize(
    ("rule", "kept"),
    [
        ("a{color:red}", "a{color:red}"),
        (".here .gone{color:red}", ""),
        (".gone,.here:hover{color:red}", ".here:hover{color:red}"),
        ("p:not(.gone){color:red}", "p:not(.gone){color:red}"),
        ("div:is(.gone,.here){color:red}", "div:is(.gone,.here){color:red}"),
        ('a[href=".gone"]{color:red}', 'a[href=".gone"]{color:red}'),
        (".bs-tooltip-top{color:red}", ".bs-tooltip-top{color:red}"),
        ("@media print{.gone{color:red}}", ""),
        ("@media print{.here{color:red}}", "@media print{.here{color:red}}"),
        ("@font-face{font-family:x}", "@font-face{font-family:x}"),
    ],
)
def test_rules_for_classes_that_no_page_has_are_left_out(rule: str, kept: str) -> None:
    known = robust_slam_rules.words(['<p class="here">'])
    assert robust_slam_rules.used_rules(rule, known) == kept
