"""What Canvas and Moodle import: a roster's people, and a column for each assignment.

Canvas's importer needs the roster's first columns up to ``Section`` as they are, then
``Title (id)`` for an assignment that it knows, and a row ``Points Possible``, which it
would take over. Moodle's needs a column that names the user, and a column for each grade
item; the instructor says on its page which is which. An empty cell empties a grade that
is there, so who has no mark keeps what the roster says.

Source: Canvas, lib/gradebook_importer.rb; Moodle, grade/import/csv/classes/load_data.php.
"""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from robust_slam_autograder.errors import WrongUse
from robust_slam_autograder.lms import downloads
from robust_slam_autograder.lms.marks import Column
from robust_slam_autograder.lms.roster import Roster, Row
from robust_slam_autograder.markup import Grade, as_cell

POINTS = "Points Possible"
_NOT_A_STUDENT = re.compile(r"\s*(Muted|Manual Posting.*)?\s*", re.IGNORECASE)
_NOT_IMPORTED = re.compile("(Current|Final) (Score|Points|Grade)|Override (Score|Grade|Status)")
_CANVAS_ID = re.compile(r"\s*\(\d+\)$")
_MOODLE_KIND = re.compile(r"\s*\(([^()]*)\)$")
_MOODLE_OTHER = ("Percentage", "Letter", "Feedback")
_MOODLE_USER = (
    *("First name", "Last name", "Surname", "Full name"),
    *("Username", "ID number", "Email address"),
)


@dataclass(frozen=True)
class Values:
    """Where the marks go."""

    matched: int
    """The roster's column that holds the names which submissions have."""
    columns: Sequence[Column]
    places: Mapping[str, int]
    """By assignment the roster's column that it has already."""
    cell: Callable[[Row, Column], str | None]
    """A student's mark; None leaves what the roster says."""


def canvas_students(roster: Roster) -> tuple[Row, ...]:
    """Return the lines that are about students."""
    _canvas_people(roster)
    return tuple(
        row
        for row in roster.rows
        if POINTS not in row.cells[0] and not all(map(_NOT_A_STUDENT.fullmatch, row.cells))
    )


def _canvas_people(roster: Roster) -> int:
    """Return how many columns are about the student."""
    header = roster.header
    if header[0] not in ("Student", "LastName") or not {"ID", "Section"} <= set(header):
        raise WrongUse(
            f"{roster.path}:1: this is no gradebook of Canvas, which begins with Student, ID and "
            "has Section: take Grades → Export, or --format moodle."
        )
    return header.index("Section") + 1


def canvas_names(header: str) -> set[str]:
    """Return what an assignment of Canvas's may be called here."""
    return {header, _CANVAS_ID.sub("", header)}


def canvas_table(roster: Roster, values: Values) -> Iterator[list[str]]:
    """Yield the lines of the file to import.

    Raises:
        WrongUse: Canvas has an assignment out of other points, or passes it over, or a student
            without an ID has a login that is guarded, by which it would not be found.
    """
    people = _canvas_people(roster)
    _refuse_other_points(roster, values)
    heads = [_head(roster, column, values) for column in values.columns]
    for head in filter(_NOT_IMPORTED.search, heads):
        raise WrongUse(
            f"Canvas passes over every column like {head!r}: rename it in Canvas first."
        )
    yield [*roster.header[:people], *heads]
    yield [f"    {POINTS}", *[""] * (people - 1), *(str(c.max_score) for c in values.columns)]
    number = roster.header.index("ID")
    for row in canvas_students(roster):
        if not row.cells[number].strip().isdecimal():
            _refuse_guarded(roster, row, number, values.matched)
        yield [*row.cells[:people], *_marks(row, values)]


