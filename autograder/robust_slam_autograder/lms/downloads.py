"""The zip of all submissions that Canvas or Moodle hands out: whose notebook each file in it is.

A file is a student's where the roster has one line for the number or the name in the file's own
name, and no other. What is doubtful is left out and told, because a notebook in the wrong folder
is a mark for the wrong person.

Source: Canvas, lib/content_zipper.rb; Moodle, mod/assign/locallib.php.
"""

from __future__ import annotations

import re
import stat
import zipfile
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path, PurePosixPath

from robust_slam_autograder.errors import WrongUse
from robust_slam_autograder.lms import roster
from robust_slam_autograder.lms.roster import Roster, Row
from robust_slam_autograder.markup import log_line
from robust_slam_autograder.reading import submission
from robust_slam_autograder.reading.notebook import MAX_BYTES

NOTEBOOK = ".ipynb"
MAX_FILES = 20_000
MAX_TOTAL_BYTES = 4 * 2**30
"""Of all files of a zip when they are unpacked."""
_CANVAS = re.compile(r"_(LATE_)?(\d+)_\d+_(?=[^_])")
_MOODLE = re.compile(r"(.+)_(\d+)_assignsubmission_file_/?([^/]+)")
_AGAIN = re.compile(r"(-\d+| ?\(\d+\))$")
"""What Canvas and browsers add to a name that they have had before."""


@dataclass(frozen=True)
class Sent:
    """A file as a system names it."""

    keys: tuple[str, ...]
    """What may tell on the roster whose it is."""
    file: str
    """Its own name, as the student had it."""
    late: bool = False
    """Whether the system says that it came late."""


def canvas_sent(path: str) -> list[Sent]:
    """Read ``smithjohn_LATE_12345_678_02-four-costs.ipynb``: a name, an ID, an attachment.

    A name may hold numbers and bars too, so every way to read it is given.
    """
    name = PurePosixPath(path).name
    return [
        Sent((found[2],), name[found.end() :], late=bool(found[1]))
        for start in range(len(name))
        if (found := _CANVAS.match(name, start))
    ]


def canvas_keys(people: Roster, row: Row) -> Iterator[str]:
    """Yield the number that Canvas has for a student."""
    if "ID" in people.header:
        yield row.cells[people.header.index("ID")].strip()


def moodle_sent(path: str) -> list[Sent]:
    """Read ``Jane Smith_12345_assignsubmission_file_/02-four-costs.ipynb``, with or without a bar.

    The number is the participant's in this assignment; only Moodle's grading worksheet has it.
    """
    found = _MOODLE.fullmatch(path)
    return [] if found is None else [Sent((f"#{found[2]}", _one_space(found[1])), found[3])]


def moodle_keys(people: Roster, row: Row) -> Iterator[str]:
    """Yield a participant's number, and the full name."""
    cells = dict(zip(people.header, row.cells, strict=True))
    number = cells.get("Identifier", "").rpartition(" ")[2]
    if number.isdecimal():
        yield f"#{number}"
    last = cells.get("Last name", cells.get("Surname", ""))
    for name in (cells.get("Full name", ""), f"{cells.get('First name', '')} {last}"):
        if _one_space(name):
            yield _one_space(name)


def _one_space(name: str) -> str:
    return roster.key(" ".join(name.split()))


@dataclass(frozen=True)
class Notebook:
    """One student's notebook, as the zip has it."""

    student: str
    assignment: str
    entry: str
    """Its path within the zip."""
    at: datetime
    """The time that the zip gives it, which has no zone."""
    late: bool


@dataclass(frozen=True)
class LeftOut:
    """A file that is not taken, with the reason."""

    entry: str
    why: str


class Archive:
    """A zip of submissions, looked at before anything is read from it."""

    def __init__(self, path: Path) -> None:
        """Open it.

        Raises:
            WrongUse: it is no zip, or none that a system hands out: with paths that lead out of
                it, links, far too many files, or far too large when it is unpacked.
        """
        self.path = path
        try:
            self._zip = zipfile.ZipFile(path)
        except OSError as error:
            raise WrongUse(f"{path} cannot be read ({error.strerror}): name the zip.") from error
        except (zipfile.BadZipFile, ValueError, NotImplementedError) as error:
            raise WrongUse(f"{path} is no zip ({error}): download it again.") from error
        self.infos = {one.filename: one for one in self._zip.infolist() if not one.is_dir()}
        if problem := self._problem():
            raise WrongUse(f"{path} {problem}: no system hands out such a zip. Nothing was read.")

    def _problem(self) -> str:
        infos = self._zip.infolist()
        if len(infos) > MAX_FILES:
            return f"holds more than {MAX_FILES} files"
        if len({one.filename for one in infos}) < len(infos):
            return "holds two files of one name"
        for one in infos:
            parts = re.split(r"[/\\]", one.filename)
            if ".." in parts or not parts[0] or ":" in parts[0] or "\\" in one.filename:
                return f"has a path that leads out of it, {log_line(one.filename)}"
            if stat.S_ISLNK(one.external_attr >> 16):
                return f"holds a link, {log_line(one.filename)}"
        if sum(one.file_size for one in infos) > MAX_TOTAL_BYTES:
            return f"is larger than {MAX_TOTAL_BYTES // 2**30} GiB when it is unpacked"
        return ""

    def read(self, entry: str) -> bytes:
        """Read a file, and never more of it than a notebook may have.

        Raises:
            ValueError: it is larger, damaged, or locked with a password; the words say which.
        """
        try:
            with self._zip.open(self.infos[entry]) as file:
                data = file.read(MAX_BYTES + 1)
        except (zipfile.BadZipFile, EOFError, RuntimeError, NotImplementedError) as error:
            raise ValueError(f"cannot be read from the zip ({error})") from error
        if len(data) > MAX_BYTES:
            raise ValueError(f"is larger than {MAX_BYTES // 2**20} MiB")
        return data


