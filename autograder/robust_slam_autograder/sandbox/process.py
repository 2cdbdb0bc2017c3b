"""An untrusted process at the other end of two pipes, and its CPU time as the kernel counts it.

Here is also the back end that starts one without any wall.
"""

import contextlib
import os
import select
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import psutil

from robust_slam_autograder.protocol.channel import Channel, Check
from robust_slam_autograder.sandbox import terms, watch
from robust_slam_autograder.sandbox.terms import ENVIRONMENT, Launch
from robust_slam_autograder.student import untrusted

START_SECONDS = 60.0
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


def _last_started(pid: int) -> int:
    """Return the end of a chain of processes, of which each has started the next."""
    started = watch.children(pid)
    return _last_started(started[-1]) if started else pid


@dataclass(frozen=True)
class Piped:
    """An untrusted process with its pipes; back ends add how it is ended."""

    starter: int
    """Process id of the one that started it, or is it: until student code runs, its last
    descendant is the untrusted process."""
    reader: int
    """Where its messages are read from."""
    writer: int
    """Where ours are written to."""

    def connect(self, check: Check) -> Channel:
        """Begin the conversation with it; ``check`` as in ``Conversation``."""
        return Channel(self.reader, self.writer, check=check, widen=True)

    def await_ready(self) -> str | None:
        """Wait until it answers; else say what it, or who started it, said last."""
        answers = select.select([self.reader], [], [], START_SECONDS)[0]
        if answers and os.read(self.reader, len(untrusted.READY)) == untrusted.READY:
            return None
        return self.last_words() or "it says nothing"

    def last_words(self) -> str:
        """Say why it did not start; empty where that is not known."""
        raise NotImplementedError

    @cached_property
    def _clock(self) -> CpuClock:
        # Made before student code runs, while each has started one other at the most.
        return CpuClock(_last_started(self.starter))

    def cpu_seconds(self) -> float:
        """Return the CPU time that it has used, with all its threads."""
        return self._clock.seconds()


@dataclass(frozen=True)
class Process(Piped):
    """An untrusted process that we started ourselves, in a session of its own."""

    process: subprocess.Popen[bytes]
    scratch: tempfile.TemporaryDirectory[str]

    def last_words(self) -> str:
        """End it, and return what it wrote to its standard error."""
        assert self.process.stderr
        self.process.kill()
        return self.process.stderr.read().decode(errors="replace").strip()[-500:]

    def stop(self) -> None:
        """End it and all that it started, and remove its scratch folder."""
        with self.process:  # which closes its pipes, and waits
            with contextlib.suppress(ProcessLookupError, PermissionError):
                os.killpg(self.process.pid, signal.SIGKILL)
            self.process.kill()
        self.scratch.cleanup()


class Unsandboxed:
    """No wall: the process has the user's own rights. For one's own code only."""

    name = "none"

    def problem(self) -> str | None:
        """Return None: it works everywhere, and guards nothing."""
        return None

    def start(self, launch: Launch) -> Process:
        """Start it in an empty folder of its own, with a clean environment."""
        scratch = tempfile.TemporaryDirectory(prefix="autograder-", ignore_cleanup_errors=True)
        settings = {
            **terms.imports(launch),
            "withheld": launch.withheld,
            "packages": launch.packages,
            "used": launch.used,
            "limits": terms.limits(launch),
        }
        process = subprocess.Popen(
            terms.python_script(Path(untrusted.__file__), settings),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            cwd=scratch.name,
            env=ENVIRONMENT | {"HOME": scratch.name, "MPLCONFIGDIR": scratch.name},
            start_new_session=True,
        )
        assert process.stdin and process.stdout
        pipes = (process.stdout.fileno(), process.stdin.fileno())
        return Process(process.pid, *pipes, process, scratch)
