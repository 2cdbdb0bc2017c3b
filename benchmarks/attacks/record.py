"""What became of one submission under one grader: plain data, kept so that a run can go on."""

from __future__ import annotations

import dataclasses
import json
import os
import threading
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

HIDDEN_TESTS = "hidden tests"
OWN_READING = "hidden tests by its own code"
HIDDEN_INPUTS = "hidden inputs"
TOKEN = "token"


@dataclass(frozen=True)
class Record:
    """What became of one submission."""

    marks: Mapping[str, float]
    """By grade id; empty where there are none."""
    leaks: tuple[str, ...] = ()
    """What its student got to see: of the names above."""
    harmed: tuple[str, ...] = ()
    """What it did to others, one sentence each."""
    stopped: str = ""
    """ "stopped" or "hung" where the batch came to no end by it."""


class Records:
    """The records of a run so far, by grader and submission, in a file."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._lock = threading.Lock()
        self._found: dict[str, dict[str, Record]] = {}
        if path.exists():
            for side, rows in json.loads(path.read_text("utf-8")).items():
                self._found[side] = {name: _record(row) for name, row in rows.items()}

    def of(self, side: str) -> dict[str, Record]:
        """The records of one grader."""
        return dict(self._found.get(side, {}))

    def add(self, side: str, records: Mapping[str, Record]) -> None:
        """Keep more records; the file is whole at any time."""
        with self._lock:
            self._found.setdefault(side, {}).update(records)
            rows = {
                side: {name: dataclasses.asdict(record) for name, record in found.items()}
                for side, found in self._found.items()
            }
            half = self._path.with_suffix(".half")
            half.write_text(json.dumps(rows, indent=1), "utf-8")
            os.replace(half, self._path)


def _record(row: dict[str, object]) -> Record:
    return Record(**{key: tuple(v) if isinstance(v, list) else v for key, v in row.items()})  # type: ignore[arg-type]
