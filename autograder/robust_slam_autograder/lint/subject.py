"""An assignment as the rules see it: every cell parsed."""

import ast
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from robust_slam_autograder.reading import assignment as assignments
from robust_slam_autograder.reading import notebook
from robust_slam_autograder.reading.assignment import BEGIN_HIDDEN, END_HIDDEN, Assignment, Case
from robust_slam_autograder.reading.notebook import Cell
from robust_slam_autograder.reading.source import plain_python, tree_of

BEGIN_SOLUTION = "BEGIN SOLUTION"
END_SOLUTION = "END SOLUTION"


@dataclass(frozen=True)
class Found:
    """One place that a rule does not accept."""

    grade_id: str
    """The cell's, or the file's name where it is in none."""
    message: str
    """What is wrong there, and the fix."""
    line: int = 1
    """In that cell."""


@dataclass(frozen=True)
class Code:
    """One of the instructor's cells: a case, or a set-up cell."""

    grade_id: str
    case: Case | None
    """None for a set-up cell."""
    source: str
    tree: ast.Module
    regions: tuple[range, ...]
    """Lines of the hidden regions, without their marks."""

    @cached_property
    def nodes(self) -> tuple[ast.AST, ...]:
        """Return every piece of the cell's code."""
        return tuple(ast.walk(self.tree))

    @cached_property
    def made(self) -> Mapping[str, list[ast.expr]]:
        """Return what variables are assigned, by name."""
        found: dict[str, list[ast.expr]] = {}
        for node in self.nodes:
            if isinstance(node, ast.Assign):
                for part in (part for target in node.targets for part in ast.walk(target)):
                    if isinstance(part, ast.Name) and isinstance(part.ctx, ast.Store):
                        found.setdefault(part.id, []).append(node.value)
        return found

    def is_hidden(self, node: ast.AST) -> bool:
        """Return whether a piece of code stands in a hidden region."""
        line = getattr(node, "lineno", 0)
        return any(line in region for region in self.regions)

    def found(self, node: ast.AST, message: str) -> Found:
        """Return the place of a piece of code, with what is wrong there."""
        return Found(self.grade_id, message, getattr(node, "lineno", 1))


@dataclass(frozen=True)
class Subject:
    """An assignment to lint."""

    assignment: Assignment
    answers: Path | None
    """Folder of right and wrong answers, ``<assignment>/<exercise>.toml``, where there is one."""
    solutions: tuple[Cell, ...]
    """Cells that the grader marks: not those that a person does."""
    tests: tuple[Code, ...]
    setup: tuple[Code, ...]
    unreadable: tuple[Found, ...]
    """Cells that are no Python."""
    modules: Mapping[str, str]
    """What names that the cells import stand for: np is numpy."""
    cells: tuple[Cell, ...]
    """All of the notebook's, in order."""
    book: Path | None
    """Folder of the book's pages, where there is one."""

    @property
    def codes(self) -> tuple[Code, ...]:
        """Return all of the instructor's cells that could be read."""
        return self.setup + self.tests

    @property
    def with_regions(self) -> Iterator[Code]:
        """Yield the cases that have a hidden region."""
        return (code for code in self.tests if code.regions)

    @cached_property
    def helpers(self) -> Mapping[str, ast.FunctionDef]:
        """Return the instructor's own functions, by name."""
        nodes = (node for code in self.codes for node in code.nodes)
        return {node.name: node for node in nodes if isinstance(node, ast.FunctionDef)}

    def full_name(self, node: ast.expr) -> str:
        """Return what an expression names in full: np.linalg.norm is numpy.linalg.norm."""
        first, *rest = (ast.unparse(node) if last_name(node) else "").split(".")
        return ".".join([self.modules.get(first, first), *rest])


def last_name(node: ast.AST) -> str:
    """Return the last part of a dotted name: np.linalg.norm is norm; empty for other code."""
    return str(getattr(node, "attr", getattr(node, "id", "")))


def load(path: Path, answers: Path | None = None, book: Path | None = None) -> Subject:
    """Read an assignment's notebook for the rules; both folders as in ``Subject``.

    Raises:
        WrongUse: the notebook or its ``autograder.toml`` cannot be used.
    """
    assignment = assignments.load(path)
    every = notebook.read(path)
    cells = [cell for cell in every if cell.kind == "code"]
    solutions = tuple(cell for cell in cells if cell.solution and not cell.grade)
    tests = [_code(case.grade_id, case, case.full) for case in assignment.cases]
    setup = [_code(piece.label, None, piece.source) for piece in assignment.setup]
    return Subject(
        assignment=assignment,
        answers=answers,
        solutions=solutions,
        tests=tuple(code for code in tests if isinstance(code, Code)),
        setup=tuple(code for code in setup if isinstance(code, Code)),
        unreadable=tuple(code for code in [*setup, *tests] if isinstance(code, Found)),
        modules=_imported([cell.source for cell in cells]),
        cells=every,
        book=book,
    )


def _code(grade_id: str, case: Case | None, source: str) -> Code | Found:
    try:
        tree = ast.parse(plain_python(source))
    except (SyntaxError, ValueError) as error:
        line = getattr(error, "lineno", None) or 1
        return Found(grade_id, f"This cell is no Python ({error}): correct it.", line)
    return Code(grade_id, case, source, tree, regions(source, BEGIN_HIDDEN, END_HIDDEN))


def regions(source: str, begin: str, end: str) -> tuple[range, ...]:
    """Return the lines between pairs of marks, numbered from 1, without the marks' own."""
    lines = list(enumerate(source.split("\n"), start=1))
    starts = [number for number, line in lines if begin in line]
    ends = [number for number, line in lines if end in line]
    return tuple(range(a + 1, b) for a, b in zip(starts, ends, strict=False))


def _imported(sources: Sequence[str]) -> dict[str, str]:
    found = {}
    for node in (node for source in sources for node in ast.walk(tree_of(source))):
        if isinstance(node, ast.Import):
            for alias in node.names:
                first = alias.name.split(".")[0]
                found[alias.asname or first] = alias.name if alias.asname else first
        elif isinstance(node, ast.ImportFrom) and node.module:
            for alias in node.names:
                found[alias.asname or alias.name] = f"{node.module}.{alias.name}"
    return found
