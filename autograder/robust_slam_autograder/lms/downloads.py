"""The zip of all submissions that Canvas or Moodle hands out: whose notebook each file in it is.

A file is a student's where the roster has one line for the number or the name in the file's own
name, and no other. What is doubtful is left out and told, because a notebook in the wrong folder
is a mark for the wrong person.

Source: Canvas, lib/content_zipper.rb; Moodle, public/mod/assign/classes/downloader.php, and of
what it drops from a name public/lib/classes/param.php.
"""

import io
import json
import re
import stat
import zipfile
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path, PurePosixPath

from robust_slam_autograder.errors import WrongUse
from robust_slam_autograder.grading import durable
from robust_slam_autograder.lms import roster
from robust_slam_autograder.lms.roster import Roster, Row
from robust_slam_autograder.markup import log_line
from robust_slam_autograder.reading import submission
from robust_slam_autograder.reading.notebook import MAX_BYTES

MAX_FILES = 20_000
MAX_TOTAL_BYTES = 4 * 2**30
"""Of all notebooks of a zip when they are unpacked."""
_HEADS = re.compile(rb"(PK(?:\x01\x02.{5}|\x03\x04.{3}))(.)", re.DOTALL)
"""An entry in the index or before its file, up to the byte that says so."""
_NOT_SENT = re.compile(
    r"(^|[/\\])(__MACOSX[/\\]|(\._[^/\\]*|\.DS_Store|Thumbs\.db|desktop\.ini)?$)"
)
"""Folders, and what macOS and Windows put beside files."""
_CANVAS = re.compile(r"_(LATE_)?(\d+)_\d+_(?=.)")
_MOODLE = re.compile(r"(?:^|/)([^/_]+)_(\d+)_assignsubmission_file(?:_?/(?:.*/)?|_)([^/]+)$")
_DROPPED = re.compile(r"[\x00-\x1f\x7f-\x9f&<>\"`|':\\/]")
"""What Moodle's ``PARAM_FILE`` takes out of a name."""
_MOODLE_NAMES = (
    *(("Full name",), ("First name", "Last name"), ("First name", "Surname")),
    *(("Vollständiger Name",), ("Vorname", "Nachname")),
)
_UNLIKE = "has another name, or number beside it, than the roster's line"
_NAMED = (
    "say with --name COLUMN … how the zip's names are made up, or take Moodle's grading worksheet "
    "as the roster, which has the numbers"
)
LEFT_OUT = ".left-out.json"
"""In the submissions' folder: notebooks that may be anybody's, with the assignment or nothing."""
_AGAIN = re.compile(r"(-\d+| ?\(\d+\))$")
"""What Canvas and browsers add to a name that they have had before."""
Keys = Callable[[Row], Iterable[str]]
"""What may stand in the zip for a line of the roster; behind `?` what may be another's too."""
Sent = tuple[tuple[str, ...], str, bool]
"""What may tell on the roster whose a file is, the student's own name of it, and if it is late."""


def canvas_sent(path: str) -> list[Sent]:
    """Read ``smithjohn_LATE_12345_678_02-four-costs.ipynb``: a name, an ID, an attachment.

    A name may hold numbers and bars too, so every way to read it is given.
    """
    name = PurePosixPath(path).name
    ways = filter(None, (_CANVAS.match(name, start) for start in range(len(name))))
    return [((way[2],), name[way.end() :], bool(way[1])) for way in ways]


def canvas_keys(people: Roster, _: Sequence[str]) -> Keys:
    """Return what reads the number that Canvas has for a student; names are not in its zip."""
    column = people.column("ID", "--format canvas")
    return lambda row: [row.cells[column].strip()]


def moodle_sent(path: str) -> list[Sent]:
    """Read ``Jane Smith_12345_assignsubmission_file/02-four-costs.ipynb``, in whatever folder.

    Before Moodle 4.1 the folder's name ended in a bar. There may be more folders in it, or, as
    the teacher chose, none: then a bar is before the file's own name.
    The number is the participant's in this assignment; only Moodle's grading worksheet has it.
    A group's name and a dash may be before the name, and a comma behind the last name.
    """
    found = _MOODLE.search(path.replace("\\", "/"))
    if found is None or path.index("_assignsubmission_file") != found.end(2):
        return []  # or it is in what looks like another one's
    said, number = found[1], f"#{found[2]}"
    names = [_in_zip(said), _in_zip(*said.partition(",")[::-2])]
    every = [*names, *(_in_zip(said[at.end() :]) for at in re.finditer("-", said))]
    sure = (f"{number} ", *(f"{number} {name}" for name in every), *names)
    return [((*sure, f"?{number}", *(f"?{name}" for name in every)), found[3], False)]


