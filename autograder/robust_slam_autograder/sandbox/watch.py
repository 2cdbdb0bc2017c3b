"""What an untrusted process and all that it started use together.

Limits of the kernel hold for one process at a time; these hold for all of them.
"""

from __future__ import annotations

import contextlib
import os
import stat
from collections.abc import Iterable, Iterator
from pathlib import Path

import psutil

from robust_slam_autograder.sandbox.inside import MEMORY_BYTES, PROCESSES, SCRATCH_BYTES

SECONDS = 0.2
"""How often somebody should look."""


def descendants(pid: int) -> list[psutil.Process]:
    """All that a process has started, and what those have."""
    try:
        found: list[psutil.Process] = psutil.Process(pid).children(recursive=True)
        return found
    except psutil.Error:
        return []


def uses_too_much(processes: Iterable[psutil.Process], scratch: Path | None) -> bool:
    """Whether processes use more memory, threads or disk together than one sandbox may.

    Where the kernel counts threads itself it stops them at half of what is allowed here.

    Args:
        processes: all of a sandbox.
        scratch: its folder, where nothing else limits that one's size.
    """
    memory = threads = disk = 0
    for process in processes:
        with contextlib.suppress(psutil.Error):
            info = process.memory_info()
            memory += info.rss - info.shared  # what they share counts for nobody
            threads += process.num_threads()
            disk += sum(_orphaned_files(process.pid)) if scratch else 0
    if scratch:
        disk += sum(_sizes(scratch))
    return memory > MEMORY_BYTES or threads > 2 * PROCESSES or disk > SCRATCH_BYTES


def _sizes(folder: Path) -> Iterator[int]:
    for where, _, names in os.walk(folder):
        for name in names:
            with contextlib.suppress(OSError):
                yield os.lstat(os.path.join(where, name)).st_blocks * 512


def _orphaned_files(pid: int) -> Iterator[int]:
    """Sizes of files that a process has open and that have no name any more."""
    with contextlib.suppress(OSError):
        for entry in os.scandir(f"/proc/{pid}/fd"):
            with contextlib.suppress(OSError):
                found = entry.stat()
                if stat.S_ISREG(found.st_mode) and found.st_nlink == 0:
                    yield found.st_blocks * 512
