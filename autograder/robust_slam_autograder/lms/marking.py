"""Who marks whom, and what students ask about their marks: one file, beside the roster."""

import itertools
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from robust_slam_autograder.errors import WrongUse
from robust_slam_autograder.reading.table import Kinds, read_table

NAME = "marking.toml"
_TOLD = {...: {...: str}}
_KINDS: Kinds = {"markers": list, "takes": {...: str}, "questions": _TOLD, "answers": _TOLD}
_SHOWN = 10
"""Names in a message."""


@dataclass(frozen=True)
class Question:
    """What a student asks about a mark."""

    student: str
    text: str
    answer: str
    """Empty as long as it is open."""


@dataclass(frozen=True)
class Marking:
    """What the file says; nothing where there is none."""

    markers: Mapping[str, str] = field(default_factory=dict)
    """By student."""
    questions: Mapping[str, tuple[Question, ...]] = field(default_factory=dict)
    """By assignment, in the file's order."""


def load(path: Path, handed_in: Mapping[str, Collection[str]]) -> Marking:
    """Read who marks whom, and the questions.

    Students whom no line gives to a marker are dealt out in turn, by their names. Who has a
    result is told by assignment.

    Raises:
        WrongUse: names the file and the key that is unknown, of a wrong type, or about a
            marker, a student or an assignment that there is not.
    """
    table = read_table(path, _KINDS)
    markers = table.get("markers", [])
    if not all(isinstance(name, str) and name.strip() for name in markers):
        raise WrongUse(f'{path}: markers is a list of names, as ["Ines", "Omar"].')
    students = sorted({name for names in handed_in.values() for name in names})
    takes = table.get("takes", {})
    _refuse_unknown(path, "takes", takes, students)
    for student, marker in takes.items():
        if marker not in markers:
            known = ", ".join(markers) or "none"
            raise WrongUse(f"{path}: {student} is given to {marker!r}; the markers are {known}.")
    others = [name for name in students if name not in takes]
    dealt = zip(others, itertools.cycle(markers), strict=False)
    return Marking(takes | dict(dealt), _questions(path, table, handed_in))


def _questions(
    path: Path, table: dict[str, Any], handed_in: Mapping[str, Collection[str]]
) -> dict[str, tuple[Question, ...]]:
    asked, answered = table.get("questions", {}), table.get("answers", {})
    for where, found in (("questions", asked), ("answers", answered)):
        _refuse_unknown(path, where, found, handed_in, kind="assignment")
        for name, lines in found.items():
            _refuse_unknown(path, f"{where}.{name}", lines, handed_in[name])
    for name, lines in answered.items():
        for student in (one for one in lines if one not in asked.get(name, {})):
            raise WrongUse(
                f"{path}: answers.{name} answers {student}, who asks nothing there: write the "
                f"question under [questions.{name}]."
            )
    return {
        name: tuple(
            Question(student, text, answered.get(name, {}).get(student, ""))
            for student, text in lines.items()
        )
        for name, lines in asked.items()
    }


def _refuse_unknown(
    path: Path, where: str, found: Mapping[str, Any], known: Collection[str], kind: str = "student"
) -> None:
    """Refuse lines about who is not known, and lines without words."""
    for name, said in found.items():
        if name not in known:
            there = sorted(known)
            some = ", ".join(there[:_SHOWN]) + (", …" if len(there) > _SHOWN else "")
            raise WrongUse(
                f"{path}: {where} names {name}, and no {kind} of that name has a result; "
                f"there are {some or 'none'}."
            )
        if isinstance(said, str) and not said.strip():
            raise WrongUse(f"{path}: {where}.{name} is a sentence in quotes.")
