"""Hostile, broken and odd submissions of the toy assignment, as data.

Each attack says what it may earn at most: what its honest part is worth. The
attacks that are a cell of code stand in ``hostile_cells.txt``.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tests.autograder import toy

TOKEN = "planted-token-5d1f"
"""Stands in the grader's environment while the attacks are graded."""
SLEEPER = "98765.4321"
"""How long the background process of one attack sleeps: a number to know it by."""
APPLY_POINTS = 10
WRONG = "def double(x):\n    return x\n"
"""Wrong for every input but 0."""
PIPE = """
import gc, os, struct
def channel():
    return next(o for o in gc.get_objects() if type(o).__name__ == "Channel")
def send(data):
    os.write(channel()._write_fd, data)
def frame(data):
    send(struct.pack(">I", len(data)) + data)
"""


@dataclass(frozen=True)
class Attack:
    """One submission, and what must hold of its result."""

    name: str
    write: Callable[[Path], None]
    """Writes the submission into its folder ``submitted/<student>/<assignment>/``."""
    most: float
    """What it may earn."""
    status: str = "graded"
    exercise: str | None = None
    """Status of the exercise ``double``, where it matters."""


def _notebook(value: dict[str, Any]) -> Callable[[Path], None]:
    return lambda folder: _forget(toy.write(folder / f"{toy.NAME}.ipynb", value))


def _forget(_: object) -> None:
    """Drop what a call returned."""


def _double(
    name: str, source: str, most: float = APPLY_POINTS, exercise: str | None = None
) -> Attack:
    return Attack(name, _notebook(toy.answer(double=source)), most, exercise=exercise)


def _bytes(name: str, data: bytes) -> Attack:
    def write(folder: Path) -> None:
        folder.mkdir(parents=True)
        (folder / f"{toy.NAME}.ipynb").write_bytes(data)

    return Attack(name, write, 0, status="refused")


def _from_file() -> Iterator[Attack]:
    text = Path(__file__).with_name("hostile_cells.txt").read_text(encoding="utf-8")
    for part in text.split("\n=== ")[1:]:
        head, _, source = part.partition("\n")
        name, most, *exercise = head.split(" | ")
        yield _double(name, source.replace("<pipe>\n", PIPE), float(most), *exercise)


VALUES = [
    _double(f"returns-{name}", f"def double(x):\n    return {text}\n")
    for name, text in {
        "nan": "np.full(np.shape(x), np.nan)",
        "nothing": "None",
        "complex": "np.asarray(x) * 2j",
        "generator": "(v for v in [6])",
        "object-array": "np.array([6, None], dtype=object)",
        "masked": "np.ma.masked_all(np.shape(x))",
        "wrong-shape": "np.zeros((2, 3, 4))",
        "function": "double",
        "deep-list": "__import__('functools').reduce(lambda a, _: [a], range(2000), 6)",
        "itself": "(lambda a: (a.append(a), a)[1])([])",
        "giant": "np.zeros(5 * 10**6)",
        "giant-integer": "10**100_000",
        "half-a-character": "'\\ud800'",
    }.items()
]
TEXTS = [
    _double("no-text", ""),
    _double("deep-text", "double = " + "-" * 100_000 + "1"),
    _double("long-text", "double = " + "+".join(["1"] * 100_000)),
    _double("null-byte", "def double(x):\n    return 6\0\n"),
]


def _cells(name: str, change: Callable[[list[dict[str, Any]]], object], most: float) -> Attack:
    value = toy.answer(double=WRONG)
    cells = value["cells"]
    cells.insert(3, toy.test_cell(toy.DOUBLE_RANDOM.split("###")[0], "double-random", 6))
    change(cells)
    return Attack(name, _notebook(value), most)


def _tag(cells: list[dict[str, Any]]) -> None:
    for cell in cells:
        cell["metadata"]["tags"] = ["skip-execution", "raises-exception"]


def _forge_points(cells: list[dict[str, Any]]) -> None:
    for cell in cells:
        fields = cell["metadata"]["nbgrader"]
        fields |= {"points": 1e9, "schema_version": 99, "locked": False, "checksum": "0"}
        cell["outputs"] = [{"output_type": "stream", "name": "stdout", "text": "1e9"}]


def _edit_tests(cells: list[dict[str, Any]]) -> None:
    for cell in cells:
        if cell["metadata"]["nbgrader"]["grade"]:
            cell["source"] = "assert True"


def _take_the_tests_place(cells: list[dict[str, Any]]) -> None:
    cells[2] = toy.cell("double = lambda x: 6", "double-by-hand", solution=True, grade=True)


