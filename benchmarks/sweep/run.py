"""Do the runs of the worlds, each in a process of its own with a limit on its CPU time."""

from __future__ import annotations

import multiprocessing
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from functools import partial

from robust_slam.errors import NotConverged, Underdetermined

from benchmarks import methods
from benchmarks.apart import Ended, apart
from benchmarks.methods import Made
from benchmarks.sweep.definition import CPU_LIMIT, World, make
from benchmarks.sweep.journal import Run

Task = tuple[World, tuple[str, ...]]
"""A world and the methods that are missing there."""


def do(tasks: Sequence[Task], jobs: int = 1) -> Iterator[Run]:
    """Yield the runs of the tasks as they end, here or in several processes.

    Raises:
        ValueError: ``jobs`` is below 1.
    """
    if jobs == 1:
        for task in tasks:
            yield from run_world(*task)
        return
    with ProcessPoolExecutor(jobs, multiprocessing.get_context("spawn")) as pool:
        try:
            for done in as_completed([pool.submit(_all, task) for task in tasks]):
                yield from done.result()
        finally:
            pool.shutdown(cancel_futures=True)


def _all(task: Task) -> list[Run]:
    return list(run_world(*task))


def run_world(world: World, names: Sequence[str], limit: int = CPU_LIMIT) -> Iterator[Run]:
    """Yield what comes of each method named, in a world that is made once for all of them.

    Raises:
        DatasetMissing: a public graph is not on this machine.
        RuntimeError: a method ended in an error that a sweep does not count on.
    """
    made = make(world)
    for name in names:
        try:
            yield apart(partial(_run, world, name, made), limit)
        except Ended as ended:
            why = f"over {limit} s" if ended.over else str(ended)
            yield Run(world, name, None, float(limit), why)
        except RuntimeError as error:
            raise RuntimeError(f"{name} in {world}: {error}") from None


def _run(world: World, name: str, made: Made) -> Run:
    began = time.process_time()
    try:
        score = methods.run(name, made)
    except (NotConverged, Underdetermined) as error:
        return Run(world, name, None, time.process_time() - began, type(error).__name__)
    return Run(world, name, score, score.seconds)
