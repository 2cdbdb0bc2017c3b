"""Gradescope's autograder archive: one assignment, its tests, and what grades it.

It holds hidden tests, answers and the secret that seeds follow from: it is for Gradescope alone.
"""

import os
import re
import secrets
import subprocess
import zipfile
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

from robust_slam_autograder import layout
from robust_slam_autograder.ci.gradescope import LABELS_NAME, SEED_NAME, TREE_NAME
from robust_slam_autograder.ci.workflows import quoted, substitute, template
from robust_slam_autograder.errors import WrongUse
from robust_slam_autograder.grading import durable
from robust_slam_autograder.publishing.course import COURSE_NAME, Course
from robust_slam_autograder.publishing.files import tracked
from robust_slam_autograder.reading import assignment as assignments

PROGRAMS = ("setup.sh", "run_autograder")
LOCK_NAME = "requirements.lock"
_PINNED = re.compile(r"^[A-Za-z0-9][\w.-]*==[^\\\n]*", re.MULTILINE)


def write(course: Course, assignment: str, archive: Path, labels: Path) -> None:
    """Write the archive of an assignment, readable by its owner only; it replaces another.

    It holds the assignment's labels where ``autograder misconceptions`` has written some.

    Raises:
        WrongUse: the course does not say what to install, or is in no repository.
    """
    packages = course.packages(assignment)
    if not packages:
        raise WrongUse(
            f"{course.tree / COURSE_NAME} has no [install.assignments]: it says what to install."
        )
    entries = {
        **dict(_programs(packages)),
        SEED_NAME: f"{secrets.randbits(63)}\n".encode(),
        "constraints.txt": _constraints(course.root).encode(),
        **_sources(course, assignment),
    }
    known = labels / f"{assignment}.json"
    if known.is_file():
        entries[f"{LABELS_NAME}/{known.name}"] = known.read_bytes()
    part = durable.part_of(archive)
    part.unlink(missing_ok=True)
    part.touch(mode=0o600)
    with zipfile.ZipFile(part, "w", zipfile.ZIP_DEFLATED) as made:
        for name, data in entries.items():
            entry = zipfile.ZipInfo(name)
            entry.external_attr = (0o100755 if name in PROGRAMS else 0o100600) << 16
            made.writestr(entry, data, zipfile.ZIP_DEFLATED)
    os.replace(part, archive)


def refuse_in_sight(archives: Iterable[Path]) -> None:
    """Refuse places for archives where git would take them over into a repository.

    Raises:
        WrongUse: names a file that git tracks or does not ignore.
    """
    for archive in archives:
        folder = next(one for one in archive.absolute().parents if one.is_dir())
        command = ["git", "-C", str(folder), "check-ignore", "--quiet", str(archive.absolute())]
        done = subprocess.run(command, capture_output=True, env={**os.environ, "LC_ALL": "C"})
        if done.returncode and b"not a git repository" not in done.stderr:
            raise WrongUse(
                f"{archive} would hold hidden tests, answers and the seed, and git does not "
                f"ignore it there: leave out --out, write {layout.CLASS}/ into .gitignore, or "
                "name a folder outside of the repository."
            )


def _programs(packages: Mapping[str, str]) -> Iterator[tuple[str, bytes]]:
    extras = {name: name[name.find("[") :] if "[" in name else "" for name in packages}
    words = [f'"$source"/{quoted(folder + extras[name])}' for name, folder in packages.items()]
    values = {"INSTALL": " \\\n    ".join(words)}
    for name in PROGRAMS:
        yield name, substitute(template(f"gradescope/{name}"), values).encode()


def _constraints(root: Path) -> str:
    """Return versions as the course pins them, so that marks there are those from here."""
    lock = root / LOCK_NAME
    text = lock.read_text(encoding="utf-8") if lock.is_file() else ""
    return "".join(f"{line.strip()}\n" for line in _PINNED.findall(text))


def _sources(course: Course, name: str) -> dict[str, bytes]:
    """Return the packages as git tracks them, and the assignment, by their places there."""
    folders = tuple(f"{folder}/" for folder in course.packages().values())
    chosen = [path for path in tracked(course.root) if path.startswith(folders)]
    tests = assignments.notebook_path(course.tree / name)
    found = {path: course.root / path for path in chosen}
    for path in (tests, tests.with_name(assignments.CONFIG_NAME)):
        if path.is_file():
            found[f"{TREE_NAME}/{name}/{path.name}"] = path
    return {place: path.read_bytes() for place, path in found.items()}
