"""Which text of a submission counts: its solution cells, and its own definitions.

Cells are matched by grade id, then by the names that they define. Metadata,
tags, outputs, edited or deleted test cells and extra files do not matter.
Nothing of a student's text is run or parsed here.
"""

from __future__ import annotations

import hashlib
import os
import unicodedata
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from robust_slam_autograder.errors import Refused
from robust_slam_autograder.reading.assignment import MAX_NAME, Assignment, Piece
from robust_slam_autograder.reading.notebook import Cell, shown
from robust_slam_autograder.reading.source import defines

OWN = "own cell"
MAX_STUDENT_BYTES = 200
DATABASE_NAME = "gradebook.db"
DATABASE_VARIABLE = "ROBUST_SLAM_GRADEBOOK"
"""The environment's word for another gradebook, for nbgrader's own commands too."""
SQLITE_KEEPS = ("journal", "wal", "shm")


@dataclass(frozen=True)
class Submission:
    """The student code of one notebook, in the notebook's order."""

    pieces: tuple[Piece, ...]
    missing: frozenset[str]
    """Grade ids of solution cells for which nothing was found."""
    notes: tuple[str, ...]
    """Sentences on what was found in an unusual place."""


def collect(cells: Sequence[Cell], assignment: Assignment) -> Submission:
    """Pick the student code out of a submission's cells."""
    code = [cell for cell in cells if cell.kind == "code"]
    owners, notes = _by_grade_id(code, assignment)
    missing: set[str] = set()
    for solution in assignment.solutions:
        if solution.grade_id in owners.values():
            continue
        found = [
            n
            for n, cell in enumerate(code)
            if not cell.grade and defines(cell.source, solution.names)
        ]
        place = "was found by its function's name" if found else "was not found"
        notes.append(f"The cell {solution.grade_id} {place}.")
        owners = dict.fromkeys(found, solution.grade_id) | owners
        missing |= set() if found else {solution.grade_id}
    pieces = (
        Piece(owners.get(n, OWN), cell.source, own=n not in owners)
        for n, cell in enumerate(code)
        if n in owners or _is_own(cell, assignment)
    )
    return Submission(tuple(pieces), frozenset(missing), tuple(notes))


def _by_grade_id(code: Sequence[Cell], assignment: Assignment) -> tuple[dict[int, str], list[str]]:
    """Cells (by position) that carry a solution's grade id, with a note on each copied one."""
    known = {solution.grade_id for solution in assignment.solutions}
    owners = {n: cell.grade_id for n, cell in enumerate(code) if cell.grade_id in known}
    counts = Counter(owners.values())
    notes = [
        f"{grade_id} stands in {count} cells: they ran in order."
        for grade_id, count in counts.items()
        if count > 1
    ]
    return owners, notes


def _is_own(cell: Cell, assignment: Assignment) -> bool:
    """Whether a cell is the student's, and not one of the instructor's as it was released."""
    tests = {case.grade_id for case in assignment.cases}
    return cell.grade_id not in tests and cell.source.strip() not in assignment.given


def with_notes(submission: Submission, notes: tuple[str, ...]) -> Submission:
    """Return the same submission with more notes, before its own."""
    return replace(submission, notes=notes + submission.notes)


def is_student(name: str) -> bool:
    """Return whether results may be in a folder of this name, beside the batch's own files."""
    plain = name.isprintable() and "/" not in name and not name.startswith(".")
    short = len(name) <= MAX_NAME and len(name.encode(errors="replace")) <= MAX_STUDENT_BYTES
    return bool(name) and plain and short and not _is_databases(name)


def _is_databases(name: str) -> bool:
    """Whether a file of this name is the gradebook's, or one that SQLite keeps beside it."""
    return name in (DATABASE_NAME, *(f"{DATABASE_NAME}-{kind}" for kind in SQLITE_KEEPS))


def stand_in(name: str) -> str:
    """Return the name that a refused submission gets where its own cannot be a folder's name."""
    return f"student-{hashlib.sha256(os.fsencode(name)).hexdigest()[:12]}"


def look_alike(students: Iterable[str]) -> list[tuple[str, ...]]:
    """Return the groups of names that are equal after Unicode normalisation."""
    groups: dict[str, set[str]] = {}
    for name in students:
        groups.setdefault(unicodedata.normalize("NFC", name), set()).add(name)
    return [tuple(sorted(names)) for names in groups.values() if len(names) > 1]


def notebook_in(folder: Path, name: str) -> tuple[Path, tuple[str, ...]]:
    """Find the notebook that a folder ``submitted/<student>/<assignment>/`` hands in.

    Args:
        folder: the submission's folder.
        name: the notebook's name without its ending.

    Returns:
        its path, and a note where it has another name than the assignment's.

    Raises:
        Refused: there is none, or several and none has the right name.
    """
    right = folder / f"{name}.ipynb"
    try:
        notebooks = [path for path in folder.iterdir() if path.suffix == ".ipynb"]
        # macOS puts a file ._NAME beside each file of an archive.
        found = sorted(path for path in notebooks if not path.name.startswith("."))
    except OSError as error:
        raise Refused(f"The folder cannot be read ({error.strerror}).") from error
    if right in found:
        return right, ()
    if len(found) == 1:
        return found[0], (f"{shown(found[0].name)} was taken for {right.name}.",)
    what = "There is no notebook" if not found else f"There are {len(found)} notebooks"
    raise Refused(f"{what} in the folder: hand in one, named {right.name}.")
