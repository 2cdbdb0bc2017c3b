"""No solution and no hidden test reaches the student release or the site.

Two kinds of canary: text planted into a copy of the source tree, and every line of
the real hidden regions and solutions that is long enough to be told apart.
"""

from __future__ import annotations

import html
import json
import re
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
from robust_slam_autograder.nbgrader.release import release

from tests.assignments import answers

REGION = re.compile(r"### BEGIN (SOLUTION|HIDDEN TESTS)\n(.*?)### END \1", re.DOTALL)
CANARY = "canary-4c7e"
TELLING = 32
"""Shorter lines, and imports, stand in many a chapter by chance and tell nothing."""
HTML = answers.ROOT / "build" / "html"


def regions(source: str) -> Iterator[str]:
    for match in REGION.finditer(source):
        yield match.group(2)


def secret_lines(name: str) -> set[str]:
    """Lines that only the instructor has."""
    cells = ["".join(c["source"]) for c in answers.source_notebook(name)["cells"]]
    shown = {line.strip() for cell in cells for line in REGION.sub("", cell).split("\n")}
    hidden = {
        line.strip() for cell in cells for text in regions(cell) for line in text.split("\n")
    }
    return {line for line in hidden - shown if len(line) >= TELLING and "import " not in line}


def files_below(folder: Path) -> Iterator[tuple[Path, str]]:
    for path in sorted(folder.rglob("*")):
        if path.is_file() and path.suffix in {".ipynb", ".html", ".js", ".txt", ".json", ".toml"}:
            yield path, path.read_text(encoding="utf-8", errors="replace")


def plain_lines(path: Path, text: str) -> set[str]:
    """A file's lines as a reader sees them: without markup, a notebook's cells as text."""
    if path.suffix == ".ipynb":
        text = "\n".join("".join(cell["source"]) for cell in json.loads(text)["cells"])
    elif path.suffix == ".html":
        text = html.unescape(re.sub(r"<[^>]*>", "", text))
    return {line.strip() for line in text.split("\n")}


@pytest.mark.parametrize("name", answers.assignments())
def test_planted_canaries_do_not_reach_the_release(name: str, tmp_path: Path) -> None:
    tree = tmp_path / "solutions"
    shutil.copytree(answers.SOLUTIONS / name, tree / name)
    path = tree / name / f"{name}.ipynb"
    notebook = answers.source_notebook(name)
    for number, cell in enumerate(notebook["cells"]):
        source = "".join(cell["source"])
        mark = f"\\g<0>\n    # {CANARY} {number}"
        hidden = re.sub(r"# hint:.*", f"\\g<0> {CANARY}", source)
        cell["source"] = re.sub(r"( *)### BEGIN SOLUTION", mark, hidden)
    answers.write(path, notebook)
    assert path.read_text(encoding="utf-8").count(CANARY) > 10
    release(tree, [name], tmp_path / "release")
    leaks = [file for file, text in files_below(tmp_path / "release") if CANARY in text]
    assert not leaks


@pytest.mark.parametrize("name", answers.assignments())
def test_the_release_holds_no_line_of_a_solution_or_a_hidden_test(
    name: str, tmp_path: Path
) -> None:
    secrets = secret_lines(name)
    assert len(secrets) > 20
    release(answers.SOLUTIONS, [name], tmp_path)
    lines = {path.name: plain_lines(path, text) for path, text in files_below(tmp_path)}
    assert len(lines[f"{name}.ipynb"]) > 100
    assert not {name: found & secrets for name, found in lines.items() if found & secrets}


def test_the_site_holds_no_solution_and_no_hidden_test() -> None:
    assert (HTML / "index.html").is_file(), "build the site first: make book"
    secrets = {line for name in answers.assignments() for line in secret_lines(name)}
    pages = list(files_below(HTML))
    assert any(path.suffix == ".ipynb" for path, _ in pages), "the pages' sources are there too"
    leaks = {
        path.name: found for path, text in pages if (found := plain_lines(path, text) & secrets)
    }
    assert not leaks
    markers = ("BEGIN HIDDEN TESTS", "BEGIN SOLUTION", "# hint:")
    assert not [path for path, text in pages if any(mark in text for mark in markers)]
    assert not list(HTML.rglob("*solutions*"))


def test_a_canary_in_a_page_would_be_found(tmp_path: Path) -> None:
    secret = sorted(secret_lines(answers.assignments()[0]))[0]
    marked_up = " ".join(f"<span>{html.escape(word)}</span>" for word in secret.split(" "))
    page = tmp_path / "page.html"
    page.write_text(f"<pre>\n    {marked_up}\n</pre>", encoding="utf-8")
    (found,) = files_below(tmp_path)
    assert secret in plain_lines(*found)
