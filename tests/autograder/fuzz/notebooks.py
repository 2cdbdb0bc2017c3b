"""Notebooks to trip over: wrong types, keys twice, odd numbers, texts and encodings."""

from __future__ import annotations

import copy
import json
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from hypothesis import strategies as st

from tests.autograder import toy
from tests.autograder.fuzz import running

GOOD = [
    *("null", "true", "false", "0", "-0", "4", "4.0", "4e0", "3", "99", "-1", "1.5", "2e-320"),
    *("NaN", "Infinity", "-Infinity", "1e999", "-1e999", "9" * 400, "9" * 10_000, "1" * 4301),
    *('""', '"4"', '"\\u0000"', '"\\ud800"', '"\\udc00\\ud800"', '"\\ud83d\\ude00"', "[]", "{}"),
    *('"\U0001f600"', '"\u2028\x85"', '"\\r\\n\\r"', '"code"', '"markdown"', '"double"'),
    *('"apply"', '"apply-by-hand"', '"def double(x): pass"'),
    *('["a", "b"]', '["a", 1]', '{"a": []}'),
]
"""Values that some reader takes for JSON."""
BAD = [
    *("tru", "", "01", "+1", ".5", "0x10", "1_0", "'x'", "\\", "4 4", "\x00", "\ufeff"),
    *('"\\x"', '"\\u12"', '"', '"x\ny"', "[", "]", "{", "}", "[" * 3000, '{"":' * 3000, "// x\n"),
]
KEYS = [
    *("nbformat", "nbformat_minor", "cells", "worksheets", "metadata", "nbgrader", "source"),
    *("cell_type", "outputs", "grade_id", "grade", "solution", "locked", "points", "id"),
    *("", "__class__", "\\ud800", "\\u0063ells", "x" * 300),
]
SPACE = ["", " ", "\n", "\r\n", "\t", "\x0c", "\u00a0"]


@dataclass
class Object:
    """A JSON object, which may hold a key twice; a value is one, a list, or its JSON as text."""

    pairs: list[list[Any]]


def _tree(value: object) -> Any:
    if isinstance(value, dict):
        return Object([[key, _tree(item)] for key, item in value.items()])
    return [_tree(item) for item in value] if isinstance(value, list) else json.dumps(value)


def _written(tree: Any, space: str) -> str:
    comma = f",{space}"
    if isinstance(tree, Object):
        pairs = comma.join(f'"{key}":{space}{_written(item, space)}' for key, item in tree.pairs)
        return f"{{{pairs}}}"
    return f"[{comma.join(_written(i, space) for i in tree)}]" if isinstance(tree, list) else tree


Slots = list[tuple[list[Any], int]]
"""Places that hold a value: a list and a position in it."""


def _slots(tree: Any) -> Slots:
    if isinstance(tree, Object):
        return [slot for pair in tree.pairs for slot in [(pair, 1), *_slots(pair[1])]]
    if isinstance(tree, list):
        here: Slots = [(tree, position) for position in range(len(tree))]
        return here + [slot for item in tree for slot in _slots(item)]
    return []


def _edit(tree: Any, rng: np.random.Generator) -> None:
    """Change one place of a tree."""
    slots = _slots(tree)
    if not slots:
        return
    (place, at), (other, there) = (slots[i] for i in rng.integers(len(slots), size=2))
    match rng.integers(7):
        case 0:
            place[at], other[there] = copy.deepcopy(other[there]), copy.deepcopy(place[at])
        case 1:
            place[at] = [place[at]]
        case 2:
            place[at] = Object([[_one(KEYS, rng), place[at]]])
        case 3 if isinstance(place[at], Object):
            place[at].pairs += [*copy.deepcopy(place[at].pairs[:2]), [_one(KEYS, rng), "1"]]
        case 4 if isinstance(place[0], str) and at == 1:
            place[0] = _one(KEYS, rng)
        case 5 if rng.random() < 0.2:
            place[at] = _one(BAD, rng)
        case _:
            place[at] = _one(GOOD, rng)


def _one(choices: list[str], rng: np.random.Generator) -> str:
    return choices[rng.integers(len(choices))]


VALUES = [
    toy.source_notebook(),
    toy.answer("x = '\N{GRINNING FACE}'"),
    toy.notebook([toy.cell(toy.DOUBLE, "double", solution=True) | {"source": ["a\n", "b"]}]),
]


def edited(value: dict[str, Any], seed: int) -> Iterator[bytes]:
    """Give a notebook, then with a few changes, in many ways."""
    yield json.dumps(value).encode()
    rng = np.random.default_rng(seed)
    for _ in range(running.VARIANTS):
        tree = _tree(value)
        for _ in range(rng.integers(1, 6)):
            _edit(tree, rng)
        running.tried += 1
        codec = _one(["utf-8"] * 12 + ["utf-8-sig", "utf-16", "utf-32"], rng)
        yield _written(tree, _one(SPACE, rng)).encode(codec, "surrogatepass")


SCALARS = st.sampled_from(GOOD + BAD)
JSON = st.recursive(
    SCALARS,
    lambda inner: (
        st.lists(inner, max_size=4)
        | st.lists(st.tuples(st.sampled_from(KEYS), inner).map(list), max_size=4).map(Object)
    ),
    max_leaves=15,
).map(lambda tree: _written(tree, "").encode())
HOSTILE = JSON | st.binary(max_size=40)
VALID = st.sampled_from([json.dumps(value, indent=1).encode() for value in VALUES])
TOKENS = [part.encode("utf-8", "surrogatepass") for part in [*GOOD, *BAD, *KEYS, ",", ":", "\\"]]
TOKENS += [b"\xff\xfe", b"\xed\xa0\x80", b"\xef\xbb\xbf", b"\xc0\x80"]
