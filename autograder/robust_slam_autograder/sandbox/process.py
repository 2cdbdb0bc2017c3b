"""An untrusted process that we started ourselves."""

from __future__ import annotations

import contextlib
import os
import select
import signal
import subprocess
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from robust_slam_autograder.protocol.channel import Channel, Check
from robust_slam_autograder.sandbox import cpu
from robust_slam_autograder.sandbox.cpu import CpuClock
from robust_slam_autograder.student import untrusted

START_SECONDS = 60.0


@dataclass(frozen=True)
class Process:
    """An untrusted process with its pipes, and the scratch folder that goes with it."""

    process: subprocess.Popen[bytes]
    scratch: tempfile.TemporaryDirectory[str] | None = None

    def pipes(self) -> tuple[int, int]:
        """Return descriptors to read its messages from and to write ours to."""
        assert self.process.stdin and self.process.stdout
        return self.process.stdout.fileno(), self.process.stdin.fileno()

    def connect(self, check: Check) -> Channel:
        """Begin the conversation with it; ``check`` as in ``Conversation``."""
        return Channel(*self.pipes(), check=check, widen=True)

    @cached_property
    def _clock(self) -> CpuClock:
        return cpu.clock_of(self.process.pid)

    def cpu_seconds(self) -> float:
        """Return the CPU time that it has used, with all its threads."""
        return self._clock.seconds()

    def await_ready(self) -> str | None:
        """Wait until it answers; else say what it wrote to its standard error."""
        assert self.process.stderr
        reader, _ = self.pipes()
        answers = select.select([reader], [], [], START_SECONDS)[0]
        if answers and os.read(reader, len(untrusted.READY)) == untrusted.READY:
            return None
        self.process.kill()
        said = self.process.stderr.read().decode(errors="replace").strip()
        return said[-500:] or "it says nothing"

    def stop(self) -> None:
        """End it and all that it started, and remove its scratch folder."""
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(self.process.pid, signal.SIGKILL)
        self.process.kill()
        self.process.wait()
        for pipe in (self.process.stdin, self.process.stdout, self.process.stderr):
            if pipe is not None:
                with contextlib.suppress(OSError):
                    pipe.close()
        if self.scratch is not None:
            self.scratch.cleanup()


def popen(
    command: Sequence[str], cwd: str, environment: dict[str, str], pass_fds: Sequence[int] = ()
) -> subprocess.Popen[bytes]:
    """Start a command with pipes for its standard streams, in a session of its own."""
    return subprocess.Popen(
        command,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        cwd=cwd,
        env=environment,
        pass_fds=pass_fds,
        start_new_session=True,
    )
