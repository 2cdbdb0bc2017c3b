"""What a sandbox shows, as the packages and the machine have it."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
import scipy
from robust_slam_autograder.executor.imports import DEFAULT_PACKAGES
from robust_slam_autograder.sandbox import packages, view

SITE = Path(scipy.__file__).parents[1]


def names_shown(*allowed: str) -> set[str]:
    return {path.name for path in view.files(allowed, ()).visible if path.parent == SITE}


def test_a_package_comes_with_all_that_it_needs() -> None:
    shown = names_shown("matplotlib")
    assert {"matplotlib", "mpl_toolkits", "numpy", "numpy.libs", "PIL", "kiwisolver"} <= shown
    assert any(name.startswith("matplotlib-") for name in shown)  # its version can be asked for


@pytest.mark.parametrize("other", ["gtsam", "evo", "networkx", "nbgrader", "pytest", "cvxpy"])
def test_other_packages_are_not_there(other: str) -> None:
    assert (SITE / other).exists()
    for allowed in (DEFAULT_PACKAGES, (*DEFAULT_PACKAGES, "robust_slam")):
        assert other not in names_shown(*allowed)


def test_extras_are_not_followed() -> None:
    """The library solves with cvxpy and compares with gtsam where they are there."""
    assert "cvxpy" in names_shown("cvxpy")
    found = packages.find((*DEFAULT_PACKAGES, "robust_slam"))
    assert "robust_slam" in found.names and not {"cvxpy", "gtsam"} & {*found.names}


def test_a_package_in_its_source_folder_is_shown_without_its_surroundings() -> None:
    visible = view.files(("robust_slam",), ()).visible
    import robust_slam

    folder = Path(robust_slam.__file__).parent
    assert folder in visible and folder.parent not in visible


def test_no_folder_of_the_system_is_shown_as_a_whole() -> None:
    folders = {path for path in view.files(DEFAULT_PACKAGES, ()).visible if path.is_dir()}
    parts = {*Path("/usr/lib/python3").parents, Path("/usr/lib"), Path("/usr/local"), Path("/etc")}
    system = {path for path in folders if path in parts or path.match("*-linux-gnu")}
    assert not system and not {SITE, *SITE.parents} & folders


def test_the_libraries_are_those_that_the_loader_takes() -> None:
    """An interpreter that sees nothing else runs; what it has loaded is all in the view."""
    names = "numpy.linalg, scipy.optimize, matplotlib.pyplot, ssl, sqlite3, lzma, ctypes, hashlib"
    text = f"import {names}\nprint(open('/proc/self/maps').read())"
    maps = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True).stdout
    loaded = {Path(line.split()[-1]) for line in maps.splitlines() if ".so" in line}
    shown = [path.resolve() for path in view.files(DEFAULT_PACKAGES, ()).visible]
    systems = {path.resolve() for path in loaded if not path.is_relative_to(SITE)}
    assert len(systems) > 10
    assert [path for path in systems if not view.within(path, shown)] == []


def test_a_folder_in_view_is_found_also_through_a_link(tmp_path: Path) -> None:
    link = tmp_path / "course"
    link.symlink_to(SITE / "scipy")
    assert view.exposing(link / "solutions", DEFAULT_PACKAGES) == SITE / "scipy"
    assert view.exposing(SITE / "scipy" / "submitted", DEFAULT_PACKAGES) == SITE / "scipy"
    assert view.exposing(tmp_path / "solutions", DEFAULT_PACKAGES) is None
    for place in ("/usr/src/app/solutions", "/usr/local/share/nbgrader/exchange"):
        assert view.exposing(Path(place), DEFAULT_PACKAGES) is None


def test_unknown_packages_are_named() -> None:
    assert packages.missing(["numpy", "math", "robust_slam", "IPython", "PIL"]) == []
    assert packages.missing(["numpy", "no_such_package"]) == ["no_such_package"]


CONDA = """
import os, subprocess, sys
sys.path[:0] = {path!r}
from robust_slam_autograder.sandbox import BACK_ENDS, Launch
wall = BACK_ENDS[{wall!r}]
print(wall.problem(), sys.base_prefix)
"""


@pytest.mark.sandbox
def test_another_interpreter_works_too(wall_name: str, tmp_path: Path) -> None:
    """The system's Python, whose standard library lies in /usr/lib, with packages elsewhere."""
    system = Path("/usr/bin/python3")
    version = f"{sys.version_info.major}.{sys.version_info.minor}"
    asked = (
        subprocess.run(
            [system, "-c", "import sys; print('%d.%d' % sys.version_info[:2], sys.base_prefix)"],
            capture_output=True,
            text=True,
        )
        if system.exists()
        else None
    )
    if asked is None or asked.stdout.split()[:1] != [version] or sys.base_prefix == "/usr":
        pytest.skip("this machine has no second Python of this version")
    # A virtual environment of it, whose packages are links to ours.
    site = tmp_path / "venv" / "lib" / f"python{version}" / "site-packages"
    subprocess.run([system, "-m", "venv", "--without-pip", tmp_path / "venv"], check=True)
    for path in SITE.iterdir():
        if not path.name.startswith(("_distutils", "distutils")):
            (site / path.name).symlink_to(path)
    for folder in (tmp_path, *tmp_path.parents[:2]):
        folder.chmod(0o755)
    text = CONDA.format(path=[], wall=wall_name)
    python = tmp_path / "venv" / "bin" / "python"
    environment = {**os.environ, "PYTHONPATH": ""}
    done = subprocess.run([python, "-c", text], capture_output=True, text=True, env=environment)
    assert done.stdout.split() == ["None", "/usr"], done.stdout + done.stderr
