"""Which text of a submission counts: its solution cells, and its own definitions.

Cells are matched by grade id, then by the names that they define. Metadata,
tags, outputs, edited or deleted test cells and extra files do not matter.
"""

from __future__ import annotations

import ast
import contextlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from robust_slam_autograder.assignment import Assignment, defined_names
from robust_slam_autograder.errors import Refused
from robust_slam_autograder.notebook import Cell


@dataclass(frozen=True)
class Piece:
    """A piece of student code, to be run in order."""

    label: str
    """How messages name it: the solution cell's grade id, or "own cell"."""
    source: str


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
    code = [replace(c, source=plain_python(c.source)) for c in cells if c.kind == "code"]
    owners: dict[int, str] = {}
    missing: set[str] = set()
    notes: list[str] = []
    for solution in assignment.solutions:
        found = [n for n, cell in enumerate(code) if cell.grade_id == solution.grade_id]
        if len(found) > 1:
            notes.append(f"{solution.grade_id} stands in {len(found)} cells: they ran in order.")
        if not found:
            found = [n for n, cell in enumerate(code) if _defines(cell, solution.names)]
            place = "was found by its function's name" if found else "was not found"
            notes.append(f"The cell {solution.grade_id} {place}.")
        if not found:
            missing.add(solution.grade_id)
        owners |= dict.fromkeys(found, solution.grade_id)
    known = {case.grade_id for case in assignment.cases}
    pieces = []
    for n, cell in enumerate(code):
        if n in owners:
            pieces.append(Piece(owners[n], cell.source))
        elif cell.grade_id not in known and cell.source.strip() not in assignment.given:
            pieces += [Piece("own cell", own) for own in [definitions(cell.source)] if own]
    return Submission(tuple(pieces), frozenset(missing), tuple(notes))


def plain_python(source: str) -> str:
    """Rewrite IPython's magics and shell lines as calls of ``get_ipython()``."""
    try:
        ast.parse(source)
    except SyntaxError:
        from IPython.core.inputtransformer2 import TransformerManager

        with contextlib.suppress(Exception):  # text that is no Python at all stays as it is
            return str(TransformerManager().transform_cell(source))  # type: ignore[no-untyped-call]
    except (ValueError, RecursionError, MemoryError):
        return source
    return source


def with_notes(submission: Submission, notes: tuple[str, ...]) -> Submission:
    """The same submission with more notes, before its own."""
    return replace(submission, notes=notes + submission.notes)


def _defines(cell: Cell, names: Sequence[str]) -> bool:
    return not cell.grade and bool(set(defined_names(cell.source)) & set(names))


def definitions(source: str) -> str:
    """Keep a cell's imports, functions, classes and constants; drop what it computes or prints.

    Students put helpers into cells of their own; what else stands there (a plot, a
    slow experiment, an error) is not theirs to lose marks by.
    """
    try:
        tree = ast.parse(source)
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return ""
    keep = [node for node in tree.body if _is_definition(node)]
    return "\n".join(ast.get_source_segment(source, node, padded=True) or "" for node in keep)


def _is_definition(node: ast.stmt) -> bool:
    kinds = ast.Import | ast.ImportFrom | ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef
    if isinstance(node, kinds):
        return True
    if not isinstance(node, ast.Assign | ast.AnnAssign) or node.value is None:
        return False
    return isinstance(node.value, ast.Lambda) or not any(
        isinstance(part, ast.Call | ast.ListComp | ast.GeneratorExp | ast.DictComp | ast.SetComp)
        for part in ast.walk(node.value)
    )


def notebook_in(folder: Path, assignment: str) -> tuple[Path, tuple[str, ...]]:
    """Find the notebook that a folder ``submitted/<student>/<assignment>/`` hands in.

    Returns:
        its path, and a note where it has another name than the assignment's.

    Raises:
        Refused: there is none, or several and none has the right name.
    """
    right = folder / f"{assignment}.ipynb"
    if right.is_symlink() or right.exists():
        return right, ()
    found = sorted(path for path in folder.iterdir() if path.suffix == ".ipynb")
    if len(found) == 1:
        return found[0], (f"{found[0].name} was taken for {right.name}.",)
    what = "no notebook" if not found else f"{len(found)} notebooks"
    raise Refused(f"There are {what} in the folder: hand in one, named {right.name}.")
