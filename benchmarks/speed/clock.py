"""CPU seconds of several ways to do one thing, taken in turns."""

from __future__ import annotations

import gc
import multiprocessing
import resource
import signal
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection
from statistics import median
from typing import Any

RUNS = 5
LONG = 20.0
"""Seconds; what takes longer runs once."""
LIMIT = 120
"""Seconds, whole: where ``spend_apart`` stops."""
_ONE_THREAD = 1.05
_NOISE = 0.01


@dataclass(frozen=True)
class Side:
    """One way to do it.

    Attributes:
        name: what it is called.
        run: the task, under the clock.
        read: what is wanted of its answer, by default all; not under the clock.
    """

    name: str
    run: Callable[[], Any]
    read: Callable[[Any], Any] = lambda answer: answer


@dataclass(frozen=True)
class Spent:
    """CPU seconds, the median of ``runs``, and the answer, None where it was ``stopped``."""

    seconds: float
    answer: Any
    runs: int = 1
    stopped: bool = False


def spend(side: Side) -> Spent:
    """Run ``side`` here.

    Raises:
        RuntimeError: more than one thread was at work.
    """
    # What the last run left is not cleared away at this one's cost.
    gc.collect()
    all_threads, own = time.process_time(), time.thread_time()
    answer = side.run()
    all_threads, own = time.process_time() - all_threads, time.thread_time() - own
    if all_threads > _ONE_THREAD * own + _NOISE:
        raise RuntimeError(
            f"{side.name}: all threads took {all_threads:.3f} s, of which the first took "
            f"{own:.3f} s; let it run on one"
        )
    return Spent(all_threads, side.read(answer))


def spend_apart(side: Side) -> Spent:
    """Run ``side`` in a process of its own, which is stopped at ``LIMIT`` seconds of CPU time.

    Raises:
        RuntimeError: it fails.
    """
    context = multiprocessing.get_context("fork")
    receiver, sender = context.Pipe(duplex=False)
    process = context.Process(target=_report, args=(side, sender))
    process.start()
    sender.close()
    try:
        spent: Spent | Exception | None = receiver.recv()
    except EOFError:
        spent = None
    process.join()
    if isinstance(spent, Spent):
        return spent
    if process.exitcode == -signal.SIGXCPU:
        return Spent(float(LIMIT), None, stopped=True)
    raise RuntimeError(f"{side.name} fails: {spent or f'exit status {process.exitcode}'}")


def _report(side: Side, sender: Connection) -> None:
    resource.setrlimit(resource.RLIMIT_CPU, (LIMIT, resource.RLIM_INFINITY))
    try:
        sender.send(spend(side))
    except Exception as error:
        sender.send(error)


def in_turns(
    sides: Sequence[Side], measure: Callable[[Side], Spent] = spend, runs: int = RUNS
) -> list[Spent]:
    """Return what each side takes: all run once, then all again, up to ``runs`` times.

    A side that takes longer than ``LONG`` seconds is not run again.
    """
    spent = [[measure(side)] for side in sides]
    for _ in range(runs - 1):
        for side, own in zip(sides, spent, strict=True):
            if own[0].seconds <= LONG:
                own.append(measure(side))
    return [
        Spent(median(one.seconds for one in own), own[0].answer, len(own), own[0].stopped)
        for own in spent
    ]
