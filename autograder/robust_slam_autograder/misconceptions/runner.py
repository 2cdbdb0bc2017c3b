"""Runs what may have been a wrong answer of a batch, in one process for all of them.

What all runs have in common is paid for once: the instructor's notebook, and what its solutions
return. What these import, the server of trusted processes has imported for the batch already. A
run ends at the first case that goes otherwise than in the answer.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from multiprocessing.connection import Connection, Pipe
from multiprocessing.context import ForkServerProcess

from robust_slam_autograder.executor import guarded, trusted
from robust_slam_autograder.misconceptions import bench as benches
from robust_slam_autograder.misconceptions import survey
from robust_slam_autograder.misconceptions.bench import Setting
from robust_slam_autograder.misconceptions.candidates import Candidate
from robust_slam_autograder.misconceptions.shapes import Shape
from robust_slam_autograder.misconceptions.tables import Table

TIMES_LONGER = 10.0
"""How much longer than in the survey a candidate may take, so that no clock decides on a label."""

Answer = Table | tuple[str, ...] | None
"""To an exercise its table, without labels; to a candidate its keys."""


@dataclass
class Runner:
    """Runs an assignment's candidates in one setting; ``close`` ends its process."""

    setting: Setting
    _child: ForkServerProcess | None = None
    _connection: Connection | None = None
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
        """End the process."""
        if self._child is not None and self._connection is not None:
            self._child.kill()
            self._child.join()
            self._connection.close()
        self._child = self._connection = None

    def _asked(self, exercise: str, pair: tuple[Candidate, Shape] | None = None) -> Answer:
        try:
            if self._connection is None:
                self._connection, other = Pipe()
                self._child = trusted.start(_serve, self.setting, other)
                other.close()
            self._connection.send((exercise, pair))
            answer: Answer = self._connection.recv()
            return answer
        except Exception:  # a label is worth no batch
            self.close()
            return None


def _serve(setting: Setting, connection: Connection) -> None:
    """Be the child: answer each request."""
    guarded.guard()
    bench = benches.bench(setting)
    tables: dict[str, tuple[Table, float]] = {}
    while True:
        exercise, pair = connection.recv()
        if exercise not in tables:
            began = time.process_time()
            table = survey.right_of(bench, exercise)
            seconds = max(survey.SHORTEST, survey.TIMES_LONGER * (time.process_time() - began))
            tables[exercise] = table, TIMES_LONGER * seconds
        table, seconds = tables[exercise]
        if pair is None:
            connection.send(table)
        else:
            one, like = pair
            found = survey.shape_of(bench, exercise, one, table.right, seconds, like=like)
            connection.send(found.keys())
