"""CPU seconds of several ways to do one thing, taken in turns."""

from __future__ import annotations

import gc
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from statistics import median
from typing import Any

from benchmarks.apart import Ended, apart

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

    def __str__(self) -> str:
        """Return the seconds for the reader, such as `41.2 ms` or `3.40 s (once)`."""
        if self.stopped:
            return f"stopped after {self.seconds:.0f} s"
        short = self.seconds < 1.0
        number = f"{1e3 * self.seconds:.1f} ms" if short else f"{self.seconds:.2f} s"
        return number if self.runs > 1 else f"{number} (once)"


@dataclass(frozen=True)
class Figure:
    """What the ``other`` side spent, ours by the name of each way, and a remark on both."""

    other: Spent
    ours: dict[str, Spent]
    remark: str

    @property
    def ratios(self) -> str:
        """Other ÷ ours of each way; a lower bound, `> VALUE`, where the other was stopped."""
        bound = "> " if self.other.stopped else ""
        return " ".join(
            f"{bound}{self.other.seconds / spent.seconds:.2f} {way}"
            for way, spent in self.ours.items()
        )


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
    try:
        return apart(partial(spend, side), LIMIT)
    except Ended as ended:
        if ended.over:
            return Spent(float(LIMIT), None, stopped=True)
        raise RuntimeError(f"{side.name} fails: {ended}") from None
    except RuntimeError as error:
        raise RuntimeError(f"{side.name} fails: {error}") from None


def in_turns(
    sides: Sequence[Side], measure: Callable[[Side], Spent] = spend, runs: int = RUNS
) -> dict[str, Spent]:
    """Return what each side takes, by its name: all run once, then all again, ``runs`` times.

    A side that takes longer than ``LONG`` seconds is not run again.
    """
    spent = {side.name: [measure(side)] for side in sides}
    for _ in range(runs - 1):
        for side in sides:
            if spent[side.name][0].seconds <= LONG:
                spent[side.name].append(measure(side))
    return {
        name: Spent(median(one.seconds for one in own), own[0].answer, len(own), own[0].stopped)
        for name, own in spent.items()
    }
