"""Which text of a submission counts: its solution cells, and its own definitions.

Cells are matched by grade id, then by the names that they define. Metadata, tags, outputs,
types of cells, deleted test cells and extra files do not matter. The same is read for a mark and
for a student's own check. Nothing of a student's text is run or parsed here.
"""

import hashlib
import os
import re
import unicodedata
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from robust_slam_autograder.errors import Refused
from robust_slam_autograder.reading.assignment import MAX_NAME, Assignment, Piece
from robust_slam_autograder.reading.notebook import Cell, Notebook, shown
from robust_slam_autograder.reading.source import defines

OWN = "own cell"
FENCE = "```"
"""Begins code that is quoted in a text."""
ANOTHER = (
    "Nothing in this notebook is of {0}, so it may be another assignment's: hand in the notebook "
    "of {0}, with its cells."
)
TURN_BACK = " and was read as code: select it, press Esc and Y, and it is code again."
MOVE_OUT = ": it counts, but a cell above the check is the place for it."
_HALF = re.compile(r"\s*^[ \t]+\S(?:.*\n)*?[ \t]+return\b", re.MULTILINE)
KINDS = {"markdown": "a Markdown cell", "raw": "a raw cell"}
MAX_STUDENT_BYTES = 200
DATABASE_NAME = "gradebook.db"
DATABASE_VARIABLE = "ROBUST_SLAM_GRADEBOOK"
"""The environment's word for another gradebook, for nbgrader's own commands too."""
_OF_DATABASE = {f"{DATABASE_NAME}{end}" for end in ("", "-journal", "-wal", "-shm")}


@dataclass(frozen=True)
class Code:
    """The student code of one notebook, in the notebook's order."""

    pieces: tuple[Piece, ...]
    missing: frozenset[str]
    """Grade ids of solution cells for which nothing was found."""
    notes: tuple[str, ...]
    """Sentences on what was found in an unusual place."""
    altered: tuple[str, ...] = ()
    """Grade ids of cases that do not stand in the notebook's code as they were released."""
    python: tuple[int, int] | None = None
    foreign: str = ""
    """Why it is rather another assignment's: there is code, and nothing of this one's."""


def collect(cells: Notebook, assignment: Assignment) -> Code:
    """Pick the student code out of a notebook's cells: for grading, and for a student's check.

    What stands in an exercise's cell counts, be it code or text, and so does what any other cell
    of code defines, and a check's where an answer is in it. The checks never come from here.
    """
    owned, missing = owners(cells, assignment)
    tests = {case.grade_id: case.visible.strip() for case in assignment.cases}
    pieces: list[Piece] = []
    notes = list(_notes(cells, assignment, owned, missing))
    for n, cell in enumerate(cells):
        text = _own_text(cell, assignment)
        is_code, is_test = cell.kind == "code", cell.grade_id in tests
        mine = [name for name in assignment.names if is_code and defines(text, [name])]
        # A check that was edited may leave any name behind: it counts where it defines an answer.
        is_own = is_code and text.strip() not in assignment.given and (mine or not is_test)
        if text.strip() and (n in owned or is_own):
            pieces.append(Piece(owned.get(n, OWN), text, own=n not in owned or is_test))
        if n in owned and not is_code:
            notes.append(f"The cell {owned[n]} is {KINDS.get(cell.kind, 'no code')}{TURN_BACK}")
        if is_test and mine:
            notes.append(f"{', '.join(mine)} was found in the check {cell.grade_id}{MOVE_OUT}")
    code = [f"\n{cell.source}\n" for cell in cells if cell.kind == "code"]
    found = {key for key, check in tests.items() if any(f"\n{check}\n" in text for text in code)}
    altered = tuple(key for key, check in tests.items() if check and key not in found)
    asked = [one.grade_id for one in assignment.marked if one.grade or one.solution or one.task]
    ids = {cell.grade_id for cell in cells}.intersection(asked)
    foreign = len(missing) == len(assignment.solutions) and not ids and pieces
    why = ANOTHER.format(assignment.name) if foreign else ""
    return Code(tuple(pieces), missing, tuple(notes), altered, cells.python, why)


def owners(cells: Sequence[Cell], assignment: Assignment) -> tuple[dict[int, str], frozenset[str]]:
    """Find the solution cell that each cell (by position) stands for, and those without any.

    It is that of its grade id. Where no cell has the id, or no code defines one of its names,
    it is the cells that define what is lacking, those of code before those of text.
    """
    known = {solution.grade_id for solution in assignment.solutions}
    owned = {n: cell.grade_id or "" for n, cell in enumerate(cells) if cell.grade_id in known}
    texts = [_own_text(cell, assignment) for cell in cells]
    code = [n for n, cell in enumerate(cells) if cell.kind == "code" or n in owned]
    prose = [n for n in range(len(cells)) if n not in code and FENCE not in texts[n]]

    def defining(places: Iterable[int], names: Sequence[str]) -> list[int]:
        return [n for n in places if defines(texts[n], names)]

    missing = set()
    for one in assignment.solutions:
        has_id = one.grade_id in owned.values()
        found = [] if has_id else defining(code, one.names)
        lacking = [name for name in one.names if not defining(code, [name])]
        found = found or defining(prose, lacking)
        if not found and not has_id:
            missing.add(one.grade_id)
        owned = dict.fromkeys(found, one.grade_id) | owned
    return owned, frozenset(missing)


