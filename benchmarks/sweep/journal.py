"""What has been run, a line of JSON for each run: a sweep that was killed goes on from there.

A line counts when it is whole and of the sweep as it is defined now.
"""

import json
from dataclasses import asdict, dataclass
from pathlib import Path

from benchmarks.methods import Score
from benchmarks.sweep.definition import World, digest

Key = tuple[World, str]
"""A world, and the method that answered for it."""


@dataclass(frozen=True)
class Run:
    """What came of one method in one world: a score, or why there is none.

    ``failed`` is empty, or the reason; ``seconds`` are of CPU time either way, NaN where an entry
    does not tell them.
    """

    world: World
    method: str
    score: Score | None
    seconds: float
    failed: str = ""

    @property
    def key(self) -> Key:
        """What the run is known by."""
        return self.world, self.method


def append(path: Path, run: Run) -> None:
    """Add a run to the journal; what a kill left of a line before is ended first."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("a+b") as file:
        if file.tell() > 0:
            file.seek(-1, 2)
            if file.read(1) != b"\n":
                file.write(b"\n")
        line = {"sweep": digest(), **asdict(run), "world": run.world._asdict()}
        file.write(json.dumps(line).encode() + b"\n")


def read(path: Path) -> dict[Key, Run]:
    """Return the runs of this sweep that the journal holds; half lines and others are left."""
    if not path.exists():
        return {}
    lines = path.read_bytes().splitlines()
    runs = [run for run in map(_run, lines) if run is not None]
    return {run.key: run for run in runs}


def _run(line: bytes) -> Run | None:
    try:
        entry = json.loads(line)
    except ValueError:
        return None
    if not isinstance(entry, dict) or entry.pop("sweep", None) != digest():
        return None
    score = entry["score"]
    return Run(
        World(**entry["world"]),
        entry["method"],
        None if score is None else Score(**score),
        entry["seconds"],
        entry["failed"],
    )