def moodle_keys(people: Roster, names: Sequence[str]) -> Keys:
    """Return what reads a participant's number and the full name, as they are in the zip.

    The name is made up of the columns of ``names``, or of the usual ones. In another order it
    may be another's, and so may a number beside another name.

    Raises:
        WrongUse: there is no such column.
    """
    usual = [each for each in _MOODLE_NAMES if set(each) <= set(people.header)]
    identifier = people.header.index("Identifier") if "Identifier" in people.header else None
    if not (names or usual) and identifier is None:
        raise WrongUse(
            f"{people.path}:1: no column has the names of Moodle's zip. There are "
            f"{people.columns}; wanted are First name and Last name, or Full name: "
            "say with --name COLUMN … which they are here, in the zip's order."
        )
    columns = [
        [people.column(name, "--name") for name in each] for each in ([names] if names else usual)
    ]

    def keys(row: Row) -> list[str]:
        full = [_in_zip(*(row.cells[n] for n in each)) for each in columns]
        turned = [_in_zip(*(row.cells[n] for n in each[::-1])) for each in columns]
        word, _, number = ("" if identifier is None else row.cells[identifier]).rpartition(" ")
        # Where names are hidden, it is the word for a participant that stands there.
        hidden = [_in_zip(word), _in_zip(word, number)] if columns else [""]
        sure = [f"#{number} {name}" for name in (*full, *hidden)] if number else full
        doubtful = filter(None, [number and f"#{number}", *full, *turned])
        return [*filter(None, sure), *(f"?{key}" for key in doubtful)]

    return keys


def _in_zip(*names: str) -> str:
    plain = _DROPPED.sub("", re.sub("[_,]", " ", " ".join(names)))
    return roster.key(" ".join(plain.split()))


@dataclass(frozen=True)
class Notebook:
    """One student's notebook, as the zip has it."""

    student: str
    assignment: str
    entry: str
    """Its path within the zip."""
    at: datetime | None
    """The time that the zip gives it, which has no zone; None where it gives none."""
    late: bool


class Archive:
    """A zip of submissions, looked at before anything is read from it."""

    def __init__(self, path: Path) -> None:
        """Open it.

        Raises:
            WrongUse: it is no zip, or has paths that lead out of it, links, far too many files,
                or notebooks that are far too large together.
        """
        try:
            self._zip = _opened(path)
            self.at = datetime.fromtimestamp(path.stat().st_mtime)
        except Exception as error:  # each damage has a type of its own
            raise WrongUse(
                f"{path} is no zip, or cannot be read ({getattr(error, 'strerror', error)}): "
                "correct the path, or download it again."
            ) from error
        self.infos: dict[str, list[zipfile.ZipInfo]] = {}
        for one in self._zip.infolist():
            if not _NOT_SENT.search(name := _name(one)):
                self.infos.setdefault(name, []).append(one)
        if problem := self._problem():
            raise WrongUse(f"{path} {problem}: no system hands out such a zip. Nothing was read.")

    def _problem(self) -> str:
        infos = self._zip.infolist()
        if len(infos) > MAX_FILES:
            return f"holds more than {MAX_FILES} files"
        for one in infos:
            parts = re.split(r"[/\\]", one.filename)
            if ".." in parts or not parts[0] or re.fullmatch("[A-Za-z]:", parts[0]):
                return f"has a path that leads out of it, {log_line(one.filename)}"
            if stat.S_ISLNK(one.external_attr >> 16):
                return f"holds a link, {log_line(one.filename)}"
        notebooks = [one for one in infos if submission.is_notebook(one.filename)]
        if sum(min(one.file_size, MAX_BYTES) for one in notebooks) > MAX_TOTAL_BYTES:
            return f"is larger than {MAX_TOTAL_BYTES // 2**30} GiB when it is unpacked"
        return ""

    def read(self, entry: str) -> bytes:
        """Read a file, and never more of it than a notebook may have.

        Raises:
            ValueError: it is larger, damaged, locked or one of two of its name, as it says.
        """
        info, *others = self.infos[entry]
        if others:
            raise ValueError("stands in the zip twice: leave one of them in it")
        try:
            with self._zip.open(info) as file:
                data = file.read(MAX_BYTES + 1)
        except Exception as error:  # each damage has a type of its own
            why = str(error) or type(error).__name__
            raise ValueError(f"cannot be read from the zip ({why})") from error
        if len(data) > MAX_BYTES:
            raise ValueError(f"is larger than {MAX_BYTES // 2**20} MiB")
        return data

    def time(self, entry: str) -> datetime | None:
        """Return when a file was written; None where the zip does not say."""
        said = self.infos[entry][0].date_time
        try:
            return datetime(*said) if said > (1980, 1, 1, 0, 0, 0) else None
        except ValueError:
            return None


