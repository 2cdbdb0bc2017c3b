"""A Dask cluster for tests: a scheduler and workers, each a process on this machine."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tests.autograder.killing import wait_for

ROOT = Path(__file__).parents[2]
"""Where they start, and so find the benchmarks' packages."""


@dataclass
class Machines:
    """A scheduler, and the workers that a test starts."""

    folder: Path
    processes: list[subprocess.Popen[bytes]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._file = self.folder / "scheduler.json"
        where = ["--host", "127.0.0.1", "--port", "0", "--scheduler-file", str(self._file)]
        self._start("scheduler", *where)
        # The file is there before it is written.
        wait_for(lambda: self._file.exists() and self._file.read_text().endswith("}"))
        self.address = json.loads(self._file.read_text())["address"]

    def worker(self, *options: str) -> subprocess.Popen[bytes]:
        """Start one."""
        where = ["--scheduler-file", str(self._file), "--local-directory", str(self.folder)]
        return self._start("worker", *where, "--nthreads", "1", *options)

    def _start(self, what: str, *options: str) -> Any:
        command = [sys.executable, "-m", "dask", what, "--no-dashboard", *options]
        with open(self.folder / f"{what}-{len(self.processes)}.log", "wb") as log:
            process = subprocess.Popen(command, cwd=ROOT, stdout=log, stderr=log)
        self.processes.append(process)
        return process

    def stop(self) -> None:
        """Kill them all: what they have started ends with them, and to say goodbye takes long."""
        for process in reversed(self.processes):
            process.kill()
            process.wait()
