"""What a sandbox shows, as the packages and the machine have it."""

import importlib.metadata
import sys
from pathlib import Path

import pytest
import scipy
from robust_slam_autograder.reading.assignment import DEFAULT_PACKAGES
from robust_slam_autograder.sandbox import packages, view
from robust_slam_autograder.student import imports

from ..as_user import ROOT, ended
from ..sessions import started
from . import interpreters

SITE = Path(scipy.__file__).parents[1]


def shown(allowed: tuple[str, ...]) -> list[Path]:
    return [path for path, is_shown in view.files(allowed, ()).rules if is_shown]


def names_shown(*allowed: str) -> set[str]:
    return {path.name for path in shown(allowed) if path.parent == SITE}


def test_the_libraries_are_those_that_the_loader_takes():
    """An interpreter that sees nothing else runs; what it has loaded is all in the view."""
    names = "numpy.linalg, scipy.optimize, matplotlib.pyplot, ssl, sqlite3, lzma, ctypes, hashlib"
    text = f"import {names}\nprint(open('/proc/self/maps').read())"
    maps = ended([sys.executable, "-c", text]).stdout.splitlines()
    loaded = {Path(line.split()[-1]) for line in maps if ".so" in line}
    there = [path.resolve() for path in shown(DEFAULT_PACKAGES)]
    systems = {path.resolve() for path in loaded if not path.is_relative_to(SITE)}
    assert len(systems) > 10
    assert [path for path in systems if not view.within(path, there)] == []


def test_a_folder_in_view_is_found_also_through_a_link(tmp_path):
    link = tmp_path / "course"
    link.symlink_to(SITE / "scipy")
    assert view.exposing(link / "solutions", DEFAULT_PACKAGES) == SITE / "scipy"
    assert view.exposing(SITE / "scipy" / "submitted", DEFAULT_PACKAGES) == SITE / "scipy"
    assert view.exposing(tmp_path / "solutions", DEFAULT_PACKAGES) is None
    for place in ("/usr/src/app/solutions", "/usr/local/share/nbgrader/exchange"):
        assert view.exposing(Path(place), DEFAULT_PACKAGES) is None


def test_an_editors_copies_of_a_withheld_module_are_withheld_too(tmp_path, monkeypatch):
    package = tmp_path / "toy_package"
    for name in (".ipynb_checkpoints/gnc-checkpoint.py", ".gnc.py.swp", "gnc.py~", "#gnc.py#"):
        (package / name).parent.mkdir(parents=True, exist_ok=True)
        (package / name).touch()
    for name in ("__init__.py", "gnc.py", "other.py"):
        (package / name).touch()
    monkeypatch.syspath_prepend(tmp_path)
    rules = view.files((tmp_path.name, "toy_package"), ("toy_package.gnc",)).rules
    found = {path.name for path, is_shown in rules if not is_shown and package in path.parents}
    assert found == {".ipynb_checkpoints", ".gnc.py.swp", "gnc.py~", "#gnc.py#", "gnc.py"}


def test_a_link_in_a_folder_leads_nowhere_else(tmp_path):
    """Landlock judges a file by where it lies, and folders are gone through that hide a part."""
    (tmp_path / "secret").mkdir()
    package = tmp_path / "package"
    package.mkdir()
    for name in ("given.py", "answers.py"):
        (package / name).touch()
    (package / "link").symlink_to(tmp_path / "secret")
    (package / "withheld").mkdir()
    (package / "withheld" / "kernels.py").touch()
    (package / "inner_link.py").symlink_to("withheld/kernels.py")
    rules = ((package, True), (package / "answers.py", False), (package / "withheld", False))
    opened = view.readable(view.Files(rules, (), ()))
    assert sorted(opened) == [(package, False), (package / "given.py", True)]


def test_a_module_of_one_file_without_metadata_is_installed(tmp_path, monkeypatch):
    """As where a teacher has copied it among the installed packages."""
    (tmp_path / "one_file_tool.py").touch()
    monkeypatch.syspath_prepend(tmp_path)
    assert packages.missing(["one_file_tool"]) == []
    found = packages.find((*DEFAULT_PACKAGES, "one_file_tool"))
    packages.find.cache_clear()
    assert found.in_place["one_file_tool"] == str(tmp_path / "one_file_tool.py")
    there = imports.Installed(found.names, found.in_place, []).find_spec("one_file_tool")
    assert there is not None and there.origin == str(tmp_path / "one_file_tool.py")


LOOK = """
import importlib.metadata, os, sys
import matplotlib.pyplot, numpy, scipy.stats, tqdm, zoneinfo

def look():
    site = os.path.dirname(os.path.dirname(numpy.__file__))
    others = [os.path.join(site, name, "__init__.py") for name in ("networkx", "psutil/tests")]
    zone = str(zoneinfo.ZoneInfo("Europe/Zurich"))
    return [sys.prefix, importlib.metadata.version("numpy"), zone, [*filter(opens, others)]]

def opens(path):
    try:
        return bool(open(path))
    except OSError:
        return False
"""
SCRIPT = f"""
import sys
from robust_slam_autograder.sandbox import BACK_ENDS
sys.path.append({str(ROOT)!r})
from {started.__module__} import started

with started({LOOK!r}, names=("look",), wall=BACK_ENDS[sys.argv[1]]) as session:
    print(session.errors or session.bindings()["look"]())
"""


@pytest.mark.sandbox
@pytest.mark.parametrize("kind", interpreters.available())
@pytest.mark.rest
def test_another_interpreter_works_too(wall_name, kind, tmp_path):
    """Debian's in a virtual environment; and one as conda's and container images' are."""
    python = interpreters.available()[kind](tmp_path)
    for folder in (tmp_path, *tmp_path.parents[:2]):
        folder.chmod(0o755)
    done = ended([python, "-c", SCRIPT, wall_name], cwd=tmp_path)
    prefix = "/usr" if kind == "the system's" else str(tmp_path / "prefix")
    version = importlib.metadata.version("numpy")
    assert done.stdout.strip() == repr([prefix, version, "Europe/Zurich", []]), done.stderr[-1000:]
