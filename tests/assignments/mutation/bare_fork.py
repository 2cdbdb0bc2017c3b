"""The quickest place to run code in: a fork of this process, with no wall at all.

For the reference's own mutants only. What stops them is the grader's time limit, and a limit on
memory.
"""

import os
import signal
from dataclasses import dataclass

from robust_slam_autograder.protocol.channel import Channel, Check
from robust_slam_autograder.sandbox import Launch
from robust_slam_autograder.sandbox.process import CpuClock
from robust_slam_autograder.student import untrusted

MEMORY_BYTES = 4 * 1024**3


@dataclass(frozen=True)
class Child:
    """A fork that answers calls."""

    pid: int
    reader: int
    writer: int

    def connect(self, check: Check) -> Channel:
        """Begin the conversation with it; ``check`` as in ``Conversation``."""
        return Channel(self.reader, self.writer, check=check, widen=True)

    def await_ready(self) -> str | None:
        """Wait until it answers."""
        said = os.read(self.reader, len(untrusted.READY))
        return None if said == untrusted.READY else "it says nothing"

    def cpu_seconds(self) -> float:
        """Return the CPU time that it has used, in seconds."""
        return CpuClock(self.pid).seconds()

    def stop(self) -> None:
        """End it, whatever it does."""
        for descriptor in (self.reader, self.writer):
            os.close(descriptor)
        os.kill(self.pid, signal.SIGKILL)
        os.waitpid(self.pid, 0)


class BareFork:
    """Forks this process, which has imported already what the child will want."""

    name = "none"

    def problem(self) -> str | None:
        """Return None: it works wherever there is fork, and guards nothing."""
        return None

    def start(self, launch: Launch) -> Child:
        """Fork."""
        its_reader, writer = os.pipe()
        reader, its_writer = os.pipe()
        pid = os.fork()
        if pid == 0:
            try:
                os.dup2(its_reader, 0)
                os.dup2(its_writer, 1)
                for descriptor in (its_reader, its_writer, reader, writer):
                    os.close(descriptor)
                untrusted.limit({"RLIMIT_AS": MEMORY_BYTES, "RLIMIT_CORE": 0})
                untrusted.serve(launch.withheld, launch.used, launch.packages)
            finally:
                os._exit(1)  # nothing of the parent's goes on in here
        os.close(its_reader)
        os.close(its_writer)
        return Child(pid, reader, writer)
