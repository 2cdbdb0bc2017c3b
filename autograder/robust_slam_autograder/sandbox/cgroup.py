"""Control groups: the kernel counts all memory of a sandbox, also what no process's size shows.

Buffers of sockets and pipes, page tables and files in memory count too. A group is a folder
in the grader's own group or in one around it, where this user may make one: as root, or where
systemd has delegated groups to the user. Elsewhere there is none, and ``watch`` alone counts.
"""

import contextlib
import os
import secrets
import subprocess
import time
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from robust_slam_autograder.sandbox.terms import MEMORY_BYTES, PROCESSES

PREFIX = "autograder-"
_STALE_SECONDS = 60.0
"""A group without processes that is older than this was left by a grader that was killed."""
_MEMORY_LIMITS = ("memory.max", "memory.limit_in_bytes")
"""Of version 2 and of version 1; one of them must be there."""
_FURTHER_LIMITS = {
    "memory.swap.max": 0,
    "memory.memsw.limit_in_bytes": MEMORY_BYTES,
    "memory.oom.group": 1,
    "pids.max": 2 * PROCESSES,
}


@dataclass(frozen=True)
class Group:
    """One sandbox's control group."""

    folder: Path

    @property
    def members(self) -> Path:
        """Return the file to which a process writes 0 to join."""
        return self.folder / "cgroup.procs"

    def join(self) -> None:
        """Put this process, and all that it starts from now on, into the group."""
        self.members.write_text("0")

    def remove(self) -> None:
        """Remove it once its last process has ended."""
        for _ in range(100):
            try:
                self.folder.rmdir()
            except FileNotFoundError:
                return
            except OSError:  # a process is just ending
                time.sleep(0.01)


@contextlib.contextmanager
def made() -> Iterator[Group | None]:
    """Make a group for one sandbox and remove it in the end; None where this user may not."""
    group = _make() if problem() is None else None
    try:
        yield group
    finally:
        if group is not None:
            group.remove()


@cache
def problem() -> str | None:
    """Say why memory is not counted by a control group here; None where it is."""
    group = _make()
    if group is None:
        return "this user may make no control group for memory here"
    _sweep(group.folder.parent)
    try:
        command = ["/bin/sh", "-c", 'echo 0 > "$0"', str(group.members)]
        joined = subprocess.run(command, capture_output=True)
    finally:
        group.remove()
    return None if joined.returncode == 0 else "no process may enter a control group made here"


def _make() -> Group | None:
    with contextlib.suppress(OSError):  # not Linux, or not allowed
        around = parent()
        if around is not None:
            group = Group(around / f"{PREFIX}{os.getpid()}-{secrets.token_hex(4)}")
            group.folder.mkdir()
            with contextlib.suppress(OSError):
                if _limit(group.folder):
                    return group
            group.remove()
    return None


def _limit(folder: Path) -> bool:
    """Set the limits; False where this hierarchy does not count memory."""
    found = [folder / key for key in _MEMORY_LIMITS if (folder / key).exists()]
    for path in found:
        path.write_text(str(MEMORY_BYTES))
    for key, value in _FURTHER_LIMITS.items():
        with contextlib.suppress(OSError):  # not every kernel counts these
            (folder / key).write_text(str(value))
    return bool(found)


def _sweep(parent: Path) -> None:
    """Remove groups of graders that were killed; the kernel keeps those with a process in them."""
    for folder in parent.glob(f"{PREFIX}*"):
        with contextlib.suppress(OSError):
            if time.time() - folder.stat().st_mtime > _STALE_SECONDS:
                folder.rmdir()


@cache
def parent(process: Path = Path("/proc/self")) -> Path | None:
    """Return the group in which this process can make one that counts memory."""
    mounts = dict(_mounts(process / "mountinfo"))
    for line in (process / "cgroup").read_text().splitlines():
        _, controllers, path = line.split(":", 2)
        name = "memory" if "memory" in controllers.split(",") else controllers
        if name not in ("", "memory") or name not in mounts:
            continue
        root, mount = mounts[name]
        own = mount / os.path.relpath(path, root)
        found = own if name else _delegated(own, mount)
        if found is not None:
            return found
    return None


def _mounts(table: Path) -> Iterator[tuple[str, tuple[str, Path]]]:
    """By controller the hierarchy's group that is mounted, and where; version 2 has no name."""
    for line in table.read_text().splitlines():
        place, _, kind = line.partition(" - ")
        root, mount = place.split(" ")[3:5]
        name, _, options = kind.split(" ", 2)
        if name == "cgroup2":
            yield "", (root, Path(mount))
        elif name == "cgroup":
            yield from ((option, (root, Path(mount))) for option in options.split(","))


def _delegated(own: Path, mount: Path) -> Path | None:
    """Find the nearest group around our own that counts its children's memory and is ours.

    To move a process one needs the right to the nearest group around both its old and its new one.
    """
    for folder in (own, *own.parents):
        if not folder.is_relative_to(mount) or not os.access(folder / "cgroup.procs", os.W_OK):
            return None
        with contextlib.suppress(OSError):
            control = folder / "cgroup.subtree_control"
            if "memory" not in control.read_text().split():
                control.write_text("+memory +pids")
            return folder
    return None
