"""The site as `make book` builds it."""

from __future__ import annotations

import fcntl
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]


@dataclass(frozen=True)
class Site:
    """The folder of the built pages, and what the build said."""

    folder: Path
    log: str
    status: int


def built() -> Site:
    """Build the book in this folder; pages that are up to date are reused, which Sphinx decides.

    A lock lets one of several test processes build while the others wait.
    """
    book = Path(sys.executable).with_name("jupyter-book")
    command = [book, "build", ".", "--path-output", "build", "-W", "-n", "--keep-going"]
    (ROOT / "build").mkdir(exist_ok=True)
    with (ROOT / "build" / ".book.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    return Site(ROOT / "build" / "_build" / "html", done.stdout + done.stderr, done.returncode)
