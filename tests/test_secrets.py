"""No solution and no hidden test reaches the release, its archives, the site or the public course.

Two kinds of canary: text planted into a copy of the source tree, and every line of
the real hidden regions and solutions that is long enough to be told apart.
"""

from __future__ import annotations

import html
import json
import re
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from robust_slam_autograder.nbgrader.release import release
from robust_slam_autograder.publishing import course
from robust_slam_autograder.publishing.public import publish

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
    """Every file's text; an archive's files stand below the archive's name."""
    for path in sorted(path for path in folder.rglob("*") if path.is_file()):
        if path.suffix == ".zip":
            with zipfile.ZipFile(path) as archive:
                for name in archive.namelist():
                    yield path / name, archive.read(name).decode("utf-8", "replace")
        else:
            yield path, path.read_text(encoding="utf-8", errors="replace")


def texts_in(value: object) -> Iterator[str]:
    """Every text in a value of JSON; a list of texts, as nbformat has it, is one."""
    if isinstance(value, str):
        yield value
    elif isinstance(value, dict):
        yield from (text for part in value.values() for text in texts_in(part))
    elif isinstance(value, list) and all(isinstance(part, str) for part in value):
        yield "".join(value)
    elif isinstance(value, list):
        yield from (text for part in value for text in texts_in(part))


def plain_lines(path: Path, text: str) -> set[str]:
    """A file's lines as a reader sees them: without markup, all that a notebook holds as text."""
    if path.suffix == ".ipynb":
        text = "\n".join(texts_in(json.loads(text)))
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
    lines = {path: plain_lines(path, text) for path, text in files_below(tmp_path)}
    for folder in (tmp_path / name, tmp_path / f"{name}.zip" / name):
        assert len(lines[folder / f"{name}.ipynb"]) > 100
    assert not {path: found & secrets for path, found in lines.items() if found & secrets}


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


@pytest.fixture(scope="module")
def public(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The public course, written as `make public` writes it."""
    out = tmp_path_factory.mktemp("published") / "public"
    publish(answers.SOLUTIONS, out)
    return out


class TestPublicCourse:
    """``make public``, of this very course."""

    def test_it_holds_no_line_of_a_solution_or_a_hidden_test(self, public: Path) -> None:
        secrets = {line for name in answers.assignments() for line in secret_lines(name)}
        files = dict(files_below(public))
        assert len(files) > 250
        listed = course.load(answers.SOLUTIONS).public
        assert listed is not None and len(listed.known) < 10, "a list of rare coincidences"
        leaks = {}
        for path, text in files.items():
            name = path.relative_to(public).as_posix()
            if found := (plain_lines(path, text) & secrets) - set(listed.known.get(name, ())):
                leaks[name] = found
        assert not leaks

    def test_it_holds_no_region_and_no_hint_in_a_notebook(self, public: Path) -> None:
        notebooks = [(p, text) for p, text in files_below(public) if p.suffix == ".ipynb"]
        assert len(notebooks) > 2 * len(answers.assignments())
        markers = ("BEGIN HIDDEN TESTS", "BEGIN SOLUTION", "# hint:")
        assert not [path for path, text in notebooks if any(mark in text for mark in markers)]

    def test_it_holds_no_history_and_no_private_file(self, public: Path) -> None:
        names = {path.relative_to(public).as_posix() for path in public.rglob("*")}
        for private in ("solutions", ".git", "tests/assignments", "instructor.mk", "build"):
            assert private not in names
        tests = {path for path in names if path.startswith("tests/") and path.endswith(".py")}
        telling = ("tests.assignments", "sample_class", "test_secrets")
        assert not [
            name for name in tests if any(word in (public / name).read_text() for word in telling)
        ]
        paths = [*answers.ANSWERS.rglob("*.py"), *answers.SOLUTIONS.rglob("*.ipynb")]
        private = {path.read_bytes() for path in paths} - {b""}
        assert not [p for p in public.rglob("*") if p.is_file() and p.read_bytes() in private]

    def test_it_holds_each_assignment_twice_and_stands_on_its_own(self, public: Path) -> None:
        for name in answers.assignments():
            folder = public / "assignments"
            with zipfile.ZipFile(folder / f"{name}.zip") as archive:
                notebook = archive.read(f"{name}/{name}.ipynb")
            assert (folder / name / f"{name}.ipynb").read_bytes() == notebook
        needed = ("README.md", ".gitignore", "LICENSE", "LICENSE-text", "requirements.lock")
        assert not [name for name in needed if not (public / name).is_file()]
        readme = (public / "README.md").read_text(encoding="utf-8")
        assert "Keep this repository private" not in readme and "make public" not in readme
        assert "<!--" not in readme and "solutions/" not in readme

    def test_every_make_target_that_its_readme_names_is_there(self, public: Path) -> None:
        readme = (public / "README.md").read_text(encoding="utf-8")
        makefile = (public / "Makefile").read_text(encoding="utf-8")
        named = set(re.findall(r"(?:^|`)make ([a-z]+)", readme, re.M))
        assert named >= {"book", "test", "lab"}
        assert not [name for name in named if not re.search(rf"^{name}:", makefile, re.M)]

    def test_its_tests_can_all_be_collected(self, public: Path) -> None:
        """A test that reads solutions where it is collected would fail; make test runs them."""
        command = [
            sys.executable,
            "-m",
            "pytest",
            "-q",
            "--collect-only",
            "-p",
            "no:cacheprovider",
        ]
        done = subprocess.run(command, cwd=public, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout[-3000:]
        assert int(re.findall(r"(\d+) tests collected", done.stdout)[0]) > 500

    def test_a_line_that_somebody_adds_would_be_found(self, tmp_path: Path) -> None:
        """The canary lives: it sees any telling line of any assignment, wherever it is put."""
        for name in answers.assignments():
            secret = max(secret_lines(name))
            cell = {"cell_type": "code", "source": ["x = 1\n", f"  {secret}\n"], "outputs": []}
            plant = tmp_path / name
            plant.mkdir()
            (plant / "a.py").write_text(f"x = 1\n    {secret}\n", encoding="utf-8")
            (plant / "b.ipynb").write_text(json.dumps({"cells": [cell]}), encoding="utf-8")
            with zipfile.ZipFile(plant / "c.zip", "w") as archive:
                archive.write(plant / "b.ipynb", "d/b.ipynb")
            found = [path.name for path, text in files_below(plant)
                     if secret in plain_lines(path, text)]  # fmt: skip
            assert found == ["a.py", "b.ipynb", "b.ipynb"]