def _opened(path: Path) -> zipfile.ZipFile:
    try:
        return zipfile.ZipFile(path)
    except (UnicodeDecodeError, zipfile.BadZipFile):
        # A name says that it is UTF-8, and is not; which error that is hangs on the Python.
        data = re.sub(_HEADS, lambda at: at[1] + bytes([at[2][0] & 0xF7]), path.read_bytes())
        return zipfile.ZipFile(io.BytesIO(data))


def _name(info: zipfile.ZipInfo) -> str:
    """Return an entry's name, which macOS writes as UTF-8 without saying so."""
    try:
        says_utf8 = info.flag_bits & 0x800
        return info.filename if says_utf8 else info.filename.encode("cp437").decode()
    except UnicodeError:
        return info.filename


@dataclass(frozen=True)
class Reader:
    """Tells whose notebook a file is, and of which assignment."""

    sent: Callable[[str], Sequence[Sent]]
    """The ways to read a path within the zip."""
    owners: Mapping[str, Sequence[Row]]
    """By what a name may hold the lines of the roster that have it."""
    match: int
    """The roster's column that holds the names of the submissions' folders."""
    notebooks: Mapping[str, str]
    """By name of a notebook, without its ending, the assignment."""
    assignment: str | None = None
    """What every notebook belongs to whose name says none."""

    def read(self, archive: Archive) -> tuple[list[Notebook], dict[str, str]]:
        """Return the notebooks that are somebody's without a doubt, and why each other is not."""
        found: list[Notebook] = []
        left: dict[str, str] = {}
        for entry in archive.infos:
            try:
                found.append(self._read(entry, archive.time(entry)))
            except ValueError as error:
                left[entry] = str(error)
        # Some disks do not tell capitals apart.
        keys = [(one.student.casefold(), one.assignment) for one in found]
        count = Counter(keys)
        for one, key in zip(found, keys, strict=True):
            if count[key] > 1:
                several = f"is one of several notebooks of {one.student} for {one.assignment}"
                left[one.entry] = f"{several}: leave one of them in the zip"
        return [one for one in found if one.entry not in left], left

    def _read(self, entry: str, at: datetime | None) -> Notebook:
        if not submission.is_notebook(entry):
            raise ValueError("is no notebook")
        if not (ways := self.sent(entry)):
            raise ValueError("has not the name that this system gives to submissions")
        found: dict[Row, Sent] = {}
        doubtful = False
        for way in reversed(ways):
            # Of a way its first key that the roster knows.
            known = next((key for key in way[0] if key in self.owners), "")
            doubtful |= known.startswith("?")
            found |= dict.fromkeys(self.owners.get(known, ()), way)
        if not found:
            raise ValueError("is of no one on the roster")
        names = [roster.key(row.cells[self.match]) for row in found]
        pairs = zip(found, names, strict=True)
        lines = " and ".join(f"{row.line} ({name})" for row, name in pairs)
        if len(names) > 1:
            raise ValueError(f"may be of several people on the roster, lines {lines}")
        if doubtful:
            raise ValueError(f"{_UNLIKE} {lines}: {_NAMED}")
        if not submission.is_student(names[0]) or names[0] in self.notebooks.values():
            raise ValueError(f"is of {names[0]!r}, which cannot name a folder: see --match")
        ((_, file, late),) = found.values()
        return Notebook(names[0], self._assignment(file), entry, at, late)

    def _assignment(self, file: str) -> str:
        stem = PurePosixPath(file).stem
        again = self.notebooks.get(_AGAIN.sub("", stem), self.assignment)
        name = self.notebooks.get(stem, again)
        if name is None:
            raise ValueError("does not say its assignment: add --assignment NAME")
        if self.assignment not in (None, name):
            raise ValueError(f"belongs to {name}, not to {self.assignment}")
        return name


def left_out(folder: Path) -> dict[str, str]:
    """Return by entry of a zip the assignment of notebooks that are in no student's folder."""
    path = folder / LEFT_OUT
    try:
        found: dict[str, str] = json.loads(path.read_text("utf-8")) if path.exists() else {}
        return dict(found.items())
    except (OSError, ValueError, AttributeError) as error:
        raise WrongUse(f"{path} cannot be read: delete it, and collect again.") from error


def remember(folder: Path, archive: Archive, lost: Iterable[str], about: Collection[str]) -> None:
    """Keep what was left out of a zip about assignments, beside that of others, for the export."""
    before = {one: of for one, of in left_out(folder).items() if one not in archive.infos}
    now = before | dict.fromkeys(lost, *about if len(about) == 1 else [""])
    if now:
        durable.write(folder / LEFT_OUT, json.dumps(now, indent=1))
    else:
        (folder / LEFT_OUT).unlink(missing_ok=True)


def owners(keys: Keys, students: Iterable[Row]) -> dict[str, list[Row]]:
    """Return by what a file's name may hold the lines of the roster that have it."""
    found: dict[str, list[Row]] = {}
    for row in students:
        for key in dict.fromkeys(keys(row)):
            found.setdefault(key, []).append(row)
    return found
