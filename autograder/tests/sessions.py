"""Sessions of a few cells, for the grader's own tests."""

import contextlib
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from robust_slam_autograder.executor.budget import Meter
from robust_slam_autograder.executor.session import Session
from robust_slam_autograder.reading.assignment import Assignment, Config, Limits, Piece, Solution
from robust_slam_autograder.sandbox import Sandbox

AMPLE = Limits(call_seconds=20, cell_seconds=20, notebook_seconds=60)


@contextlib.contextmanager
def started(
    *cells: str,
    names: Sequence[str] = ("f",),
    setup: Sequence[str] = (),
    wall: Sandbox | None = None,
    limits: Limits = AMPLE,
    **options: Any,
) -> Iterator[Session]:
    """A session of these cells that has begun; ``options`` are of the assignment's settings."""
    assignment = Assignment(
        name="",
        path=Path(),
        setup=tuple(Piece(f"set-up {n}", text, own=False) for n, text in enumerate(setup)),
        imports=(),
        libraries=(),
        solutions=(Solution("", tuple(names)),),
        cases=(),
        config=Config(limits=limits, **options),
        given=frozenset(),
        marked=(),
    )
    pieces = [Piece(f"cell {n}", text, own=False) for n, text in enumerate(cells)]
    total = Meter().start(limits.notebook_seconds)
    if wall is None:
        from . import kernel  # which needs pytest, and an interpreter of others has none

        wall = kernel.quickest()
    session = Session(wall, assignment, pieces, total)
    try:
        session.begin()
        yield session
    finally:
        session.close()
