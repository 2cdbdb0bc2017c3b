"""The mutants of a solution cell between the marks of its solution, and how they are told."""

from __future__ import annotations

import ast
import difflib
from collections.abc import Iterator
from dataclasses import dataclass

from tests.assignments.mutation import mutators

BEGIN, END = "### BEGIN SOLUTION", "### END SOLUTION"


@dataclass(frozen=True)
class Mutant:
    """One change to one solution cell."""

    exercise: str
    """Grade id of the cell."""
    function: str
    """The function at the cell's top level that was changed."""
    source: str
    """The text of the whole cell."""
    line: str
    """The lines that were changed, as they were, without their indentation."""
    becomes: str
    """The same lines as they are."""


def mutants(exercise: str, source: str) -> list[Mutant]:
    """Return all mutants of a cell, in the order of its text.

    Raises:
        ValueError: no solution region is marked in the cell.
    """
    regions = list(_regions(source))
    if not regions:
        raise ValueError(f"{exercise}: no line reads {BEGIN}")
    tree, found = ast.parse(source), []
    for text, line in mutators.changed(source):
        if any(first < line < last for first, last in regions):
            function = mutators.function_at(tree, line)
            told = _changed_lines(source, text)
            found.append(Mutant(exercise, function.name if function else "", text, *told))
    return found


def _regions(source: str) -> Iterator[tuple[int, int]]:
    """First and last line, both marks, of each solution region."""
    first = 0
    for number, line in enumerate(source.split("\n"), start=1):
        if BEGIN in line:
            first = number
        elif END in line:
            yield first, number


def _changed_lines(before: str, after: str) -> tuple[str, str]:
    old, new = before.split("\n"), after.split("\n")
    changes = difflib.SequenceMatcher(None, old, new, autojunk=False).get_opcodes()
    spans = [change for change in changes if change[0] != "equal"]
    line = [text.strip() for text in old[spans[0][1] : spans[-1][2]]]
    becomes = [text.strip() for text in new[spans[0][3] : spans[-1][4]]]
    return "\n".join(line), "\n".join(becomes)
