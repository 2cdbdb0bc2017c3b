"""By which digests the wrong answers to an exercise have which label.

A label can be read by those alone whose answer has its key, so a table may go to students: it
tells no one what could be wrong, but only what is.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

FILE = "misconceptions.json"
"""In a release, the tables of its visible cases."""
Table = Mapping[str, str]
"""By half of a key, the label, which the key opens; empty where that is not one thing."""


def sentence(table: Table, keys: Sequence[str]) -> str:
    """Say what answers of these keys look like; empty where nothing fits, or two things do."""
    said = {_opened(table[_place(key)], key) for key in keys if _place(key) in table}
    return said.pop() if len(said) == 1 else ""


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
    text = json.dumps(tables, separators=(",", ":"), sort_keys=True)
    path.write_text(f"{text}\n", "utf-8")


def read(path: Path) -> dict[str, Table]:
    """Read what ``write`` has written; none where there is no such file, or another one."""
    try:
        return made(json.loads(path.read_text(encoding="utf-8")))
    except (OSError, ValueError, TypeError, AttributeError, RecursionError):
        return {}


def made(data: Any) -> dict[str, Table]:  # noqa: ANN401
    """Make the tables of what a file holds of them.

    Raises:
        ValueError, TypeError, AttributeError: it holds anything else.
    """
    found: dict[str, Table] = {name: dict(table.items()) for name, table in data.items()}
    for text in (text for table in found.values() for text in table.values()):
        bytes.fromhex(text)
    return found
