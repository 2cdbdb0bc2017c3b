"""One shell for a whole page."""

import contextlib
import os
import select
import signal
import subprocess
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Said:
    """What a command printed, and its exit status."""

    status: int
    text: str


class Terminal:
    """A shell that logs all that is printed: what a command exports is there for the next."""

    def __init__(self, folder: Path, environment: Mapping[str, str], log: Path) -> None:
        self._log = log
        commands, self._type = os.pipe()
        self._statuses, self._told = os.pipe()
        with log.open("ab") as output:
            self._shell = subprocess.Popen(
                ["bash", "--noprofile", "--norc", f"/dev/fd/{commands}"],
                cwd=folder, env=environment, start_new_session=True,
                stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.STDOUT,
                pass_fds=(commands, self._told),
            )  # fmt: skip
        os.close(commands)

    def run(self, command: str) -> Said:
        """Type a command, and wait until the shell is ready for the next.

        Raises:
            RuntimeError: the shell has ended.
        """
        before = self._log.stat().st_size
        os.write(self._type, f"{command}\nprintf '%d\\n' $? >&{self._told}\n".encode())
        status = b""
        while not status.endswith(b"\n"):
            # What it started may hold the pipe open after its end.
            if select.select([self._statuses], [], [], 1.0)[0]:
                status += os.read(self._statuses, 1)
            elif self._shell.poll() is not None:
                raise RuntimeError(f"the shell ended at: {command}")
        said = self._log.read_bytes()[before:]
        return Said(int(status), said.decode("utf-8", errors="replace"))

    def close(self) -> None:
        """End the shell, and what was started in it."""
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self._shell.pid, signal.SIGTERM)
        self._shell.wait()
        for pipe in (self._type, self._statuses, self._told):
            os.close(pipe)
