"""Sessions of a few cells, for the grader's own tests."""

import contextlib
from collections.abc import Iterator, Sequence
from typing import Any

from robust_slam_autograder.executor.budget import Meter
from robust_slam_autograder.executor.session import Program, Session
from robust_slam_autograder.reading.assignment import Piece
from robust_slam_autograder.reading.defaults import Limits
from robust_slam_autograder.sandbox import Sandbox

from tests import kernel

AMPLE = Limits(call_seconds=20, cell_seconds=20, notebook_seconds=60)


def program(
    *cells: str, names: Sequence[str] = ("f",), setup: Sequence[str] = (), **options: Any
) -> Program:
    """A program of these cells; ``options`` are more of its fields."""
    return Program(
        setup=[Piece(f"set-up {n}", text, own=False) for n, text in enumerate(setup)],
        pieces=[Piece(f"cell {n}", text, own=False) for n, text in enumerate(cells)],
        names=tuple(names),
        **{"withheld": (), **options},
    )


@contextlib.contextmanager
def started(
    *cells: str, limits: Limits = AMPLE, wall: Sandbox | None = None, **options: Any
) -> Iterator[Session]:
    """A session that has begun; ``options`` are the program's."""
    total = Meter().start(limits.notebook_seconds)
    session = Session(wall or kernel.quickest(), program(*cells, **options), limits, total)
    try:
        session.begin()
        yield session
    finally:
        session.close()
