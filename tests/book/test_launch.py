"""The public repository's address gives chapters launch buttons and previews a picture."""

import json
import re
import subprocess
import sys
import tomllib
from pathlib import Path
from types import SimpleNamespace
from xml.etree import ElementTree

import pytest
import yaml
from matplotlib.image import imread

from chapters._ext import finding

pytestmark = pytest.mark.rest

ROOT = Path(__file__).parents[2]
SETTINGS = (ROOT / "_config.yml").read_text(encoding="utf-8")
NAME = "Maps & Robots"
ADDRESS = "https://github.com/owner/course"
LAUNCHES = {
    "https://colab.research.google.com/github/owner/course/blob/main/chapters/00-one.ipynb",
    "https://mybinder.org/v2/gh/owner/course/main?urlpath=lab/tree/chapters/00-one.ipynb",
}

TEXT = "# One\n\nText.\n\nThere is `00-one.zip`, and there is no `01-two.zip`."


def with_address(url: str) -> str:
    """The course's own settings with another address and name, which a person would change."""
    changed = SETTINGS.replace("    <p>Version {version}.</p>\n", "")  # there is no library here
    assert changed != SETTINGS
    for setting, value in (("  url", url), ("title", NAME)):
        changed, count = re.subn(rf"(?m)^{setting}: .*$", f'{setting}: "{value}"', changed)
        assert count == 1, "one setting in one place"
    return changed


def put_lab(folder: Path) -> None:
    """What `make runtime` leaves of the assignments, with a file that the site is to have."""
    lab = folder / "build" / "runtime" / "lab"
    (lab / "files").mkdir(parents=True)
    (lab / "files" / "00-one.ipynb").touch()
    (lab / "pyodide-lock.json").write_text("{}")


def build(folder: Path, url: str) -> str:
    """Build a book of one chapter with the course's settings, without a warning: its page."""
    (folder / "chapters").mkdir()
    for name in ("_ext", "_templates", "assets"):
        (folder / "chapters" / name).symlink_to(ROOT / "chapters" / name)
    (folder / "chapters" / "references.bib").write_text("")
    (folder / "chapters" / "index.md").write_text("# {{ course }}\n\nWelcome.\n")
    markdown = {"cell_type": "markdown", "id": "intro", "metadata": {}, "source": TEXT}
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    chapter = {"nbformat": 4, "nbformat_minor": 5, "metadata": {"kernelspec": kernel}}
    text = json.dumps(chapter | {"cells": [markdown]})
    (folder / "chapters" / "00-one.ipynb").write_text(text)
    (folder / "_config.yml").write_text(with_address(url), encoding="utf-8")
    (folder / "assignments").mkdir()
    (folder / "assignments" / "00-one.zip").write_bytes(b"PK")
    toc = {"root": "chapters/index", "chapters": [{"file": "chapters/00-one"}]}
    (folder / "_toc.yml").write_text(yaml.safe_dump({"format": "jb-book"} | toc))
    book = Path(sys.executable).with_name("jupyter-book")
    command = [book, "build", ".", "--path-output", "build", "-W", "-n", "--keep-going"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    log = done.stdout + done.stderr
    assert done.returncode == 0 and not re.search(r"(WARNING|ERROR): ", log), log[-3000:]
    page = folder / "build" / "_build" / "html" / "chapters" / "00-one.html"
    return page.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("url", "lab"), [("", False), (ADDRESS, True)], ids=["bare", "with address and runtime"]
)
def test_pages_have_links_to_what_is_there(tmp_path, url, lab):
    """jupyter-book builds a whole book of one chapter."""
    if lab:
        put_lab(tmp_path)
    html = build(tmp_path, url)
    launches = set(re.findall(r'href="([^"]*(?:colab|binder)[^"]*)"', html))
    assert launches == (LAUNCHES if url else set())
    assert ("btn-launch" in html or "launch-buttons" in html) == bool(url)
    assert "executablebooks/jupyter-book" not in html, "the default of another book"
    site = tmp_path / "build" / "_build" / "html"
    assert_has_the_name(html, site)
    assert_previews(html, site, url)
    assert_a_missing_page_and_the_list_of_pages(site, url)
    assert re.findall(r'href="([^"]*\.zip)"', html) == ["../assignments/00-one.zip"]
    assert (site / "assignments" / "00-one.zip").read_bytes() == b"PK"
    assert_opens_in_the_browser(html, site, lab)