METADATA = [
    _cells("tags", _tag, APPLY_POINTS),
    _cells("points", _forge_points, APPLY_POINTS),
    _cells("edited-tests", _edit_tests, APPLY_POINTS),
    _cells("a-test-that-is-a-solution", _take_the_tests_place, APPLY_POINTS),
    _cells("a-solution-that-is-text", lambda c: c[1].update(cell_type="markdown"), APPLY_POINTS),
    _cells(
        "strange-metadata", lambda c: c[1].update(metadata={"nbgrader": [1, {}]}), APPLY_POINTS
    ),
]


def _with_files(folder: Path) -> None:
    """A wrong answer beside files that would help it if anything read them."""
    _forget(toy.write(folder / f"{toy.NAME}.ipynb", toy.answer(double=WRONG)))
    evil = "import os\nos._exit(0)\n"
    for name in ("numpy.py", "sitecustomize.py", "conftest.py", "msgpack.py", "ipython_config.py"):
        (folder / name).write_text(evil)
    (folder / "robust_slam_autograder").mkdir()
    (folder / "robust_slam_autograder" / "__init__.py").write_text(evil)
    (folder / "autograder.toml").write_text("[limits]\ncall_seconds = 1e9\n")
    (folder / "link").symlink_to("/etc/passwd")
    with open(folder / "big.bin", "wb") as file:
        file.truncate(300 * 2**20)


def _link_to(target: str) -> Callable[[Path], None]:
    def write(folder: Path) -> None:
        folder.mkdir(parents=True)
        (folder / f"{toy.NAME}.ipynb").symlink_to(target)

    return write


def _linked_folder(folder: Path) -> None:
    folder.parent.mkdir(parents=True)
    folder.symlink_to(folder.parents[1] / "neighbour" / toy.NAME)


def _linked_student(folder: Path) -> None:
    folder.parent.symlink_to(folder.parents[1] / "neighbour")


def _pipe_file(folder: Path) -> None:
    folder.mkdir(parents=True)
    os.mkfifo(folder / f"{toy.NAME}.ipynb")


def _two_notebooks(folder: Path) -> None:
    for name in ("one.ipynb", "two.ipynb"):
        _forget(toy.write(folder / name, toy.answer()))


FILES = [
    Attack("files-that-shadow", _with_files, APPLY_POINTS),
    Attack(
        "a-linked-notebook", _link_to(f"../../neighbour/{toy.NAME}/{toy.NAME}.ipynb"), 0, "refused"
    ),
    Attack("a-link-to-a-device", _link_to("/dev/zero"), 0, "refused"),
    Attack("a-linked-folder", _linked_folder, 0, "refused"),
    Attack("a-linked-student", _linked_student, 0, "refused"),
    Attack("a-named-pipe", _pipe_file, 0, "refused"),
    Attack("a-directory", lambda f: (f / f"{toy.NAME}.ipynb").mkdir(parents=True), 0, "refused"),
    Attack("two-notebooks", _two_notebooks, 0, "refused"),
    Attack("no-notebook", lambda folder: folder.mkdir(parents=True), 0, "refused"),
]

_WHOLE = json.dumps(toy.answer())
BROKEN = [
    _bytes("empty", b""),
    _bytes("binary", bytes(range(256))),
    _bytes("half-a-file", _WHOLE[:500].encode()),
    _bytes("utf-16", _WHOLE.encode("utf-16")),
    _bytes("deep", b"[" * 100_000 + b"]" * 100_000),
    _bytes("list", b"[]"),
    _bytes("nbformat-3", _WHOLE.replace('"nbformat": 4', '"nbformat": 3').encode()),
    _bytes("nbformat-99", _WHOLE.replace('"nbformat": 4', '"nbformat": 99').encode()),
    _bytes("nbformat-nested", _WHOLE.replace('"nbformat": 4', '"nbformat": [[[]]]').encode()),
    _bytes("cells-of-numbers", b'{"nbformat": 4, "cells": [1, 2]}'),
    _bytes("text-of-numbers", b'{"nbformat": 4, "cells": [{"cell_type": "code", "source": 1}]}'),
    _bytes("surrogate", _WHOLE.replace("Twice x", "\\ud800").encode()),
    _bytes("too-large", b" " * (21 * 2**20) + _WHOLE.encode()),
    _bytes("too-many-cells", json.dumps(toy.notebook([toy.cell("")] * 5000)).encode()),
    _bytes("not-a-number", _WHOLE.replace('"nbformat": 4', '"nbformat": NaN').encode()),
    _bytes("giant-integer", _WHOLE.replace('"nbformat": 4', '"nbformat": ' + "9" * 5000).encode()),
]
ATTACKS = [*_from_file(), *VALUES, *TEXTS, *METADATA, *FILES, *BROKEN]