def _refuse_other_points(roster: Roster, values: Values) -> None:
    known = [column for column in values.columns if column.name in values.places]
    for row in (row for row in roster.rows if POINTS in row.cells[0]):
        for column in known:
            there = row.cells[values.places[column.name]].strip()
            if there and column.max_score and _number(there) != column.max_score:
                raise WrongUse(
                    f"{roster.path}:{row.line}: Canvas has {column.name} out of {there}, its "
                    f"tests are out of {column.max_score}: set its points in Canvas to that, "
                    "and export the roster again."
                )


def _number(text: str) -> float | None:
    """Read a number as Canvas does: behind the last comma or point are the decimals."""
    *whole, last = re.split("[,.]", text)
    try:
        return float(f"{''.join(whole)}.{last}" if whole else last)
    except ValueError:
        return None


def moodle_names(header: str) -> set[str]:
    """Return what a grade item of Moodle's may be called here, of ``Assignment: Title (Real)``."""
    kind = _MOODLE_KIND.search(header)
    if kind and kind.group(1) in _MOODLE_OTHER:
        return set()
    bare = _MOODLE_KIND.sub("", header)
    return {header, bare, bare.partition(": ")[2]} - {""}


def moodle_table(roster: Roster, values: Values) -> Iterator[list[str]]:
    """Yield the lines of the file to import.

    Raises:
        WrongUse: what identifies a student is guarded, and Moodle would not find who it is.
    """
    people = [
        n for n, name in enumerate(roster.header) if name in _MOODLE_USER or n == values.matched
    ]
    yield [roster.header[n] for n in people] + [_head(roster, c, values) for c in values.columns]
    for row in roster.rows:
        _refuse_guarded(roster, row, values.matched)
        yield [*(row.cells[n] for n in people), *_marks(row, values)]


def _head(roster: Roster, column: Column, values: Values) -> str:
    place = values.places.get(column.name)
    return column.name if place is None else roster.header[place]


def _marks(row: Row, values: Values) -> Iterator[str]:
    for column in values.columns:
        mark = values.cell(row, column)
        place = values.places.get(column.name)
        yield Grade("" if place is None else row.cells[place].strip()) if mark is None else mark


def _refuse_guarded(roster: Roster, row: Row, *columns: int) -> None:
    for column in columns:
        cell = row.cells[column]
        if as_cell(cell) != cell:
            raise WrongUse(
                f"{roster.path}:{row.line}: {roster.header[column]} {cell!r} begins as a formula, "
                f"or holds what does not show; as {as_cell(cell)!r} no one is found by it."
            )


@dataclass(frozen=True)
class System:
    """A learning management system."""

    title: str
    match: str
    """The roster's column that most often holds what submissions are named for."""
    students: Callable[[Roster], tuple[Row, ...]]
    names: Callable[[str], set[str]]
    table: Callable[[Roster, Values], Iterator[list[str]]]
    sent: Callable[[str], Sequence[downloads.Sent]]
    """The ways to read a path within the zip of submissions."""
    keys: Callable[[Roster, Sequence[str]], downloads.Keys]
    """What may stand for a line of the roster in such a path, by the columns of names."""


_CANVAS = canvas_table, downloads.canvas_sent, downloads.canvas_keys
_MOODLE = moodle_table, downloads.moodle_sent, downloads.moodle_keys
SYSTEMS = {
    "canvas": System("Canvas", "SIS Login ID", canvas_students, canvas_names, *_CANVAS),
    "moodle": System("Moodle", "Email address", lambda all: all.rows, moodle_names, *_MOODLE),
}


def find(system: System, roster: Roster, column: Column) -> int | None:
    """Return the roster's column of an assignment, by its name or its title; None where it is new.

    Raises:
        WrongUse: there are several.
    """
    wanted = {column.name, column.title} - {""}
    found = [n for n, head in enumerate(roster.header) if wanted & system.names(head)]
    if len(found) > 1:
        both = " and ".join(repr(roster.header[n]) for n in found[:2])
        raise WrongUse(
            f"{roster.path}:1: {both} may both be {column.name}: "
            f"say which with --column {column.name}=HEADER."
        )
    return found[0] if found else None
