"""Runs what may have been a wrong answer of a batch, in one child process for all of them.

What all runs have in common is paid for once: the imports, the instructor's notebook, and what
its solutions return. A run ends at the first case that goes otherwise than in the answer.
"""

from __future__ import annotations

import functools
import gc
from collections.abc import Generator, Iterator
from dataclasses import dataclass, field
from multiprocessing.connection import Connection, Pipe

from robust_slam_autograder.executor import guarded
from robust_slam_autograder.misconceptions import survey
from robust_slam_autograder.misconceptions.candidates import Candidate
from robust_slam_autograder.misconceptions.shapes import Shape
from robust_slam_autograder.misconceptions.survey import Setting
from robust_slam_autograder.misconceptions.tables import Table

TIMES_LONGER = 10.0
"""How much longer than in the survey a candidate may take, so that no clock decides on a label."""

Answer = Table | tuple[str, ...] | None
"""To an exercise its table, without labels; to a candidate its keys."""


@dataclass
class Runner:
    """Runs an assignment's candidates in one setting; ``close`` ends its process."""

    setting: Setting
    _child: Iterator[Answer] | None = None
    _requests: Connection | None = None
    _tables: dict[str, Table | None] = field(default_factory=dict)

    def table(self, exercise: str) -> Table | None:
        """Return what the solution returns; None where that cannot be found out."""
        if exercise not in self._tables:
            found = self._asked(exercise)
            self._tables[exercise] = found if isinstance(found, Table) else None
        return self._tables[exercise]

    def keys(self, exercise: str, candidate: Candidate, like: Shape) -> tuple[str, ...]:
        """Return the keys of what a candidate returns; none where it is not like an answer."""
        found = self._asked(exercise, (candidate, like.plain()))
        return found if isinstance(found, tuple) else ()

    def close(self) -> None:
        """End the process, of which another batch would see the locks."""
        child, self._child = self._child, None
        if isinstance(child, Generator):
            child.close()

    def _asked(self, exercise: str, pair: tuple[Candidate, Shape] | None = None) -> Answer:
        try:
            if self._child is None or self._requests is None:
                reader, self._requests = Pipe(duplex=False)
                self._child = guarded.guarded(functools.partial(_serve, self.setting, reader))
                next(self._child)
            self._requests.send((exercise, pair))
            return next(self._child)
        except Exception:  # a label is worth no batch
            self.close()
            return None


def _serve(setting: Setting, requests: Connection) -> Iterator[Answer]:
    """Be the child: yield once when it is ready, and then an answer to each request."""
    gc.freeze()  # a collection would touch, and so copy, all that was there before
    bench = setting.bench()
    tables: dict[str, tuple[Table, float]] = {}
    yield None
    while True:
        exercise, pair = requests.recv()
        if exercise not in tables:
            table = survey.right_of(bench, exercise)
            seconds = TIMES_LONGER * survey.seconds_of(bench, exercise, table.right)
            tables[exercise] = table, seconds
        table, seconds = tables[exercise]
        if pair is None:
            yield table
        else:
            one, like = pair
            yield survey.shape_of(bench, exercise, one, table.right, seconds, like=like).keys()
