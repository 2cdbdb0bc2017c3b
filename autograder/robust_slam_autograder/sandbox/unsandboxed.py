"""No wall at all."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import tempfile
from dataclasses import dataclass

from robust_slam_autograder.sandbox import terms
from robust_slam_autograder.sandbox.process import Piped
from robust_slam_autograder.sandbox.terms import ENVIRONMENT, Launch


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
        process = subprocess.Popen(
            terms.python_command(launch),
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
