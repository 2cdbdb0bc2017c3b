"""What every back end starts an untrusted process with: limits, environment, import path."""

import os
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import robust_slam_autograder
from robust_slam_autograder.protocol.channel import Check, Conversation
from robust_slam_autograder.reading.assignment import DEFAULT_PACKAGES
from robust_slam_autograder.sandbox import packages, view

SCRATCH_BYTES = 64 * 1024 * 1024
SCRATCH_FILES = 20_000
"""Files and folders in a scratch folder; each takes a kilobyte of the kernel's memory."""
MEMORY_BYTES = 4 * 1024**3
"""Memory of one sandbox; of one process the kernel counts addresses."""
PROCESSES = 32
"""Processes and threads of one sandbox."""
FIRST_UID = 61_000
UIDS = 4_000
"""As root, a sandbox runs under one of these user ids, which own nothing."""
ENVIRONMENT = {
    "HOME": "/tmp",
    "LANG": "C.UTF-8",
    "MPLBACKEND": "Agg",
    "MPLCONFIGDIR": "/tmp",
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "PATH": "/usr/bin:/bin",
    "PYTHONHASHSEED": "0",
}


@dataclass(frozen=True)
class Launch:
    """What an untrusted process is started with."""

    withheld: tuple[str, ...]
    """Modules that it may not import."""
    used: tuple[str, ...]
    """Names that tests use."""
    cpu_seconds: int
    preload: tuple[str, ...] = ()
    """Modules that it will want; a back end may have them ready."""
    packages: tuple[str, ...] = DEFAULT_PACKAGES
    """What it may import beside the standard library."""


class Running(Protocol):
    """An untrusted process, or what is in its place."""

    def connect(self, check: Check) -> Conversation:
        """Begin the conversation with it; ``check`` as in ``Conversation``."""

    def await_ready(self) -> str | None:
        """Wait until it answers; else say what is wrong."""

    def cpu_seconds(self) -> float:
        """Return the CPU time that it has used, with all its threads."""

    def stop(self) -> None:
        """End it and all that it started, and remove its scratch folder."""


class Sandbox(Protocol):
    """A back end."""

    name: str
    """As in a result's ``sandbox``."""

    def problem(self) -> str | None:
        """Say why it does not work on this machine; None where it does."""

    def start(self, launch: Launch) -> Running:
        """Start an untrusted process, or use this one."""


def imports(launch: Launch) -> dict[str, Any]:
    """Say where it imports from, as settings for a script of ours."""
    found = packages.find(launch.packages)
    standard = [str(path) for path in view.standard_path()]
    return {
        "path": [*standard, *map(str, found.sites)],
        "installed": {"names": found.names, "in_place": found.in_place, "standard": standard},
        "grader": str(Path(robust_slam_autograder.__file__).resolve().parents[1]),
    }


def python_script(script: Path, settings: dict[str, Any]) -> list[str]:
    """Return the command that runs a script of ours with nothing of the user's around it.

    The settings are on its command line, as a Python literal.
    """
    # The interpreter itself: a virtual environment's link may lead outside the wall.
    python = os.path.realpath(sys.executable)
    return [python, "-P", "-s", "-S", "-B", str(script.resolve()), repr(settings)]


def limits(launch: Launch) -> dict[str, int]:
    """Return the limits of each process, by their names in the resource module."""
    return {
        "RLIMIT_AS": MEMORY_BYTES,
        "RLIMIT_CORE": 0,
        "RLIMIT_CPU": launch.cpu_seconds,
        "RLIMIT_FSIZE": SCRATCH_BYTES,
        "RLIMIT_NOFILE": 128,
        "RLIMIT_SIGPENDING": 256,
    }