def assert_opens_in_the_browser(html: str, site: Path, lab: bool) -> None:
    if not lab:
        assert "open in the browser" not in html and not (site / "lab").exists()
        return
    address = "../lab/lab/index.html?path=00-one.ipynb"
    assert f'(<a class="reference internal" href="{address}">open in the browser</a>)' in html
    assert html.count("open in the browser") == 1, "there is no 01-two"
    assert (site / "lab" / "pyodide-lock.json").read_text() == "{}"


def assert_has_the_name(html: str, site: Path) -> None:
    name = "Maps &amp; Robots"
    front = (site / "chapters" / "index.html").read_text(encoding="utf-8")
    assert f"<h1>{name}<" in front and f"<title>{name}</title>" in front
    assert re.search(rf'logo__title">\s*{name}\s*<', html), "in the sidebar"
    assert re.search(rf"<title>One\W.*{name}</title>", html)
    assert f'"og:site_name" content="{name}"' in html
    assert "Robust SLAM<" not in front.replace("<cite>Robust SLAM &amp; Frontiers", "")


def assert_previews(html: str, site: Path, url: str) -> None:
    tags = dict(re.findall(r'<meta property="([^"]*)" content="([^"]*)" />', html))
    assert tags["og:title"] == "One" and tags["og:description"] == "Text."
    picture = site / "_static" / "preview.png"
    if not url:
        assert "og:image" not in tags and not picture.exists()
        return
    assert tags["og:url"] == "https://owner.github.io/course/chapters/00-one.html"
    assert tags["og:image"] == "https://owner.github.io/course/_static/preview.png"
    assert imread(picture).shape[:2] == (630, 1200)


def assert_a_missing_page_and_the_list_of_pages(site: Path, url: str) -> None:
    missing = (site / "404.html").read_text(encoding="utf-8")
    assert re.findall(r'<base href="(.*?)"', missing) == (["/course/"] if url else [])
    assert missing.find("<base") < missing.index("<link")
    assert 'href="chapters/index.html">first page' in missing
    assert (site / "sitemap.xml").exists() == bool(url)
    if url:
        pages = ElementTree.parse(site / "sitemap.xml").findall(".//{*}loc")
        assert [page.text for page in pages] == [
            f"https://owner.github.io/course/chapters/{name}.html" for name in ("00-one", "index")
        ]


def set_up(url: str | None, own: str = "") -> SimpleNamespace:
    options = {"repository_url": url, "launch_buttons": {"colab_url": "x"}, "other": 1}
    config = SimpleNamespace(html_baseurl=own, html_theme_options=options)
    finding.find_the_address(SimpleNamespace(), config)
    return config


def test_an_address_that_is_given_is_the_sites():
    given = "https://slam.example.org/course"
    assert set_up("", given).html_baseurl == f"{given}/" == set_up(ADDRESS, given).html_baseurl


@pytest.mark.parametrize(
    ("url", "opened"),
    [
        ("", ""),
        (None, ""),
        (ADDRESS, ADDRESS),
        (f"{ADDRESS}/", ADDRESS),
        (f"{ADDRESS}.git", ADDRESS),
        ("https://github.com/owner", ""),
        ("https://gitlab.com/owner/course", ""),
        ("https://example.org/github.com/course", ""),
    ],
)
def test_only_what_both_can_open_has_buttons(url, opened):
    config = set_up(url)
    options = config.html_theme_options
    assert options["repository_url"] == opened and options["other"] == 1
    assert bool(options["launch_buttons"]) == bool(opened) == bool(config.html_baseurl)


def test_binder_gets_what_a_chapters_cell_installs():
    """It runs pip in the repository, and takes a Python that is too old unless told."""
    lines = (ROOT / "binder" / "requirements.txt").read_text(encoding="utf-8").splitlines()
    wanted = [line for line in lines if not line.startswith("#")]
    assert wanted == ["./lib[sdp]", "./lib/course[live]"]
    python = (ROOT / "binder" / "runtime.txt").read_text(encoding="utf-8").strip()
    for line in wanted:
        folder, extra = re.fullmatch(r"\./([\w/]+)\[(\w+)\]", line).groups()
        project = tomllib.loads((ROOT / folder / "pyproject.toml").read_text("utf-8"))["project"]
        assert extra in project["optional-dependencies"]
        assert project["requires-python"] == f">={python.removeprefix('python-')}"
