"""A roster, the CSV that Canvas or Moodle exports of a gradebook, and whose line is whose.

It is read strictly. A mark that goes to the wrong person is worse than none, so whatever
is doubtful stops the export, with the file and the line.
"""

import codecs
import csv
import io
import re
import unicodedata
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from robust_slam_autograder.errors import WrongUse
from robust_slam_autograder.lms.marks import Column, Ledger, Mark
from robust_slam_autograder.markup import one_line

_MARKS = (",", ";", "\t")
"""The systems write a comma, or a semicolon where the comma is in numbers."""
_SEP = re.compile(r'"?sep=([,;\t|])"?[,;\t| ]*(\r\n|\r|\n)', re.IGNORECASE)
"""Excel's own first line, which says the delimiter."""
_REWRITTEN = re.compile(r"""^[='"]*0*|(\.0+)?"?$""")
"""What spreadsheets take off a number, or add to it."""
MAX_BYTES = 20 * 2**20


@dataclass(frozen=True)
class Row:
    """One line of the file."""

    line: int
    """Where it begins, counted from 1."""
    cells: tuple[str, ...]


@dataclass(frozen=True)
class Roster:
    """A roster: its header and every row below."""

    path: Path
    header: tuple[str, ...]
    rows: tuple[Row, ...]

    def column(self, name: str, option: str) -> int:
        """Return where the column stands that an option names, spaces around its header aside.

        Raises:
            WrongUse: there is none.
        """
        if name.strip() not in self.header:
            why = f"{self.path}:1: there is no column {name!r} for {option}"
            raise WrongUse(f"{why}; there are {self.columns}.")
        return self.header.index(name.strip())

    @property
    def columns(self) -> str:
        """Return what its columns are called, for a message."""
        return ", ".join(filter(None, self.header))


def key(text: str) -> str:
    """Return what two spellings of a name have in common: é is one letter, or e with an accent."""
    return unicodedata.normalize("NFC", text.strip())


def read(path: Path) -> Roster:
    """Read a roster: UTF-8, or UTF-16 with its BOM, any line ends, one of three delimiters.

    Raises:
        WrongUse: names the file and the line where it cannot be read as a table.
    """
    delimiter, text = parted(read_text(path))
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=delimiter, strict=True)
    found, begins = [], 1
    try:
        for cells in reader:
            found.append(Row(begins, tuple(cells)))
            begins = reader.line_num + 1
    except csv.Error as error:
        raise WrongUse(f"{path}:{begins}: this is not CSV ({error}).") from error
    rows = [row for row in found if any(map(str.strip, row.cells))]
    if len(rows) < 2:
        raise WrongUse(f"{path}:1: a header and students are wanted: export the gradebook again.")
    header = tuple(cell.strip() for cell in rows[0].cells)
    for name in filter(None, header):
        if header.count(name) > 1:
            raise WrongUse(f"{path}:{rows[0].line}: two columns are named {name!r}.")
    for row in rows[1:]:
        if len(row.cells) != len(header):
            raise WrongUse(
                f"{path}:{row.line}: {len(row.cells)} cells under {len(header)} columns: "
                "export the gradebook again, or correct the line."
            )
    return Roster(path, header, tuple(rows[1:]))


def read_text(path: Path) -> str:
    """Read a CSV file's text, without its BOM.

    Raises:
        WrongUse: it cannot be read, is too large, or is in another encoding.
    """
    try:
        with open(path, "rb") as file:
            data = file.read(MAX_BYTES + 1)
    except OSError as error:
        raise WrongUse(f"{path} cannot be read ({error.strerror}): correct the path.") from error
    if len(data) > MAX_BYTES:
        raise WrongUse(f"{path} is larger than {MAX_BYTES // 2**20} MiB: it is no roster.")
    wide = data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    data = data.removeprefix(codecs.BOM_UTF8)
    try:
        text = data.decode("utf-16" if wide else "utf-8")
        bad = text.find("\0")  # UTF-16 without its BOM, or no text
    except UnicodeDecodeError as error:
        bad = error.start
    if bad >= 0:
        line = len((data[:bad] + b"?").splitlines())
        raise WrongUse(f"{path}:{line}: this is not UTF-8: save it as CSV UTF-8.")
    return text


