"""By which digests the wrong answers to an exercise have which label.

A label can be read by those alone whose answer has its key, so a table may go to students: it
tells no one what could be wrong, but only what is.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from robust_slam_autograder.misconceptions import aspects, traits
from robust_slam_autograder.misconceptions.aspects import Digests
from robust_slam_autograder.misconceptions.shapes import (
    AROUND,
    CALLS,
    COUNT,
    ENTRIES,
    FRACTIONS,
    RAISED,
    WHOLE,
    Shape,
)

FILE = "misconceptions.json"
"""In a release, the tables of its visible cases."""
Right = Mapping[str, Mapping[str, frozenset[str]]]
"""By grade id and aspect, digests of what the solution had returned after each call."""


@dataclass(frozen=True)
class Table:
    """What is known of one exercise's visible cases."""

    labels: Mapping[str, str]
    """By half of the key, the label, which the key opens; empty where that is not one thing."""
    right: Right
    arguments: tuple[str, ...]
    """Of the exercise's first function."""
    words: tuple[str, ...] = ()
    """Which the solution says, where it says words or truths."""

    def sentence(self, shape: Shape) -> str:
        """Say what a wrong answer looks like; empty where nothing fits, or more than one thing."""
        keys = shape.keys()
        said = {
            _opened(self.labels[_place(key)], key) for key in keys if _place(key) in self.labels
        }
        if len(said) == 1 and "" not in said:
            return said.pop()
        cases = [(found, self.right.get(one, {})) for one, found in shape.failed.items()]
        wrong = [pair for pair in cases if not _is_right(*pair)]
        # What is wrong with some is not what is wrong with all.
        is_one = len(wrong) == len(cases)
        compared = wrong if keys and is_one else []
        pairs = [pair for pair in compared if CALLS in pair[0] and RAISED not in pair[0]]
        is_sure = bool(pairs) and (shape.real or len(pairs) > 1)
        seen = aspects.told(pairs, self.arguments) if is_sure else ""
        seen = seen or (_entries(pairs) or _count(pairs) if pairs else "")
        if not seen and shape.has_ends:
            passed, has_cut = shape.passed, any(_is_at(*pair, FRACTIONS) for pair in cases)
            ends = shape.ends.values()
            seen = traits.told(ends, passed, self.arguments, self.words, has_cut=has_cut)
        seen = seen or (aspects.told_at_last(pairs) if is_sure else "")
        return seen or (_errors(wrong) if is_one else "" if wrong else _BESIDES)


def _is_right(found: Digests, right: Digests) -> bool:
    """Tell whether all calls of a failed case returned what the solution returns."""
    return not {*found.get(WHOLE, ())}.isdisjoint(right.get(WHOLE, ()))


def _is_at(found: Digests, right: Digests, what: str) -> bool:
    """Tell whether the solution raises, or returns fractions, at the call where a case failed."""
    return not {*found.get(CALLS, ())}.isdisjoint(right.get(what, ()))


def _errors(cases: Sequence[tuple[Digests, Digests]]) -> str:
    """Say whether errors are raised where answers belong, or the reverse."""
    told = {(RAISED in found, _is_at(found, right, RAISED)) for found, right in cases}
    return _ERRORS.get(told.pop(), "") if len(told) == 1 else ""


_BESIDES = (
    "the right values come back, so the fault is their type, their last digits or what is done "
    "besides"
)
_ERRORS = {
    (True, False): "an error is raised where an answer belongs",
    (False, True): "an answer comes back where an error should be raised",
    (True, True): "an error is raised as it should be, but not the one that is asked for",
}
"""By whether one is raised, and whether one should be."""


def _count(cases: Sequence[tuple[Digests, Digests]]) -> str:
    """Say whether too few entries come back or too many."""
    told = set()
    for found, right in cases:
        name = next((key for key in found if key.startswith(COUNT)), COUNT)
        if name not in right or set(found[name]) == set(right[name]):
            return ""
        mine, meant = (int(next(iter(one[name]))) for one in (found, right))
        told.add("fewer" if mine < meant else "more")
    how = f"{told.pop()} entries come back than should" if len(told) == 1 else ""
    return how or "the number of entries that come back is not the right one"


def _entries(cases: Sequence[tuple[Digests, Digests]]) -> str:
    """Say whether there are too few entries or too many, and all others are right."""
    told = set()
    for found, right in cases:
        name = next((key for key in found if key.startswith(ENTRIES)), "")
        place = name.removeprefix(ENTRIES)
        if not name or name not in right:
            return ""
        mine, all_right = set(found[name]), set(right[name])
        is_part = mine <= set(right[f"{AROUND}{place}"])
        is_more = all_right <= set(found[f"{AROUND}{place}"])
        if not (is_part or is_more) or not mine:
            return ""
        told.add(
            "the right entries come back, in another order or form"
            if is_part and is_more
            else "something is missing, and all that comes back is right"
            if is_part
            else "all that belongs there comes back, and more besides"
        )
    return told.pop() if len(told) == 1 else ""


def sealed(labels: Mapping[str, str]) -> dict[str, str]:
    """Return sentences by half of their keys, each so that the whole key opens it."""
    return {_place(key): _changed(text.encode(), key).hex() for key, text in labels.items()}


def _opened(text: str, key: str) -> str:
    return _changed(bytes.fromhex(text), key).decode(errors="replace")


def _place(key: str) -> str:
    return key[: len(key) // 2]


def _changed(data: bytes, key: str) -> bytes:
    stream = hashlib.shake_256(f"label {key}".encode()).digest(len(data))
    return bytes(one ^ other for one, other in zip(data, stream, strict=True))


def write(path: Path, tables: Mapping[str, Table]) -> None:
    """Write the tables of an assignment's exercises."""
    data = {name: asdict(table) for name, table in tables.items()}
    text = json.dumps(data, separators=(",", ":"), sort_keys=True, default=sorted)
    path.write_text(f"{text}\n", "utf-8")


def read(path: Path) -> dict[str, Table]:
    """Read what ``write`` has written; none where there is no such file, or another one."""
    try:
        return made(json.loads(path.read_text(encoding="utf-8")))
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return {}


def made(data: Mapping[str, Any]) -> dict[str, Table]:
    """Make the tables of what a file holds of them.

    Raises:
        TypeError, AttributeError, KeyError: it holds anything else.
    """
    return {name: _table(table) for name, table in data.items()}


def _table(data: Mapping[str, Any]) -> Table:
    right = {
        grade_id: {aspect: frozenset(some) for aspect, some in found.items()}
        for grade_id, found in data["right"].items()
    }
    return Table(dict(data["labels"]), right, tuple(data["arguments"]), tuple(data["words"]))


def arguments_of(function: object) -> tuple[str, ...]:
    """Return the names of a function's arguments, as far as it tells them."""
    code = getattr(function, "__code__", None)
    return tuple(code.co_varnames[: code.co_argcount]) if code else ()
