"""Who does the runs: this machine, in one process or in several.

An executor takes tasks, a world and the methods that are missing there, and yields runs as
they end, in any order.
"""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed

from benchmarks.sweep.definition import World
from benchmarks.sweep.journal import Run
from benchmarks.sweep.run import run_world

Task = tuple[World, tuple[str, ...]]
Executor = Callable[[Sequence[Task]], Iterator[Run]]


def here(tasks: Sequence[Task]) -> Iterator[Run]:
    """Do one task after the other."""
    for task in tasks:
        yield from run_world(*task)


def processes(jobs: int) -> Executor:
    """Return an executor of ``jobs`` processes; for 1 there is none but this one.

    Raises:
        ValueError: ``jobs`` is below 1.
    """
    if jobs < 1:
        raise ValueError(f"jobs is {jobs}; give at least 1")

    def execute(tasks: Sequence[Task]) -> Iterator[Run]:
        with ProcessPoolExecutor(jobs, multiprocessing.get_context("spawn")) as pool:
            try:
                for done in as_completed([pool.submit(_all, task) for task in tasks]):
                    yield from done.result()
            finally:
                pool.shutdown(cancel_futures=True)

    return here if jobs == 1 else execute


def _all(task: Task) -> list[Run]:
    return list(run_world(*task))
