"""The packages that students install, built as wheels that travel with an assignment."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from robust_slam_autograder.errors import GraderFailure, WrongUse
from robust_slam_autograder.publishing.course import COURSE_NAME, Course, name_of
from robust_slam_autograder.publishing.files import chosen, tracked

_BUILD = """\
import os, pkgutil, sys, tomllib
out, *folders = sys.argv[1:]
for folder in folders:
    os.chdir(folder)
    with open("pyproject.toml", "rb") as file:
        backend = tomllib.load(file)["build-system"]["build-backend"]
    pkgutil.resolve_name(backend).build_wheel(out)
"""
"""pip would do the same with several processes for each package, and take six times as long."""


def build(course: Course, out: Path) -> dict[str, Path]:
    """Build a wheel of each package of ``[install.assignments]``.

    The same files give the same bytes where the build backend does, as hatchling does.

    Args:
        course: names the packages and their folders.
        out: where the wheels go.

    Returns:
        the wheels, by the package's name.

    Raises:
        WrongUse: a folder holds no file that the public may have.
        GraderFailure: one cannot be built.
    """
    packages = course.packages()
    if not packages:
        return {}
    with tempfile.TemporaryDirectory(prefix="wheels-") as temporary:
        sources = [_copy(course, folder, Path(temporary)) for folder in packages.values()]
        build_all(sources, out)
    found = {_normal(path.name.split("-")[0]): path for path in out.glob("*.whl")}
    return {name_of(package): found[_normal(name_of(package))] for package in packages}


def build_all(sources: Sequence[Path], out: Path) -> None:
    """Build a wheel of each folder with its own build backend, which must be installed here.

    Raises:
        GraderFailure: one cannot be built.
    """
    # -P: a backend is never looked for in the folder itself.
    command = [sys.executable, "-P", "-c", _BUILD, *map(os.path.abspath, (out, *sources))]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        folders = ", ".join(source.name for source in sources)
        raise GraderFailure(f"No wheels could be built of {folders}: {_reason(done.stderr)}")


def _copy(course: Course, folder: str, target: Path) -> Path:
    """Copy what the public may have of a folder: a build must neither see nor write more."""
    names = _files(course)
    for name in (name for name in names if name.startswith(f"{folder}/")):
        (target / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(course.root / name, target / name)
    if not (target / folder).is_dir():
        raise WrongUse(
            f"{course.tree / COURSE_NAME}: [install.assignments] names {folder}/, and there is "
            "no file of it that the public may have."
        )
    return target / folder


def _files(course: Course) -> list[str]:
    if course.public is not None:
        return chosen(course.public, tracked(course.root), course.tree / COURSE_NAME)
    folders = [course.root / folder for folder in course.packages().values()]
    paths = [path for folder in folders for path in folder.rglob("*") if path.is_file()]
    return [path.relative_to(course.root).as_posix() for path in paths]


def _normal(name: str) -> str:
    return re.sub(r"[-_.]+", "_", name).lower()


def _reason(said: str) -> str:
    lines = [line.strip() for line in said.splitlines() if line.strip()]
    return lines[-1] if lines else "it gave no reason."