def parted(text: str) -> tuple[str, str]:
    """Return the delimiter, and the text without the line that says it.

    Where none does, it is the mark that parts the header into most columns.
    """
    if said := _SEP.match(text):
        return said[1], "\n" + text[said.end() :]
    first = [line[: csv.field_size_limit()] for line in text.lstrip().splitlines()[:1]]
    return max(_MARKS, key=lambda mark: len(next(csv.reader(first, delimiter=mark), []))), text


def by_key(roster: Roster, students: tuple[Row, ...], column: int) -> dict[str, Row]:
    """Return students by what the matched column says of them; who has nothing there is left out.

    Raises:
        WrongUse: two lines say the same, and no one knows whose the mark would be.
    """
    found: dict[str, Row] = {}
    for row in students:
        name = key(row.cells[column])
        if name in found:
            raise WrongUse(
                f"{roster.path}:{row.line}: {name!r} stands in line {found[name].line} already "
                f"(column {roster.header[column]!r}): remove one of them."
            )
        if name:
            found[name] = row
    return found


class Matching:
    """Submissions and the roster, side by side.

    Attributes:
        ledger: the marks.
        students: the roster's lines from ``by_key``, by the name that submissions are matched by.
        left_out: notebooks that may be anybody's, with the assignment, or nothing, of each.
        owners: by line the student, as the submissions' folder is named, where there is one.
        strangers: students who have handed something in and are not on the roster.
        doubled: by line students whose names are equal after Unicode normalisation: they have no
            mark.
    """

    def __init__(
        self, ledger: Ledger, students: Mapping[str, Row], left_out: Mapping[str, str]
    ) -> None:
        self.ledger, self.students, self.left_out = ledger, students, left_out
        named = [student for column in ledger.columns for student in column.marks]
        every = dict.fromkeys([*named, *sorted(student for student, _ in ledger.lost)])
        self.strangers = tuple(student for student in every if key(student) not in students)
        found: dict[int, list[str]] = {}
        for student in (one for one in every if one not in self.strangers):
            found.setdefault(students[key(student)].line, []).append(student)
        self.owners = {line: same[0] for line, same in found.items() if len(same) == 1}
        self.doubled = {line: tuple(same) for line, same in found.items() if len(same) > 1}

    @property
    def likely(self) -> str:
        """Say which strangers are on the roster as a spreadsheet writes them; empty for none."""
        kept = {_number(name): name for name in self.students}
        near = {name: kept[_number(name)] for name in self.strangers if _number(name) in kept}
        if not near:
            return ""
        pairs = ", ".join(f"{one_line(name)} as {one_line(on)}" for name, on in near.items())
        cause = "likely on the roster, where a spreadsheet took off zeros, or capitals differ"
        return f"{cause}: {pairs}. Export it again, and do not save it from a spreadsheet"

    def mark(self, row: Row, column: Column) -> Mark | None:
        """Return a line's mark in an assignment; None where there is none."""
        return column.marks.get(self.owners.get(row.line, ""))

    def cell(self, row: Row, column: Column, *, zero: bool) -> str | None:
        """Return what a line says of an assignment: a mark, with ``zero`` 0, or None for nothing.

        No one has a 0 while there is work that may be theirs.
        """
        if mark := self.mark(row, column):
            return str(mark.after)
        return "0" if zero and not self.unclear(column) and self._is_absent(row, column) else None

    def unclear(self, column: Column) -> str:
        """Say what work may be that of those who have none; empty for no one's."""
        if self.strangers:
            return "those who are not on the roster may be among them"
        lost = [one_line(one) for one, of in self.left_out.items() if of in ("", column.name)]
        return f"what collect left out may be theirs ({', '.join(lost)})" if lost else ""

    def _is_absent(self, row: Row, column: Column) -> bool:
        """Whether no work is known, and none whose mark is not known."""
        lost = (self.owners.get(row.line), column.name) in self.ledger.lost
        return not (self.mark(row, column) or lost or row.line in self.doubled)

    def absent(self, column: Column) -> list[str]:
        """Return who is on the roster and handed in nothing for an assignment."""
        return [name for name, row in self.students.items() if self._is_absent(row, column)]


def _number(name: str) -> str:
    """Return what is left of an ID in a spreadsheet that takes it for a number, or a word."""
    return _REWRITTEN.sub("", key(name).casefold())
