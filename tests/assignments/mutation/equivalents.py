"""Mutants that were judged to be equivalent to the reference, each with its reason.

They stand in ``solutions/answers/<assignment>/equivalents.toml``::

    [[equivalent]]
    exercise = "irls"
    line = "for _ in range(10_000):"
    becomes = ["for _ in range(10001):", "for _ in range(9999):"]
    reason = "The loop ends after fewer than 100 steps: the bound is never reached."

A mutant is recognised by its exercise, the line that is changed (several lines: with line breaks,
without indentation) and what becomes of it. Where a cell holds the same line in two functions,
``function`` says which is meant. An entry that fits no survivor is stale, and an error.
"""

import tomllib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from tests.assignments.mutation.cells import Mutant

FILE = "equivalents.toml"
KEYS = {"exercise", "line", "becomes", "reason"}


class Stale(Exception):
    """An entry cannot be used, or does not fit the notebook any more."""


@dataclass(frozen=True)
class Equivalent:
    """One mutant that changes nothing that anybody could observe."""

    exercise: str
    function: str
    """Empty where the line says enough."""
    line: str
    becomes: str
    reason: str

    def fits(self, mutant: Mutant) -> bool:
        """Return whether this is the mutant that was judged."""
        told = (self.exercise, self.line, self.becomes)
        same = told == (mutant.exercise, mutant.line, mutant.becomes)
        return same and self.function in ("", mutant.function)

    def __str__(self) -> str:
        return f"{self.exercise}: {self.line} → {self.becomes}"


def read(path: Path) -> list[Equivalent]:
    """Read an assignment's file; without one there are none.

    Raises:
        Stale: an entry lacks a key, or has an unknown one, or no reason.
    """
    if not path.is_file():
        return []
    entries = tomllib.loads(path.read_text(encoding="utf-8")).get("equivalent", [])
    return [found for entry in entries for found in _entry(entry, path)]


def _entry(entry: dict[str, object], path: Path) -> Iterable[Equivalent]:
    if not KEYS <= set(entry) <= KEYS | {"function"} or not str(entry["reason"]).strip():
        raise Stale(f"{path.parent.name}: an entry wants {', '.join(sorted(KEYS))}: {entry}")
    becomes = entry["becomes"]
    for text in becomes if isinstance(becomes, list) else [becomes]:
        yield Equivalent(
            exercise=str(entry["exercise"]),
            function=str(entry.get("function", "")),
            line=_lines(str(entry["line"])),
            becomes=_lines(str(text)),
            reason=str(entry["reason"]),
        )


def _lines(text: str) -> str:
    return "\n".join(line.strip() for line in text.strip().split("\n"))


def refuse_stale(
    judged: Sequence[Equivalent], mutants: Sequence[Mutant], killed: Iterable[Mutant]
) -> None:
    """Refuse what was judged and is no more.

    Raises:
        Stale: an entry fits no mutant, or one that a case kills.
    """
    for one in judged:
        if not any(one.fits(mutant) for mutant in mutants):
            raise Stale(f"no mutant is as judged any more, take it out: {one}")
    for mutant in killed:
        for one in judged:
            if one.fits(mutant):
                raise Stale(f"a case kills what was judged equivalent, take it out: {one}")
