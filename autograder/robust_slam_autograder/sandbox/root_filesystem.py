"""A private root for one untrusted process: read-only files, and a small /tmp of its own."""

from __future__ import annotations

import os
from functools import cache
from pathlib import Path

from robust_slam_autograder.sandbox import system
from robust_slam_autograder.sandbox.inside import SCRATCH_BYTES, SCRATCH_FILES
from robust_slam_autograder.sandbox.view import Files

DEVICES = ("null", "full", "random", "urandom")
"""Not zero: shared maps of it are memory that no process's size shows."""
_SMALL = f"size={SCRATCH_BYTES},nr_inodes={SCRATCH_FILES},mode=1777"


def enter(root: Path, files: Files) -> None:
    """Build the private root and make it this process's.

    The caller has mount and pid namespaces of its own, and is the first process of
    the latter: /proc shows that one alone.

    Args:
        root: an empty folder to build it on.
        files: what it holds.

    Raises:
        OSError: the kernel refuses a mount.
    """
    os.umask(0o022)
    system.mount("none", "/", flags=system.PRIVATE | system.RECURSIVE)
    _mount_tmpfs(root, "size=1m,mode=755")
    for folder in ("proc", "dev/shm", "tmp"):
        (root / folder).mkdir(parents=True)
    # Before the rest, which may lie in the machine's /tmp.
    _mount_tmpfs(root / "tmp", _SMALL)
    folders, binds = plan(files)
    for folder in folders:
        os.mkdir(f"{root}{folder}")
    for source, place, is_folder in binds:
        _bind(source, f"{root}{place}", is_folder)
    for path in files.hidden:
        _cover(root, path)
    system.make_read_only(str(root))
    system.make_writable(str(root / "tmp"))
    _mount_tmpfs(root / "dev/shm", _SMALL)
    # Read-only: a process could otherwise excuse itself from the kernel's memory killer.
    quiet = system.READ_ONLY | system.NO_SUID | system.NO_DEV
    system.mount("proc", str(root / "proc"), "proc", flags=quiet)
    system.enter_root(str(root))


def _mount_tmpfs(path: Path, options: str) -> None:
    system.mount("tmpfs", str(path), "tmpfs", system.NO_SUID | system.NO_DEV, options)


def _bind(source: str, place: str, is_folder: bool) -> None:
    if is_folder:
        os.mkdir(place)
    else:
        os.mknod(place)
    system.mount(source, place, flags=system.BIND | system.RECURSIVE)


@cache
def plan(files: Files) -> tuple[tuple[str, ...], tuple[tuple[str, str, bool], ...]]:
    """What ``enter`` does, found out once and ahead: there are a hundred files and folders.

    Returns:
        the folders to make, in order; and what to bind, where, and whether it is a folder.
    """
    pairs = [(path, path) for path in files.visible]
    pairs += [(path, path) for path in (Path("/dev", name) for name in DEVICES)]
    pairs += [(path, Path("/tmp", path.name)) for path in files.fonts]
    parents = [parent for _, place in pairs for parent in reversed(place.parents)]
    made = ("/", "/proc", "/dev", "/dev/shm", "/tmp")
    folders = [str(parent) for parent in dict.fromkeys(parents) if str(parent) not in made]
    return tuple(folders), tuple((str(path), str(place), path.is_dir()) for path, place in pairs)


def _cover(root: Path, path: Path) -> None:
    """Put nothing in a file's or a folder's place, so that reading it gives nothing."""
    place = root / path.relative_to("/")
    if path.is_dir():
        _mount_tmpfs(place, "size=4k,mode=555")
    else:
        system.mount("/dev/null", str(place), flags=system.BIND)
