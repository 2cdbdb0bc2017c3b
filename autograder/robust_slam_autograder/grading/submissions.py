"""What is handed in, read once, with the digest of all that its result depends on."""

from __future__ import annotations

import contextlib
import functools
import hashlib
import json
import sys
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import robust_slam_autograder
from robust_slam_autograder.errors import Refused
from robust_slam_autograder.executor.seeds import SHARED_TOWN
from robust_slam_autograder.grading import results
from robust_slam_autograder.grading.results import Result
from robust_slam_autograder.reading import notebook, submission
from robust_slam_autograder.reading.assignment import CONFIG_NAME, Assignment
from robust_slam_autograder.reading.notebook import Notebook
from robust_slam_autograder.sandbox import Sandbox, packages


@dataclass(frozen=True)
class Outcome:
    """A result as far as it is known, and what the hidden pass has to know of the visible one."""

    result: Result
    doubtful: bool = False
    """Whether it ran into a limit for which a busy machine may be to blame."""
    seconds: float = 0.0
    """How much of the whole submission's limit is used up."""
    skip: tuple[int, ...] = ()
    """Cells of the student's that hung or died, by their number in the program."""

    @property
    def is_whole(self) -> bool:
        """Tell whether no hidden check could change it."""
        cases = (case for exercise in self.result.exercises for case in exercise.cases)
        return self.result.status != "graded" or not any(case.passed for case in cases)

    def as_text(self) -> str:
        """Write it down; the result as its file has it."""
        return json.dumps({**asdict(self), "result": results.as_text(self.result)})

    @classmethod
    def from_text(cls, text: str) -> Outcome:
        """Read back what ``as_text`` gave.

        Raises:
            ValueError: it is anything else.
        """
        try:
            value = json.loads(text)
            result = results.from_text(value.pop("result"))
            found: Outcome = results.made(cls, value, result=result)
        except (RecursionError, OverflowError, KeyError, TypeError, AttributeError) as error:
            raise ValueError("no pass of a grader wrote it") from error
        return found


@dataclass(frozen=True)
class Submission:
    """One student's work on one assignment: where it is, and, once it was read, what it holds."""

    student: str
    assignment: Assignment
    path: Path
    """The submission's notebook, or its folder ``submitted/<student>/<assignment>/``."""
    name: str = ""
    """The notebook's, with its ending; empty where nothing was read."""
    data: bytes = b""
    notes: tuple[str, ...] = ()
    """Sentences on what was found in an unusual place."""
    refusal: str = ""
    """Why it could not be read; empty where it could."""
    fingerprint: str = ""
    """Digest of all that its result depends on."""
    town: int = SHARED_TOWN
    """The number of the student's data."""
    seen: Outcome | None = None
    """What its visible pass came to; None before that."""

    @property
    def key(self) -> str:
        """Name of the submission in the batch."""
        return f"{self.student}/{self.assignment.name}"

    def cells(self) -> Notebook:
        """Return the notebook's cells.

        Raises:
            Refused: it could not be read, or is no notebook.
        """
        if self.refusal:
            raise Refused(self.refusal)
        return notebook.parse(self.data, notebook.shown(self.name))


class Fingerprints:
    """Digests of all that a submission's result depends on."""

    def __init__(
        self, seed: int, sandbox: Sandbox, town: Callable[[str], int] = lambda student: SHARED_TOWN
    ) -> None:
        self._common = f"{seed} {sandbox.name} {code_digest()}"
        self._town = town
        self._tests = functools.cache(self._digest_of_tests)

    def read(self, one: Submission) -> Submission:
        """Read a submission as it is on the disk now, with the digest of what was read."""
        one = replace(read(one), town=self._town(one.student))
        digest = hashlib.sha256(self._tests(one.assignment.path))
        digest.update(f"{one.town} {one.refusal}".encode())
        digest.update(one.name.encode(errors="surrogateescape") + one.data)
        return replace(one, fingerprint=digest.hexdigest())

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
    # Setuptools, once imported, enters a folder within its own package.
    around = {"site-packages", "dist-packages"}
    entries = map(Path, filter(None, sys.path))
    folders = [path for path in entries if around.isdisjoint(path.parent.parts)]
    installed = sorted({path.name for folder in folders for path in folder.glob("*.dist-info")})
    digest = hashlib.sha256(repr([sys.version, installed]).encode())
    for folder in dict.fromkeys(
        [Path(robust_slam_autograder.__file__).parent, *packages.packages_in_place()]
    ):
        for path in sorted(folder.rglob("*.py")):
            digest.update(path.read_bytes())
    return digest.hexdigest()


def locate(one: Submission) -> tuple[Path, tuple[str, ...]]:
    """Return the submission's notebook, with a note where it has an unusual name.

    Raises:
        Refused: there is none, or the path leads through a link.
    """
    for given in (one.path.parent.name, one.path.stem):
        if one.student == submission.stand_in(given):
            raise Refused(f"{notebook.shown(given)!r} is no name for a student: rename it.")
    try:
        return _located(one)
    except OSError as error:
        name = notebook.shown(one.path.name)
        raise Refused(f"{name} cannot be read ({error.strerror}): make it readable.") from error


def _located(one: Submission) -> tuple[Path, tuple[str, ...]]:
    with contextlib.suppress(FileNotFoundError, NotADirectoryError):
        one.path.lstat()  # says why it cannot be looked at, as is_dir does before Python 3.14
    if one.path.is_symlink():
        raise Refused(f"{notebook.shown(one.path.name)} is a link: hand in the notebook itself.")
    if not one.path.is_dir():
        return one.path, ()
    if one.path.parent.is_symlink():
        raise Refused(f"The student's folder {notebook.shown(one.student)} is a link.")
    return submission.notebook_in(one.path, one.assignment.notebook)


def read(one: Submission) -> Submission:
    """Read what is handed in, or say why it cannot be; what was read already stays."""
    if one.name or one.refusal:
        return one
    try:
        path, notes = locate(one)
        return replace(one, name=path.name, data=notebook.read_bytes(path), notes=notes)
    except Refused as error:
        return replace(one, refusal=str(error))
