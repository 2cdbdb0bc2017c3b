"""`make book` builds again when a public graph appears or vanishes, and not otherwise."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest
from robust_slam.files import datasets

ROOT = Path(__file__).parents[2]
# `python tools/quietly.py LOG COMMAND` runs the command; any other module does nothing.
PYTHON = '#!/bin/sh\nif [ "$1" = tools/quietly.py ]; then shift 2; exec "$@"; fi\n'
BUILDER = "#!/bin/sh\nmkdir -p build/_build/html && echo built >> built.txt\n"
NEEDED = ("_config.yml", "_toc.yml", "requirements.lock", "lib/pyproject.toml",
          "lib/course/pyproject.toml", "autograder/pyproject.toml", "chapters/page.md",
          ".venv/.ready", "tools/fonts.py", "build/fonts/fonts.css")  # fmt: skip


@pytest.fixture
def course(tmp_path, monkeypatch):
    """A course of empty files, whose builder counts its runs, on a machine without graphs."""
    folder = tmp_path / "course"
    for name in NEEDED:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).touch()
    shutil.copy(ROOT / "Makefile", folder)
    for name, text in (("jupyter-book", BUILDER), ("python", PYTHON)):
        path = folder / ".venv" / "bin" / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(text)
        path.chmod(0o755)
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    for variable in (datasets.FOLDER, "XDG_CACHE_HOME", "MAKEFLAGS", "MAKELEVEL"):
        monkeypatch.delenv(variable, raising=False)
    return folder


def builds(course: Path) -> int:
    """Run `make book`, and return how often the book has been built so far."""
    subprocess.run(["make", "-s", "build/.book"], cwd=course, check=True)
    return len((course / "built.txt").read_text().splitlines())


def add(folder: Path, name: str) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{name}.g2o"
    path.touch()
    os.utime(path, (0, 0))  # a file may be older than the book
    return path


@pytest.mark.parametrize("where", ["folder", "cache"])
def test_a_graph_that_comes_or_goes_builds_the_book_again(where, course, tmp_path, monkeypatch):
    given = tmp_path / "given"
    monkeypatch.setenv(datasets.FOLDER, str(given))
    cache = tmp_path / "home" / ".cache" / "robust-slam"
    assert builds(course) == builds(course) == 1
    paths = [add(given if where == "folder" else cache, name) for name in datasets.SHOWN]
    assert builds(course) == builds(course) == 2
    paths[0].unlink()
    assert builds(course) == builds(course) == 3


def test_a_graph_that_the_chapters_do_not_show_changes_nothing(course, tmp_path, monkeypatch):
    monkeypatch.setenv(datasets.FOLDER, str(tmp_path / "given"))
    assert builds(course) == 1
    add(tmp_path / "given", "sphere2500")
    assert builds(course) == 1


def test_graphs_that_the_build_itself_fetches_do_not_build_it_twice(course, tmp_path):
    cache = tmp_path / "home" / ".cache" / "robust-slam"
    fetch = f"mkdir -p {cache} && touch {cache}/intel.g2o {cache}/CSAIL.g2o\n"
    (course / ".venv" / "bin" / "python").write_text(PYTHON + fetch)
    assert builds(course) == builds(course) == 1


def test_packages_for_development_do_not_build_it_again(course):
    """Decks lie in the built site, and `make pdf` after `make slides` would remove them."""
    (course / "requirements-dev.lock").touch()
    (course / ".venv" / "bin" / "pip").symlink_to("/bin/true")
    assert builds(course) == 1
    subprocess.run(["make", "-s", "PYTHON=true", ".venv/.ready-dev"], cwd=course, check=True)
    assert builds(course) == 1
