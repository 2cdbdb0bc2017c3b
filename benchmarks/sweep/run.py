"""Do the runs of one world, each in a process of its own with a limit on its CPU time.

A limit in the process that works would not do: a solver in compiled code hears of nothing
until it is done. A process is ended from outside, and takes no other with it.
"""

from __future__ import annotations

import multiprocessing
import resource
import signal
import time
from collections.abc import Iterator, Sequence
from multiprocessing.connection import Connection

from robust_slam._arrays import Array, Mask
from robust_slam.errors import NotConverged, Underdetermined
from robust_slam.graphs import PoseGraph

from benchmarks import methods
from benchmarks.methods import Score
from benchmarks.sweep.definition import CPU_LIMIT, World, make
from benchmarks.sweep.journal import Run

_FORK = multiprocessing.get_context("fork")


def run_world(world: World, names: Sequence[str], limit: int = CPU_LIMIT) -> Iterator[Run]:
    """Yield what comes of each method named, in a world that is made once for all of them.

    Raises:
        DatasetMissing: a public graph is not on this machine.
        RuntimeError: a method ended in an error that a sweep does not count on.
    """
    made = make(world)
    for name in names:
        yield _guarded(world, name, made, limit)


def _guarded(world: World, name: str, made: tuple[PoseGraph, Mask, Array], limit: int) -> Run:
    receiver, sender = _FORK.Pipe(duplex=False)
    process = _FORK.Process(target=_answer, args=(sender, world, name, made, limit))
    process.start()
    sender.close()
    try:
        run: Run = receiver.recv()
    except EOFError:
        process.join()
        return Run(world, name, None, float(limit), _why(world, name, process.exitcode, limit))
    process.join()
    return run


def _answer(
    sender: Connection,
    world: World,
    name: str,
    made: tuple[PoseGraph, Mask, Array],
    limit: int,
) -> None:
    spoiled, is_outlier, reference = made
    resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 5))
    began = time.process_time()
    score: Score | None = None
    failed = ""
    try:
        score = methods.run(name, spoiled, is_outlier, reference, methods.STEPS)
    except (NotConverged, Underdetermined) as error:
        failed = type(error).__name__
    seconds = time.process_time() - began if score is None else score.seconds
    sender.send(Run(world, name, score, seconds, failed))


def _why(world: World, name: str, exitcode: int | None, limit: int) -> str:
    if exitcode == -signal.SIGXCPU:
        return f"over {limit} s"
    if exitcode is not None and exitcode < 0:
        return signal.Signals(-exitcode).name
    raise RuntimeError(f"{name} in {world}: see the error above")
