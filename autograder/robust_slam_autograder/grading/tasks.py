"""Submissions to grade: each is read once, with the digest of all that its result depends on."""

from __future__ import annotations

import contextlib
import functools
import hashlib
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import robust_slam_autograder
from robust_slam_autograder.errors import Refused
from robust_slam_autograder.executor.seeds import SHARED_TOWN
from robust_slam_autograder.grading.marked import Marked
from robust_slam_autograder.reading import notebook, submission
from robust_slam_autograder.reading.assignment import CONFIG_NAME, Assignment
from robust_slam_autograder.reading.notebook import Notebook
from robust_slam_autograder.sandbox import Sandbox, packages


@dataclass(frozen=True)
class Handed:
    """What a submission holds, read once: where it is does not matter any more."""

    name: str = ""
    """The notebook's, with its ending."""
    data: bytes = b""
    notes: tuple[str, ...] = ()
    """Sentences on what was found in an unusual place."""
    refusal: str = ""
    """Why it could not be read; empty where it could."""

    def cells(self) -> Notebook:
        """Return the notebook's cells.

        Raises:
            Refused: it could not be read, or is no notebook.
        """
        if self.refusal:
            raise Refused(self.refusal)
        return notebook.parse(self.data, notebook.shown(self.name))


@dataclass(frozen=True)
class Job:
    """One submission to grade."""

    student: str
    assignment: Assignment
    tests: Path
    """The instructor's notebook."""
    path: Path
    """The submission's notebook, or its folder ``submitted/<student>/<assignment>/``."""
    handed: Handed | None = None
    """What was read there already; None where it is read when its turn comes."""

    @property
    def key(self) -> str:
        """Name of the submission in the batch."""
        return f"{self.student}/{self.assignment.name}"


@dataclass(frozen=True)
class Task:
    """A submission as it was read, and the digest of all that its result depends on."""

    job: Job
    handed: Handed
    fingerprint: str
    seen: Marked | None = None
    """What its visible pass came to; None before that."""
    town: int = SHARED_TOWN
    """The number of the student's data."""


class Fingerprints:
    """Digests of all that a submission's result depends on."""

    def __init__(
        self, seed: int, wall: Sandbox, town: Callable[[str], int] = lambda student: SHARED_TOWN
    ) -> None:
        self._common = f"{seed} {wall.name} {code_digest()}"
        self._town = town
        self._tests: dict[Path, bytes] = {}

    def of(self, job: Job) -> str:
        """Return the digest of one submission, as it is on the disk now."""
        return self.task(job).fingerprint

    def task(self, job: Job) -> Task:
        """Read a submission, and take the digest of what was read."""
        handed = read(job)
        town = self._town(job.student)
        return Task(job, handed, self._digest(job, handed, town), town=town)

    def _digest(self, job: Job, handed: Handed, town: int) -> str:
        if job.tests not in self._tests:
            self._tests[job.tests] = self._digest_of_tests(job.tests)
        digest = hashlib.sha256(self._tests[job.tests])
        digest.update(f"{town} {handed.refusal}".encode())
        digest.update(handed.name.encode(errors="surrogateescape") + handed.data)
        return digest.hexdigest()

    def _digest_of_tests(self, tests: Path) -> bytes:
        digest = hashlib.sha256(self._common.encode())
        config = tests.parent / CONFIG_NAME
        for path in [tests, *([config] if config.is_file() else [])]:
            digest.update(path.read_bytes())
        return digest.digest()


@functools.cache
def code_digest() -> str:
    """Return the digest of the interpreter and of all code that tests and grader may import."""
    # Their folders are named for name and version; to read the metadata takes far longer.
    folders = [Path(entry) for entry in sys.path if entry and not _in_a_package(Path(entry))]
    installed = sorted({path.name for folder in folders for path in folder.glob("*.dist-info")})
    digest = hashlib.sha256(repr([sys.version, installed]).encode())
    for folder in dict.fromkeys(
        [Path(robust_slam_autograder.__file__).parent, *packages.packages_in_place()]
    ):
        for path in sorted(folder.rglob("*.py")):
            digest.update(path.read_bytes())
    return digest.hexdigest()


def _in_a_package(folder: Path) -> bool:
    """Tell whether it is in an installed package: setuptools, once imported, enters its own."""
    return any(parent.name in ("site-packages", "dist-packages") for parent in folder.parents)


def locate(job: Job) -> tuple[Path, tuple[str, ...]]:
    """Return the submission's notebook, with a note where it has an unusual name.

    Raises:
        Refused: there is none, or the path leads through a link.
    """
    for given in (job.path.parent.name, job.path.stem):
        if job.student == submission.stand_in(given):
            raise Refused(f"{notebook.shown(given)!r} is no name for a student: rename it.")
    try:
        return _located(job)
    except OSError as error:
        name = notebook.shown(job.path.name)
        raise Refused(f"{name} cannot be read ({error.strerror}): make it readable.") from error


def _located(job: Job) -> tuple[Path, tuple[str, ...]]:
    with contextlib.suppress(FileNotFoundError, NotADirectoryError):
        job.path.lstat()  # says why it cannot be looked at, as is_dir does before Python 3.14
    if job.path.is_symlink():
        raise Refused(f"{notebook.shown(job.path.name)} is a link: hand in the notebook itself.")
    if not job.path.is_dir():
        return job.path, ()
    if job.path.parent.is_symlink():
        raise Refused(f"The student's folder {notebook.shown(job.student)} is a link.")
    return submission.notebook_in(job.path, job.assignment.notebook)


def read(job: Job) -> Handed:
    """Read what is handed in, or say why it cannot be."""
    if job.handed is not None:
        return job.handed
    try:
        path, notes = locate(job)
        return Handed(path.name, notebook.read_bytes(path), notes)
    except Refused as error:
        return Handed(refusal=str(error))
