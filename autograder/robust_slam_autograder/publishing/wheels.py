"""The packages that students install, built as wheels that travel with an assignment."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from robust_slam_autograder.errors import GraderFailure, WrongUse
from robust_slam_autograder.publishing.course import COURSE_NAME, Course, name_of
from robust_slam_autograder.publishing.files import chosen, tracked

_PIP = ("-m", "pip", "--disable-pip-version-check", "wheel", "--quiet")
_OFFLINE = ("--no-deps", "--no-index", "--no-build-isolation")


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
        GraderFailure: pip cannot build one.
    """
    packages = course.packages()
    if not packages:
        return {}
    with tempfile.TemporaryDirectory(prefix="wheels-") as temporary:
        sources = [_copy(course, folder, Path(temporary)) for folder in packages.values()]
        command = [sys.executable, *_PIP, *_OFFLINE, "--wheel-dir", str(out), *map(str, sources)]
        done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        folders = ", ".join(packages.values())
        raise GraderFailure(f"pip could not build {folders}: {_reason(done.stderr)}")
    found = {_normal(path.name.split("-")[0]): path for path in out.glob("*.whl")}
    return {name_of(package): found[_normal(name_of(package))] for package in packages}


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
