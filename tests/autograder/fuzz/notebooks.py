"""Notebooks to trip over: wrong types, keys twice, odd numbers, texts and encodings."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
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


_TOKEN = re.compile(r'"(?:[^"\\]|\\.)*"|[][{},:]|[^][{},:"\s]+')


def _value(tokens: list[str], rng: np.random.Generator) -> slice:
    """Where a value stands: a scalar, a list or an object, mostly one that is no key."""
    starts = [n for n, token in enumerate(tokens) if token not in "]},:"]
    values = (
        [n for n in starts if tokens[n + 1 : n + 2] != [":"]] if rng.random() < 0.9 else starts
    )
    end = start = values[rng.integers(len(values))] if values else 0
    depth = 0
    while end < len(tokens):
        depth += (tokens[end] in "[{") - (tokens[end] in "]}")
        end += 1
        if not depth:
            break
    return slice(start, end)


def _edit(tokens: list[str], rng: np.random.Generator) -> None:
    """Change one value or key of a notebook's JSON."""
    here, there = _value(tokens, rng), _value(tokens, rng)
    key, value = f'"{_one(KEYS, rng)}"', tokens[here]
    match rng.integers(7):
        case 0:
            tokens[here] = tokens[there]
        case 1:
            tokens[here] = ["[", *value, "]"]
        case 2:
            tokens[here] = ["{", key, ":", *value, "}"]
        case 3 if value[:1] == ["{"]:
            tokens[here] = ["{", key, ":", "1", ",", *value[1:]] if len(value) > 2 else value
        case 4 if tokens[here.stop : here.stop + 1] == [":"]:
            tokens[here] = [key]
        case 5 if rng.random() < 0.2:
            tokens[here] = [_one(BAD, rng)]
        case _:
            tokens[here] = [_one(GOOD, rng)]


def _one(choices: list[str], rng: np.random.Generator) -> str:
    return choices[rng.integers(len(choices))]


VALUES = [
    toy.source_notebook(),
    toy.answer("x = '\N{GRINNING FACE}'"),
    toy.notebook([toy.cell(toy.DOUBLE, "double", solution=True) | {"source": ["a\n", "b"]}]),
]


def edited(value: dict[str, Any], seed: int) -> Iterator[bytes]:
    """Give a notebook, then with a few changes, in many ways."""
    text = json.dumps(value)
    yield text.encode()
    rng = np.random.default_rng(seed)
    for _ in range(running.VARIANTS):
        tokens = _TOKEN.findall(text)
        for _ in range(rng.integers(1, 6)):
            _edit(tokens, rng)
        codec = _one(["utf-8"] * 12 + ["utf-8-sig", "utf-16", "utf-32"], rng)
        yield _one(SPACE, rng).join(tokens).encode(codec, "surrogatepass")


SCALARS = st.sampled_from(GOOD + BAD)
JSON = st.recursive(
    SCALARS,
    lambda inner: (
        st.lists(inner, max_size=4).map(lambda items: f"[{','.join(items)}]")
        | st.lists(st.tuples(st.sampled_from(KEYS), inner).map('"%s":%s'.__mod__), max_size=4).map(
            lambda pairs: f"{{{','.join(pairs)}}}"
        )
    ),
    max_leaves=15,
).map(str.encode)
HOSTILE = JSON | st.binary(max_size=40)
VALID = st.sampled_from([json.dumps(value, indent=1).encode() for value in VALUES])
TOKENS = [part.encode("utf-8", "surrogatepass") for part in [*GOOD, *BAD, *KEYS, ",", ":", "\\"]]
TOKENS += [b"\xff\xfe", b"\xed\xa0\x80", b"\xef\xbb\xbf", b"\xc0\x80"]
