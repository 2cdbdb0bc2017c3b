"""A copy in memory of what student code may read, one for all fork servers of a batch.

A folder on a disk remembers the names that were asked for and are not there, and the pages of its
files come and go: how long an answer takes says what another run has asked. A tmpfs keeps no such
names, and all its pages. The copy is in a mount namespace of the servers, and ends with them.
"""

import contextlib
import os
import stat
from collections.abc import Collection
from pathlib import Path

import psutil

from robust_slam_autograder.sandbox import system
from robust_slam_autograder.sandbox.view import Files, within

LEAST_FREE = 2 * 1024**3
"""Bytes of memory without which nothing is copied: scipy and the rest are half a gigabyte."""
_NAME, _SERVER, _DONE = "view", "server", "copied"


def enter(home: Path, files: Files) -> str:
    """Go to where the servers' copy is, or make it, and add what is missing there.

    Args:
        home: the servers' folder.
        files: what this server's student code may read.

    Returns:
        what stands before a path of the copy; nothing where there is too little memory for one.

    Raises:
        OSError: the kernel refuses it.
    """
    os.umask(0o022)  # whatever the grader has: student code is another user, and reads the copy
    place = home / _NAME
    if not _joined(home):
        if _free() < LEAST_FREE:
            return ""
        system.leave("mount")
        system.mount("none", "/", flags=system.PRIVATE | system.RECURSIVE)
        place.mkdir(exist_ok=True)
        options = "size=75%,mode=755"
        system.mount("tmpfs", str(place), "tmpfs", system.NO_SUID | system.NO_DEV, options)
    done = place / _DONE
    before = set(done.read_text().splitlines() if done.exists() else ())
    hidden = [path for path, is_shown in files.rules if not is_shown]
    for path, is_shown in files.rules:
        inside = [str(one) for one in hidden if within(one, [path])]
        if is_shown and (line := repr((str(path), inside))) not in before:
            os.makedirs(f"{place}{path.parent}", exist_ok=True)
            _copy(str(path), f"{place}{path}", inside)
            before.add(line)
    done.write_text("\n".join(before))
    return str(place)


def _free() -> int:
    """Return how much memory is free, in bytes; a container may have less than the machine."""
    found: list[int] = [psutil.virtual_memory().available]
    for limit in ("memory.max", "memory/memory.limit_in_bytes"):
        with contextlib.suppress(OSError, ValueError):  # ValueError: it has none
            found.append(int(Path("/sys/fs/cgroup", limit).read_text()))
    return min(found)


def note(home: Path, server: int) -> None:
    """Note a server's process, by which the next one finds the copy."""
    (home / _SERVER).write_text(str(server))


def leave(home: Path) -> None:
    """Take the copy away, so that the servers' folder can be removed."""
    with contextlib.suppress(OSError):
        system.unmount(str(home / _NAME))


def _joined(home: Path) -> bool:
    with contextlib.suppress(OSError, ValueError):
        process = int((home / _SERVER).read_text())
        descriptor = os.pidfd_open(process)
        # Another process may have its number by now.
        if str(home) in Path(f"/proc/{process}/cmdline").read_text():
            system.join(descriptor, "mount")
            return (home / _NAME / _DONE).exists()
    return False


def _copy(path: str, target: str, hidden: Collection[str]) -> None:
    """Copy a file or a folder; a hidden one's place is kept, for something to cover it there."""
    # It may be gone meanwhile; what the grader may not read, student code may not either.
    with contextlib.suppress(FileNotFoundError, PermissionError):
        facts = os.stat(path)
        if stat.S_ISDIR(facts.st_mode):
            os.makedirs(target, exist_ok=True)
            with os.scandir(path) if path not in hidden else contextlib.nullcontext(()) as inside:
                for entry in inside:
                    _copy_entry(entry, f"{target}/{entry.name}", hidden)
        elif path in hidden:
            os.close(os.open(target, os.O_WRONLY | os.O_CREAT))
        elif stat.S_ISREG(facts.st_mode):
            _copy_file(path, target, facts)


def _copy_entry(entry: os.DirEntry[str], target: str, hidden: Collection[str]) -> None:
    if entry.name.endswith((".opt-1.pyc", ".opt-2.pyc")):
        return  # of another way to run Python
    if not entry.is_symlink():
        _copy(entry.path, target, hidden)
    elif not os.path.lexists(target):
        os.symlink(os.readlink(entry.path), target)


def _copy_file(path: str, target: str, facts: os.stat_result) -> None:
    """Copy a file with its time, which its compiled form is known by."""
    with open(path, "rb", buffering=0) as source:
        try:
            made = os.open(target, os.O_WRONLY | os.O_CREAT | os.O_EXCL, facts.st_mode & 0o755)
        except FileExistsError:
            if os.stat(target).st_mtime_ns == facts.st_mtime_ns:
                return
            made = os.open(target, os.O_WRONLY | os.O_TRUNC)
        while os.sendfile(made, source.fileno(), None, 1 << 30):
            pass
        os.utime(made, ns=(facts.st_atime_ns, facts.st_mtime_ns))
        os.close(made)
