"""Who does the runs: this machine, in one process or in several, or a Dask cluster.

An executor takes tasks, a world and the methods that are missing there, and yields runs as
they end, in any order.
"""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed

from robust_slam_autograder.executor.dask_workers import Unfit, connected, may_have_children
from robust_slam_autograder.executor.trusted import Broken
from robust_slam_autograder.grading.tasks import code_digest

from benchmarks.sweep.definition import World, digest
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


def on_cluster(address: str) -> Executor:
    """Return an executor of the workers of a Dask scheduler; they want this folder's packages."""

    def execute(tasks: Sequence[Task]) -> Iterator[Run]:
        with connected(address) as cluster:
            for task, runs in cluster.run_each(tasks, lambda task: (_on_worker, _code(), *task)):
                if isinstance(runs, Broken):
                    raise RuntimeError(f"{task}: the sweep {runs.how}")
                yield from runs

    return execute


def _code() -> str:
    return f"{digest()} {code_digest()}"


def _on_worker(code: str, world: World, names: tuple[str, ...]) -> list[Run] | Unfit:
    """Do a task in a process of its own: a worker has threads, and runs are forked."""
    if code != _code():
        return Unfit("its packages or its sweep are not those of this machine")
    may_have_children()
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as pool:
        return pool.submit(_all, (world, names)).result()


def _all(task: Task) -> list[Run]:
    return list(run_world(*task))