@dataclass(frozen=True)
class Reader:
    """Tells whose notebook a file is, and of which assignment.

    Attributes:
        sent: the ways to read a path within the zip.
        owners: by what a name may hold the lines of the roster that have it.
        match: the roster's column that holds the names of the submissions' folders.
        notebooks: by name of a notebook, without its ending, the assignment.
        assignment: the one that every notebook belongs to whose name says none; None where
            names alone count.
    """

    sent: Callable[[str], Sequence[Sent]]
    owners: Mapping[str, Sequence[Row]]
    match: int
    notebooks: Mapping[str, str]
    assignment: str | None = None

    def read(self, archive: Archive) -> tuple[list[Notebook], list[LeftOut]]:
        """Return the notebooks that are somebody's without a doubt, and what is left out."""
        found: list[Notebook] = []
        left: list[LeftOut] = []
        for entry, info in archive.infos.items():
            try:
                found.append(self._read(entry, datetime(*info.date_time)))
            except ValueError as error:
                left.append(LeftOut(entry, str(error)))
        return _once(found, left)

    def _read(self, entry: str, at: datetime) -> Notebook:
        if not entry.lower().endswith(NOTEBOOK):
            raise ValueError("is no notebook")
        ways = self.sent(entry)
        if not ways:
            raise ValueError("has not the name that this system gives to submissions")
        students = [(way, self._student(way)) for way in ways]
        known = [(way, student) for way, student in students if student]
        if not known:
            raise ValueError("is of no one on the roster")
        if len({student for _, student in known}) > 1:
            raise ValueError("may be of several people on the roster")
        way, student = known[0]
        if not submission.is_student(student) or student in self.notebooks.values():
            raise ValueError(f"is of {student!r}, which cannot name a folder: see --match")
        return Notebook(student, self._assignment(way.file), entry, at, way.late)

    def _student(self, way: Sent) -> str:
        """Return whose line the first key has that the roster knows; empty where none does.

        Raises:
            ValueError: two lines have it.
        """
        for key in way.keys:
            rows = self.owners.get(key, ())
            if len(rows) > 1:
                lines = " and ".join(str(row.line) for row in rows)
                raise ValueError(f"may be of several people: lines {lines} of the roster")
            if rows:
                return roster.key(rows[0].cells[self.match])
        return ""

    def _assignment(self, file: str) -> str:
        stem = file[: -len(NOTEBOOK)]
        said = next((name for name in (stem, _AGAIN.sub("", stem)) if name in self.notebooks), "")
        name = self.notebooks.get(said, self.assignment)
        if name is None:
            raise ValueError("does not say its assignment: add --assignment NAME")
        if self.assignment not in (None, name):
            raise ValueError(f"belongs to {name}, not to {self.assignment}")
        return name


def _once(
    found: Sequence[Notebook], left: Sequence[LeftOut]
) -> tuple[list[Notebook], list[LeftOut]]:
    """Leave out all of several notebooks of one student: which one counts is not ours to say."""
    groups: dict[tuple[str, str], list[Notebook]] = {}
    for one in found:
        groups.setdefault((one.student.casefold(), one.assignment), []).append(one)
    doubled = [one for group in groups.values() if len(group) > 1 for one in group]
    why = "is one of several notebooks of {} for {}: leave one of them in the zip"
    kept = [one for one in found if one not in doubled]
    return kept, [
        *left,
        *(LeftOut(one.entry, why.format(one.student, one.assignment)) for one in doubled),
    ]


def owners(
    keys: Callable[[Roster, Row], Iterator[str]], people: Roster, students: Collection[Row]
) -> dict[str, list[Row]]:
    """Return by what a file's name may hold the lines of the roster that have it."""
    found: dict[str, list[Row]] = {}
    for row in students:
        for key in dict.fromkeys(keys(people, row)):
            found.setdefault(key, []).append(row)
    return found
