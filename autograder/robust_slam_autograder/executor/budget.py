"""Time limits that count work: CPU seconds of the student's processes and of this one.

On a busy machine a process waits for its turn, and that is no one's fault. So a limit is
in CPU seconds. Code that sleeps uses none: it is ended after several times its limit on
the clock of the wall. ``reading.assignment`` has the limits where an assignment names none.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

WALL_FACTOR = 3.0
"""Seconds by the clock of the wall for each second of a limit."""


class Meter:
    """CPU seconds used for one submission, by this process and its untrusted ones."""

    def __init__(self) -> None:
        self._ended = 0.0
        self._running: Callable[[], float] | None = None

    def follow(self, cpu_seconds: Callable[[], float]) -> None:
        """Count a new untrusted process, from now on."""
        self.leave()
        self._ended -= cpu_seconds()
        self._running = cpu_seconds

    def leave(self) -> None:
        """Count what the untrusted process has used as used up, before it is ended."""
        if self._running is not None:
            self._ended += self._running()
            self._running = None

    def seconds(self) -> float:
        """Return the CPU seconds so far."""
        theirs = self._running() if self._running is not None else 0.0
        return time.process_time() + self._ended + theirs

    def start(self, seconds: float) -> Deadline:
        """Begin a limit now."""
        return Deadline(self, seconds, self.seconds(), time.monotonic())


@dataclass(frozen=True)
class Deadline:
    """A limit in CPU seconds, which also ends some time after its begin by the clock."""

    meter: Meter
    limit: float
    """CPU seconds."""
    cpu: float
    """The meter at its begin."""
    begin: float
    """``time.monotonic`` at its begin."""

    def left(self) -> float:
        """Return seconds for which it is surely not over; 0 or less where it is."""
        return soonest([self])

    def used(self) -> float:
        """Return the CPU seconds since its begin."""
        return self.meter.seconds() - self.cpu


def soonest(deadlines: list[Deadline]) -> float:
    """Say for how many seconds none of some deadlines is over; 0 or less where one is."""
    cpu, now = deadlines[0].meter.seconds(), time.monotonic()
    return min(
        min(one.limit - cpu + one.cpu, one.limit * WALL_FACTOR - now + one.begin)
        for one in deadlines
    )