def _own_text(cell: Cell, assignment: Assignment) -> str:
    """Return a cell's text without the instructor's that it was merged with; lines stay."""
    text = f"\n{cell.source}\n"
    for given in assignment.blocks:
        text = text.replace(f"\n{given}\n", "\n" * (given.count("\n") + 2))
    return text[1:-1]


def _notes(
    cells: Sequence[Cell],
    assignment: Assignment,
    owned: Mapping[int, str],
    missing: Collection[str],
) -> Iterator[str]:
    """Yield a sentence on each answer that is not in one cell, where it was released."""
    ids = [cell.grade_id for cell in cells]
    for grade_id, count in Counter(owned.values()).items():
        if ids.count(grade_id) > 1:
            yield f"{grade_id} stands in {count} cells: they ran in order."
    if any(cell.kind == "code" and _HALF.match(cell.source) for cell in cells):
        yield "A cell begins inside of a function, as one does that was split: merge its halves."
    for one in assignment.solutions:
        if one.grade_id not in ids:
            place = "not found" if one.grade_id in missing else "found by its function's name"
            yield f"The cell {one.grade_id} was {place}."


def is_student(name: str) -> bool:
    """Return whether results may be in a folder of this name, beside the batch's own files."""
    plain = name.isprintable() and "/" not in name and not name.startswith(".")
    short = len(name) <= MAX_NAME and len(name.encode(errors="replace")) <= MAX_STUDENT_BYTES
    return bool(name) and plain and short and name not in _OF_DATABASE


def stand_in(name: str) -> str:
    """Return the name that a refused submission gets where its own cannot be a folder's name."""
    return f"student-{hashlib.sha256(os.fsencode(name)).hexdigest()[:12]}"


def look_alike(students: Iterable[str]) -> list[tuple[str, ...]]:
    """Return the groups of names that are equal after Unicode normalisation."""
    groups: dict[str, set[str]] = {}
    for name in students:
        groups.setdefault(unicodedata.normalize("NFC", name), set()).add(name)
    return [tuple(sorted(names)) for names in groups.values() if len(names) > 1]


def is_notebook(path: str) -> bool:
    """Tell a notebook by its path; hidden are copies of Jupyter's, and what macOS puts beside."""
    parts = re.split(r"[/\\]", path)
    return path.lower().endswith(".ipynb") and not any(part.startswith(".") for part in parts)


def notebooks(folder: Path) -> list[Path]:
    """Return the notebooks in a folder, sorted.

    Raises:
        OSError: it cannot be read.
    """
    return sorted(path for path in folder.iterdir() if is_notebook(path.name))


def notebook_in(folder: Path, name: str) -> tuple[Path, tuple[str, ...]]:
    """Find the notebook that a folder ``submitted/<student>/<assignment>/`` hands in.

    With its path comes a note where it has another name than the assignment's notebook, which is
    given without its ending.

    Raises:
        Refused: there is none, or several and none has the right name.
    """
    right = folder / f"{name}.ipynb"
    try:
        found = notebooks(folder)
    except OSError as error:
        raise Refused(f"The folder cannot be read ({error.strerror}).") from error
    if right in found:
        return right, ()
    if len(found) == 1:
        return found[0], (f"{shown(found[0].name)} was taken for {right.name}.",)
    what = "There is no notebook" if not found else f"There are {len(found)} notebooks"
    raise Refused(f"{what} in the folder: hand in one, named {right.name}.")


def by_hand(cell: Cell) -> bool:
    """Tell whether a person marks the cell: a free-text answer, or a task."""
    return cell.task or (cell.grade and (cell.solution or cell.kind != "code"))


def stands_for(assignment: Assignment, cells: Sequence[Cell]) -> dict[int, str]:
    """Find which of the instructor's cells a submission's cells (by position) stand for.

    Of copied cells it is the last one, whose definitions hold in the end.
    """
    known = {cell.grade_id for cell in assignment.marked}
    last = {cell.grade_id: number for number, cell in enumerate(cells) if cell.grade_id in known}
    last |= {grade_id: n for n, grade_id in sorted(owners(cells, assignment)[0].items())}
    return {number: grade_id for grade_id, number in last.items() if grade_id is not None}


def digest(text: str) -> str:
    """Return what tells a free-text answer from another, blanks around it aside."""
    return hashlib.sha256(text.strip().encode(errors="surrogatepass")).hexdigest()


def texts(assignment: Assignment, cells: Sequence[Cell]) -> dict[str, str]:
    """Return by grade id the digest of what stands in each free-text cell; of none, of nothing."""
    wanted = [cell.grade_id or "" for cell in assignment.marked if by_hand(cell) and not cell.task]
    found = {owner: cells[n].source for n, owner in stands_for(assignment, cells).items()}
    return {name: digest(found.get(name, "")) for name in wanted}
