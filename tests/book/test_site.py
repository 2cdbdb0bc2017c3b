"""The built site: no warnings, whole links, nothing from outside, nothing that is secret."""

import re
from html import escape
from html.parser import HTMLParser
from pathlib import Path
from types import SimpleNamespace
from unittest.mock import MagicMock
from urllib.parse import unquote, urlsplit

import pytest
from myst_nb.core import render
from nbformat.v4 import new_output
from robust_slam_autograder.publishing import wheels
from robust_slam_autograder.reading import assignment
from robust_slam_autograder.reports.feedback import anchor

from chapters._ext import notebooks
from tests.book.built_site import ROOT
from tests.book.conftest import BELOW, PAGES, TITLE, Site

VERSION = wheels.version(ROOT, "lib")
# The public course has the release in place of the instructor's sources.
ASSIGNMENTS = ROOT / ("solutions" if (ROOT / "solutions").is_dir() else "assignments")


class Reader(HTMLParser):
    """The addresses that a page loads, the addresses that it links to, and its ids."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.loaded: list[str] = []
        self.linked: list[str] = []
        self.ids: set[str] = set()
        self.feed(html)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        found = {name: value or "" for name, value in attrs}
        self.ids |= {found["id"]} if "id" in found else set()
        if tag in ("script", "img", "iframe", "source") and "src" in found:
            self.loaded.append(found["src"])
        if tag == "link" and found.get("rel") not in ("canonical", "prev", "next"):
            self.loaded.append(found["href"])
        if tag == "a" and "href" in found:
            self.linked.append(found["href"])


@pytest.fixture(scope="module")
def pages(site):
    found = [path for path in site.folder.rglob("*.html") if "_static" not in path.parts]
    return {path: Reader(path.read_text(encoding="utf-8")) for path in sorted(found)}


def inside(address: str) -> bool:
    return not urlsplit(address).scheme and not address.startswith("//")


def test_the_build_succeeds_without_a_warning(site):
    warnings = [line for line in site.log.splitlines() if re.search(r"WARNING:|ERROR:", line)]
    assert warnings == []
    assert site.status == 0, site.log[-3000:]


def test_what_a_kernel_sends_in_pieces_stands_as_it_was_printed(monkeypatch):
    monkeypatch.setattr(render, "coalesce_streams", render.coalesce_streams)
    notebooks.setup(MagicMock())
    pieces = ("c = 1:", " 31.7%\nd = 3:", " 80.1%", "\n  e = 6\n\n", "end\n")
    sent = [new_output("stream", name="stdout", text=piece) for piece in pieces]
    (shown,) = render.coalesce_streams(sent)
    assert shown.text == "c = 1: 31.7%\nd = 3: 80.1%\n  e = 6\n\nend\n"


@pytest.mark.parametrize("page", PAGES)
def test_a_page_of_the_contents_has_its_description_its_menu_and_its_foot(page, site):
    html = (site.folder / f"{page}.html").read_text(encoding="utf-8")
    assert re.search(rf"<title>.*{re.escape(escape(TITLE))}</title>", html, re.S)
    assert re.search(r'<meta content="[^"]{20,}" name="description"', html)
    assert 'rel="icon" href="../_static/favicon.svg"' in html
    (menu,) = re.findall(r'<nav class="bd-links.*?</nav>', html, re.S)
    assert "teach.html" in menu or page == "chapters/teach"
    assert BELOW == ["chapters/errata"] and "errata.html" not in menu
    assert page in BELOW or 'href="errata.html">its errata<' in html
    foot = " ".join(re.sub(r"<[^>]+>", "", html[html.index("bd-footer-content") :]).split())
    assert "Text and figures: CC BY 4.0. Code: BSD-3-Clause." in foot
    assert "which names MIT 16.485 (VNAV) lectures 29–30 by Luca Carlone as its source." in foot
    assert f"It is not affiliated with either. Version {VERSION}." in foot


def test_the_chapters_are_the_whole_site(site):
    """Neither solutions nor tests are built, not even as sources to download."""
    sources = [path.relative_to(site.folder / "_sources") for path in files(site, "_sources")]
    assert sorted({str(path.parent) for path in sources}) == ["chapters"]
    assert {str(path.with_suffix("")).removesuffix(".md") for path in sources} == set(PAGES)


def files(site: Site, folder: str) -> list[Path]:
    return [path for path in (site.folder / folder).rglob("*") if path.is_file()]


def test_every_link_inside_the_site_leads_somewhere(pages):
    assert [line for path in pages for line in broken(path, pages)] == []


def broken(page: Path, pages: dict[Path, Reader]) -> list[str]:
    """Return the addresses of the page whose file, or whose place in it, is missing."""
    missing = []
    for address in filter(inside, pages[page].linked + pages[page].loaded):
        parts = urlsplit(address)
        target = (page.parent / unquote(parts.path)).resolve() if parts.path else page
        place = unquote(parts.fragment)
        if not target.exists() or (place and target in pages and place not in pages[target].ids):
            missing.append(f"{page.name}: {address}")
    return missing


@pytest.mark.parametrize("name", assignment.find_names(ASSIGNMENTS))
def test_the_sections_that_feedback_links_to_are_there(name, site):
    config = assignment.load_config(ASSIGNMENTS / name / assignment.CONFIG_NAME)
    sections = site.parsed(f"chapters/{config.chapter}").find_all("section", id=True)
    assert {anchor(each) for each in config.sections.values()} <= {one["id"] for one in sections}


class TestExtension:
    """What the local extension keeps in mind between builds."""

    def application(self, tmp_path: Path, **more: object) -> SimpleNamespace:
        (tmp_path / "lib" / "robust_slam").mkdir(parents=True)
        (tmp_path / "doctrees").mkdir()
        (tmp_path / "doctrees" / "environment.pickle").touch()
        outdir, doctrees = tmp_path / "build" / "html", tmp_path / "doctrees"
        return SimpleNamespace(srcdir=tmp_path, outdir=outdir, doctreedir=doctrees, **more)

    def cache(self, app: SimpleNamespace) -> tuple[str, str]:
        notebooks.follow(app, config := SimpleNamespace())
        return config.course_library, config.nb_execution_cache_path

    @pytest.mark.parametrize(
        "name", ["lib/robust_slam/estimators/kernels.py", "chapters/data/growth.csv"]
    )
    def test_notebooks_run_again_when_what_they_read_changes(self, name, tmp_path):
        app, caches = self.application(tmp_path), []
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        for text in ("a = 1", "a = 2", "a = 1"):
            path.write_text(text)
            caches.append(self.cache(app))
        assert caches[0] == caches[2] != caches[1]

    def test_notebooks_run_again_when_a_public_graph_comes_or_goes(self, tmp_path, monkeypatch):
        app, caches = self.application(tmp_path), []
        for here in ((), ("intel",), ("CSAIL",), ("CSAIL", "intel"), ()):
            monkeypatch.setattr(notebooks.datasets, "is_here", here.__contains__)
            caches.append(self.cache(app))
        assert caches[0] == caches[-1]
        assert len(set(caches)) == 4

    @pytest.mark.parametrize("warnings", [0, 1])
    def test_only_a_build_with_warnings_is_forgotten(self, warnings, tmp_path):
        app = self.application(tmp_path, _warncount=warnings)
        notebooks.forget_if_warned(app, None)
        assert (tmp_path / "doctrees" / "environment.pickle").exists() == (warnings == 0)
