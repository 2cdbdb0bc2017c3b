"""Other interpreters with the grader's packages, made of links to this one's files."""

import os
import shutil
import site
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

from robust_slam_autograder.reading.defaults import DEFAULT_PACKAGES
from robust_slam_autograder.sandbox import packages
from robust_slam_autograder.student.imports import NOT_INSTALLED

SYSTEM = Path("/usr/bin/python3")
PSUTIL = "psutil"
"""What the grader needs outside the sandbox alone."""


def with_packages_inside(folder: Path) -> Path:
    """An interpreter whose packages lie in its standard library's folder, as conda's do.

    Returns:
        the interpreter.
    """
    version = f"python{sys.version_info.major}.{sys.version_info.minor}"
    base, prefix = Path(sys.base_prefix), folder / "prefix"
    for name in ("bin", "lib"):
        (prefix / name).mkdir(parents=True)
    for path in (base / "lib").glob("libpython*"):
        _link(path, prefix / "lib" / path.name)
    left_out = shutil.ignore_patterns("*-packages", "config-*", *NOT_INSTALLED)
    library = prefix / "lib" / version
    shutil.copytree(base / "lib" / version, library, ignore=left_out, copy_function=_link)
    python = prefix / "bin" / "python3"
    _link(Path(os.path.realpath(sys.executable)), python)
    for name in NOT_INSTALLED[:2]:
        (library / name).mkdir()
    fill(Path(site.getsitepackages([str(prefix)])[-1]))  # Debian's has another name
    return python


def fill(folder: Path) -> None:
    """Install the default packages, and another one, by links to the files of ours."""
    folder.mkdir(exist_ok=True)
    found = packages.find((*DEFAULT_PACKAGES, PSUTIL, "networkx"))
    for path in found.paths:
        if path.is_dir():
            shutil.copytree(path, folder / path.name, copy_function=_link)
        else:
            _link(path, folder / path.name)


def _link(source: os.PathLike[str] | str, place: os.PathLike[str] | str) -> None:
    try:
        os.link(os.path.realpath(source), place)
    except OSError:  # on another disk
        shutil.copy(source, place)


def of_the_system(folder: Path) -> Path:
    subprocess.run([SYSTEM, "-m", "venv", "--without-pip", folder / "venv"], check=True)
    version = f"python{sys.version_info.major}.{sys.version_info.minor}"
    fill(folder / "venv" / "lib" / version / "site-packages")
    return folder / "venv" / "bin" / "python"


def available() -> dict[str, Callable[[Path], Path]]:
    """The interpreters that can be made here: the system's only where it has our version."""
    made: dict[str, Callable[[Path], Path]] = {"with packages inside": with_packages_inside}
    if SYSTEM.exists() and sys.base_prefix != "/usr":
        asked = "import sys; print(tuple(sys.version_info[:2]))"
        done = subprocess.run([SYSTEM, "-c", asked], capture_output=True, text=True)
        if done.stdout.strip() == str(tuple(sys.version_info[:2])):
            made["the system's"] = of_the_system
    return made
