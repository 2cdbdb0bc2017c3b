"""Whatever file is handed in, the reader gives cells or refuses it in one sentence.

Wrong types, keys twice, odd numbers, texts and encodings: notebooks to trip over.
"""

import contextlib
import json
import math
import re
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import strategies as st
from robust_slam_autograder.errors import Refused
from robust_slam_autograder.reading import notebook
from robust_slam_autograder.reading.notebook import Cell
from robust_slam_autograder.reading.submission import OWN, collect

from .. import toy
from .running import SEEDS, VARIANTS, calls, fuzzed, no_hang, peak_bytes
from .test_texts import SOURCES

pytestmark = pytest.mark.rest

TESTS = toy.assignment()
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
    no_keys = [n for n in starts if tokens[n + 1 : n + 2] != [":"]]
    values = no_keys if rng.random() < 0.9 else starts
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
    for _ in range(VARIANTS):
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


def parsed(data: bytes) -> tuple[Cell, ...]:
    """The cells; none where the file was refused, whose sentence is looked at."""
    try:
        return notebook.parse(data, "a.ipynb")
    except Refused as error:
        check_sentence(str(error), "a.ipynb")
        return ()


def check_sentence(sentence: str, name: str) -> None:
    assert name in sentence and sentence.endswith(".")
    assert ". " not in sentence.replace(name, "") and sentence.isprintable()
    assert len(sentence) < 250


def check_cells(cells: tuple[Cell, ...]) -> None:
    assert len(cells) <= notebook.MAX_CELLS
    for cell in cells:
        assert type(cell.kind) is str and type(cell.source) is str
        assert cell.source.encode() is not None and "\r" not in cell.source
        assert cell.grade_id is None or type(cell.grade_id) is str
        assert {type(cell.grade), type(cell.solution), type(cell.locked)} == {bool}
        assert type(cell.points) is float and math.isfinite(cell.points)


@fuzzed(200, HOSTILE)
def test_any_bytes_are_cells_or_refused(data):
    check_cells(parsed(data))


@fuzzed(100, st.sampled_from(VALUES), SEEDS)
def test_an_edited_notebook_is_cells_or_refused(value, seed):
    for data in edited(value, seed):
        check_cells(parsed(data))


@fuzzed(100, HOSTILE)
def test_memory_and_work_are_bounded_by_the_files_length(data):
    assert calls(lambda: parsed(data)) <= 200 + 4 * len(data)
    assert peak_bytes(lambda: parsed(data)) <= 64_000 + 150 * len(data)


@fuzzed(
    100, st.text(max_size=100) | st.text(st.sampled_from("a./\\\0\n\x1b\ud800é"), max_size=300)
)
def test_a_file_of_any_name_is_refused_by_its_name(name):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, name.replace("/", ""))
        with contextlib.suppress(OSError, ValueError):  # then there is no such file
            path.write_bytes(b"[]")
        with pytest.raises(Refused) as caught:
            notebook.read(path)
        check_sentence(str(caught.value), notebook.shown(path.name))


CELLS = st.builds(
    Cell,
    kind=st.sampled_from(["code", "code", "code", "markdown", ""]),
    source=SOURCES | st.sampled_from([toy.SETUP, toy.DOUBLE, toy.APPLY, toy.DOUBLE_VISIBLE]),
    grade_id=st.none()
    | st.sampled_from(["double", "apply", "double-by-hand", "apply-twice", "setup", "x"])
    | st.text(max_size=3),
    grade=st.booleans(),
    solution=st.booleans(),
    locked=st.booleans(),
    points=st.floats(allow_nan=False),
)


@fuzzed(200, st.lists(CELLS, max_size=8))
def test_any_cells_are_sorted(cells):
    found = collect(notebook.Notebook(cells), TESTS)
    lines = iter([line for cell in cells for line in cell.source.split("\n")])
    for piece in found.pieces:  # in the notebook's order, and nothing else
        assert all(not line or line in lines for line in piece.source.split("\n"))
    labels = {piece.label for piece in found.pieces}
    assert labels <= {"double", "apply", OWN}
    assert all(piece.own for piece in found.pieces if piece.label == OWN)
    assert found.missing <= {"double", "apply"}
    assert all(note.endswith(".") and "\n" not in note for note in found.notes)


LARGE = 20 * 2**20 - 200


def filled(part: bytes, size: int, head: bytes, tail: bytes) -> bytes:
    """A notebook of this size, repeating one part."""
    start, end = b'{"nbformat":4,"cells":[', b"]}"
    return start + head + part * ((size - len(head) - len(tail)) // len(part)) + tail + end


SOURCE_HEAD = b'{"cell_type":"code","source":"'
HEAVY = {
    "empty lists": (b"[],", LARGE, b"", b"0"),
    "small dicts": (b'{"":0},', LARGE, b"", b"0"),
    "short texts": ('"\u0101",'.encode(), LARGE, b"", b"0"),
    "open lists": (b"[", LARGE, b"", b""),
    "as many dicts as may be": (b'{"":[]},', 8 * 330_000, b"", b"0"),
    "as many lists as may be": (b"[0],", 4 * 499_000, b"", b"0"),
    "one text": (b"x", LARGE, SOURCE_HEAD, b'"}'),
    "one text of escapes": (b"\\u0041", LARGE, SOURCE_HEAD, b'"}'),
    "one text of line ends": (b"\\r", LARGE, SOURCE_HEAD, b'"}'),
    "one text with a wide letter": (b"x", LARGE, SOURCE_HEAD + "😀".encode(), b'"}'),
    "one text of half letters": (b"\\ud800", LARGE, SOURCE_HEAD, b'"}'),
    "one number": (b"9", LARGE, b"", b""),
    "one long fraction": (b"1", LARGE, b"1.", b""),
    "spaces": (b" ", LARGE, b"", b""),
    "backslashes": (b"\\", LARGE, SOURCE_HEAD, b'"}'),
}


@pytest.mark.parametrize("name", HEAVY)
@pytest.mark.long
def test_the_heaviest_notebooks_take_little_memory(name):
    data = filled(*HEAVY[name])
    with no_hang():
        peak = peak_bytes(lambda: check_cells(parsed(data)))
    assert peak <= 300 * 2**20


def test_a_number_of_many_digits_costs_nobody_a_mark():
    value = toy.answer()
    text = json.dumps(value).replace('"execution_count": null', f'"execution_count": {"9" * 6000}')
    assert notebook.parse(text.encode(), "a") == notebook.parse(json.dumps(value).encode(), "a")
