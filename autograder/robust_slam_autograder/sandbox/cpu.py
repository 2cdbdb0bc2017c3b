"""CPU time of an untrusted process, as the kernel counts it."""

from __future__ import annotations

import contextlib
import sys
import time

import psutil

from robust_slam_autograder.sandbox import watch

_OF_A_PROCESS = 2


class CpuClock:
    """Reads the CPU time of a process with all its threads.

    Attributes:
        pid: the process.
    """

    def __init__(self, pid: int) -> None:
        self.pid = pid
        # As clock_getcpuclockid makes it: Linux reads another process's clock in a microsecond.
        self._clock = (~pid << 3) | _OF_A_PROCESS
        self._last = 0.0

    def seconds(self) -> float:
        """Return the CPU seconds so far; of a process that has ended what was last read."""
        with contextlib.suppress(OSError, psutil.Error):
            self._last = self._read()
        return self._last

    def _read(self) -> float:
        if sys.platform == "linux":
            return time.clock_gettime(self._clock)
        times = psutil.Process(self.pid).cpu_times()
        return float(times.user + times.system)


def clock_of(starter: int) -> CpuClock:
    """Return the clock of the process that a starter and its only child's only child … end in.

    To be asked before student code runs, while the starter has started nothing else.
    """
    found = watch.descendants(starter)
    return CpuClock(found[-1].pid if found else starter)
