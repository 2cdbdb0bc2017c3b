"""Do the runs of the worlds, each in a process of its own with a limit on its CPU time.

A limit in the process that works would not do: a solver in compiled code hears of nothing until it
is done.
"""

import multiprocessing
import resource
import signal
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing.connection import Connection

from robust_slam.errors import NotConverged, Underdetermined

from benchmarks import methods
from benchmarks.methods import Made
from benchmarks.sweep.definition import CPU_LIMIT, World, make
from benchmarks.sweep.journal import Run

Task = tuple[World, tuple[str, ...]]
"""A world and the methods that are missing there."""
_FORK = multiprocessing.get_context("fork")
_GRACE = 5
"""Seconds between the signal that the time is over and the kernel's end."""


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
        yield _apart(world, name, made, limit)


def _apart(world: World, name: str, made: Made, limit: int) -> Run:
    receiver, sender = _FORK.Pipe(duplex=False)
    process = _FORK.Process(target=_answer, args=(sender, world, name, made, limit))
    process.start()
    sender.close()
    try:
        run: Run = receiver.recv()
    except EOFError:
        process.join()
        ended = -(process.exitcode or 0)
        if ended <= 0:
            raise RuntimeError(f"{name} in {world}: see the error above") from None
        is_over = ended == signal.SIGXCPU
        why = f"over {limit} s" if is_over else signal.Signals(ended).name
        return Run(world, name, None, float(limit), why)
    process.join()
    return run


def _answer(sender: Connection, world: World, name: str, made: Made, limit: int) -> None:
    resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + _GRACE))
    began = time.process_time()
    try:
        score = methods.run(name, made)
        run = Run(world, name, score, score.seconds)
    except (NotConverged, Underdetermined) as error:
        run = Run(world, name, None, time.process_time() - began, type(error).__name__)
    sender.send(run)
