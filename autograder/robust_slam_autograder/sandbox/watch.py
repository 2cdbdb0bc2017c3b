"""What an untrusted process and all that it started use together.

Limits of the kernel hold for one process at a time; these hold for all of them.
"""

import contextlib
import os
from collections.abc import Iterable
from pathlib import Path

import psutil

from robust_slam_autograder.sandbox.terms import MEMORY_BYTES, PROCESSES, SCRATCH_BYTES

BLOCK = 4096
SOCKET_BYTES = 2 * 212_992
"""What a socket may hold: the kernel's default, which student code cannot raise, and a message."""
SECONDS = 0.2
"""How often somebody should look."""
_HAS_LISTS = Path("/proc/thread-self/children").exists()
"""Whether the kernel lists the processes that each thread has started."""


def descendants(pid: int) -> list[psutil.Process]:
    """Return all that a process has started, and what those have."""
    found: dict[int, psutil.Process] = {}
    waiting = [pid]
    while waiting:
        for child in children(waiting.pop()):
            with contextlib.suppress(psutil.Error):  # it has ended
                if child not in found:
                    found[child] = psutil.Process(child)
                    waiting.append(child)
    return list(found.values())


def children(pid: int) -> list[int]:
    """Return the process ids of what a process has started, those of a thread in their order."""
    if _HAS_LISTS:
        lists = Path("/proc", str(pid), "task").glob("*/children")
        return [int(child) for each in lists for child in _read(each).split()]
    # Reads of each process of the machine who has started it, which takes milliseconds.
    with contextlib.suppress(psutil.Error):
        return [process.pid for process in psutil.Process(pid).children()]
    return []


def _read(path: Path) -> str:
    with contextlib.suppress(OSError):  # its thread has ended
        return path.read_text()
    return ""


def uses_too_much(processes: Iterable[psutil.Process], scratch: Path | None) -> bool:
    """Tell whether processes use more memory, threads or disk together than one sandbox may.

    Each open file counts as a socket that is full. Where the kernel counts threads itself it
    stops them at half of what is allowed here. A scratch folder counts where nothing limits it.
    """
    memory = threads = 0
    for process in processes:
        with contextlib.suppress(psutil.Error):
            info = process.memory_info()
            memory += info.rss - info.shared  # what they share counts for no one
            threads += process.num_threads()
            memory += SOCKET_BYTES * process.num_fds()
    disk = _size(scratch) if scratch else 0
    return memory > MEMORY_BYTES or threads > 2 * PROCESSES or disk > SCRATCH_BYTES


def _size(folder: Path) -> int:
    """Return bytes on the disk of a folder's files; each counts for a block at least."""
    found = 0
    for entry in os.scandir(folder):
        with contextlib.suppress(FileNotFoundError):
            found += max(entry.stat(follow_symlinks=False).st_blocks * 512, BLOCK)
        if found > SCRATCH_BYTES:
            break
    return found
