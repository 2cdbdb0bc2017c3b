"""Reads a notebook strictly: plain cells, or one sentence that says what to fix.

A submission is hostile until shown otherwise. Only a regular file is opened,
links are not followed, and nothing in the file is trusted beyond its text.
"""

import codecs
import errno
import json
import math
import os
import re
import stat
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from robust_slam_autograder.errors import Refused

MAX_BYTES = 20 * 1024 * 1024
MAX_CELLS = 500
MAX_VALUES = 1_000_000
"""Each value of the JSON may take some 200 bytes of memory, though it is two bytes long."""
MAX_NAME = 80
_CLEAR = "clear its outputs and save it again"
_UNREADABLE = {UnicodeDecodeError: "not UTF-8 text", RecursionError: "nested too deeply"}
_VERSION = re.compile(r"(\d{1,3})\.(\d{1,3})\b")


@dataclass(frozen=True)
class Cell:
    """One cell: its text and what nbgrader's metadata says of it."""

    kind: str
    """"code", "markdown" or "raw"."""
    source: str
    grade_id: str | None = None
    """nbgrader's name of the cell, None where it has none."""
    grade: bool = False
    """The cell is a test (or a free-text answer) that carries points."""
    solution: bool = False
    """The cell is the student's to write."""
    locked: bool = False
    """The cell is the instructor's."""
    task: bool = False
    """The cell asks for work in the student's own cells, which a person marks."""
    points: float = 0.0


class Notebook(tuple[Cell, ...]):
    """A notebook's cells, in their order."""

    python: tuple[int, int] | None = None
    """By the file's own account, the Python that it was written in; None where it does not say."""


def read(path: Path) -> Notebook:
    """Read a notebook's cells.

    Raises:
        Refused: the file is no readable nbformat 4 notebook; the sentence names it and the fix.
    """
    return parse(read_bytes(path), shown(path.name))


def shown(name: str) -> str:
    """Return a name that somebody else chose, made fit to stand in a message."""
    printable = "".join(letter if letter.isprintable() else "?" for letter in name)
    return printable if len(printable) <= MAX_NAME else f"{printable[: MAX_NAME - 1]}…"


def read_bytes(path: Path) -> bytes:
    """Read a regular file of at most 20 MiB without following a link.

    Raises:
        Refused: the path is missing, a link, a directory, a device or a pipe, or too large.
    """
    name = shown(path.name)
    try:
        with open(path, "rb", opener=_without_links) as file:
            is_plain = stat.S_ISREG(os.fstat(file.fileno()).st_mode)
            data = file.read(MAX_BYTES + 1) if is_plain else b""
    except IsADirectoryError:
        is_plain = False
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or str(error)
        if getattr(error, "errno", None) == errno.ELOOP:
            why = "it is a link"
        raise Refused(f"{name} cannot be opened ({why}): hand in a plain file.") from error
    if not is_plain:
        raise Refused(f"{name} is not a regular file: hand in the notebook itself.")
    if len(data) > MAX_BYTES:
        raise Refused(f"{name} is larger than {MAX_BYTES // 2**20} MiB: {_CLEAR}.")
    return data


def _without_links(path: str, flags: int) -> int:
    flags |= os.O_NOFOLLOW
    # Opening a named pipe must not wait for a writer. A browser has none, and JupyterLite would
    # take a file with this flag for one that was written.
    if sys.platform != "emscripten":
        flags |= os.O_NONBLOCK
    return os.open(path, flags)


def parse(data: bytes, name: str) -> Notebook:
    """Turn a notebook's bytes into cells; ``name`` is the file's name for messages.

    Raises:
        Refused: not UTF-8, not JSON, not nbformat 4, too many cells, or a wrong type.
    """
    notebook = _json_object(data, name)
    version = notebook.get("nbformat")
    if version != 4:
        known = version in range(100)
        found = f"nbformat {int(version or 0)}" if known else "of an unknown format"
        raise Refused(f"{name} is {found}, not nbformat 4: open it in JupyterLab and save it.")
    cells = notebook.get("cells")
    if not isinstance(cells, list):
        raise Refused(f"{name} has no list of cells: open it in JupyterLab and save it.")
    if len(cells) > MAX_CELLS:
        raise Refused(f"{name} has more than {MAX_CELLS} cells: delete those you do not need.")
    read = Notebook(_cell(cell, position, name) for position, cell in enumerate(cells, start=1))
    match notebook.get("metadata"):
        case {"language_info": {"name": "python", "version": str(told)}}:
            read.python = (int(v[1]), int(v[2])) if (v := _VERSION.match(told)) else None
    return read


def _json_object(data: bytes, name: str) -> dict[str, Any]:
    if sum(data.count(mark) for mark in (b",", b"[", b"{")) > MAX_VALUES:
        raise Refused(f"{name} holds more than {MAX_VALUES:,} values: {_CLEAR}.")
    try:
        # As a float, for an integer of many digits is an error, or slow.
        value = json.loads(data.decode("utf-8-sig"), parse_int=float)
    except (ValueError, RecursionError) as error:
        is_empty = not data.removeprefix(codecs.BOM_UTF8).strip()
        why = _UNREADABLE.get(type(error), "empty" if is_empty else "not valid JSON")
        raise Refused(f"{name} is {why}: save it again from JupyterLab.") from error
    if not isinstance(value, dict):
        raise Refused(f"{name} is JSON but no notebook: hand in the .ipynb file.")
    return value


def _cell(cell: object, position: int, name: str) -> Cell:
    if not isinstance(cell, dict):
        raise Refused(f"Cell {position} of {name} is not a cell: save it again from JupyterLab.")
    source = cell.get("source", "")
    if isinstance(source, list) and all(isinstance(line, str) for line in source):
        source = "".join(source)
    if not isinstance(source, str) or not isinstance(cell.get("cell_type"), str):
        raise Refused(f"Cell {position} of {name} has no text: save it again from JupyterLab.")
    try:
        source.encode()
    except UnicodeEncodeError as error:
        raise Refused(f"Cell {position} of {name} holds half a character: delete it.") from error
    source = source.replace("\r\n", "\n").replace("\r", "\n")
    return Cell(kind=cell["cell_type"], source=source, **_nbgrader_metadata(cell))


def _nbgrader_metadata(cell: dict[str, Any]) -> dict[str, Any]:
    """Read nbgrader's fields, dropping each that has a wrong type: metadata is never trusted."""
    metadata = cell.get("metadata")
    fields = metadata.get("nbgrader") if isinstance(metadata, dict) else None
    if not isinstance(fields, dict):
        return {}
    grade_id = fields.get("grade_id")
    points = fields.get("points")
    return {
        **{key: fields.get(key) is True for key in ("grade", "solution", "locked", "task")},
        "grade_id": grade_id if isinstance(grade_id, str) else None,
        "points": points if isinstance(points, float) and math.isfinite(points) else 0.0,
    }
