"""A page's packages are put in place when they are imported, and of each only what is."""

import importlib
import io
import sys
import zipfile
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

SOURCES = Path(__file__).parents[2] / "chapters" / "python"
WHEELS = {
    "outer": {
        "outer/__init__.py": "try:\n    import other_of_page\nexcept ImportError:\n    pass\n",
        "outer/near/__init__.py": "",
        "outer/near/data/table.csv": "1",
        "outer/far/__init__.py": "",
    },
    "other": {
        "other_of_page/__init__.py": "",
        "other_of_page/__pycache__/x.pyc": "",
        "second_of_page/inner/__init__.py": "",
    },
    "words": {"outer/words.txt": "a"},
}
PACKAGES = {
    "outer": {"imports": ["outer"], "depends": ["words"]},
    "other": {"imports": ["other_of_page", "second_of_page"], "depends": []},
    "words": {"imports": [], "depends": []},
}

TOP = ("outer", "other_of_page", "second_of_page")


class Files:
    """The site's files, of which some have been fetched."""

    def __init__(self) -> None:
        self.fetched: set[str] = set()
        self.waited_for: list[str] = []

    def read(self, name: str, may_wait: bool) -> Any:
        """Give an archive, as JavaScript gives bytes."""
        if name not in self.fetched:
            if not may_wait:
                return None
            self.waited_for.append(name)
        content = io.BytesIO()
        with zipfile.ZipFile(content, "w") as archive:
            for path, text in WHEELS[name].items():
                archive.writestr(path, text)
        return SimpleNamespace(to_bytes=content.getvalue)


@pytest.fixture
def files():
    return Files()


@pytest.fixture
def shelf(files, tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(str(SOURCES))
    monkeypatch.syspath_prepend(str(tmp_path))
    packages = {
        name: entry | {"file_name": name, "install_dir": "site"}
        for name, entry in PACKAGES.items()
    }
    page_packages = importlib.import_module("page_packages")
    made = page_packages.Shelf(packages, files.read, print, str(tmp_path))
    monkeypatch.setattr(sys, "meta_path", [made, *sys.meta_path])
    yield made
    for name in [each for each in sys.modules if each.split(".")[0] in TOP]:
        del sys.modules[name]


def in_place(folder: Path) -> set[str]:
    found = (path.relative_to(folder) for path in folder.rglob("*") if path.is_file())
    return {path.as_posix() for path in found if path.suffix != ".pyc"}


def test_only_the_folders_that_are_imported_are_unpacked(shelf, files, tmp_path):
    importlib.import_module("outer")
    first = {"outer/__init__.py", "outer/words.txt", "other_of_page/__init__.py"}
    assert in_place(tmp_path) == first and files.waited_for == ["words", "outer", "other"]
    importlib.import_module("outer.near")
    near = {"outer/near/__init__.py", "outer/near/data/table.csv"}
    assert in_place(tmp_path) == first | near
    importlib.import_module("second_of_page.inner")  # in a folder that is no package itself
    assert len(files.waited_for) == 3  # no archive is read twice


def test_what_the_imports_of_a_cell_need_is_told_before_it_runs(shelf, files):
    cell = "import this\ndef f():\n    from outer import near"
    asked = []
    while missing := shelf.missing(cell):
        asked.append(missing)
        files.fetched.update(missing)
    assert asked == [["outer", "words"], ["other"]]  # the second is imported by the first
    assert files.waited_for == [] and "this" not in sys.modules


@pytest.mark.parametrize("cell", ["import = 1", "from . import a", "import no_such", "print(1)"])
def test_a_cell_that_needs_nothing_or_cannot_run_asks_for_nothing(cell, shelf):
    assert shelf.missing(cell) == []
