"""A private root for one untrusted process: read-only files, and a small /tmp of its own."""

from __future__ import annotations

import os
from pathlib import Path

from robust_slam_autograder.sandbox import system
from robust_slam_autograder.sandbox.inside import SCRATCH_BYTES, SCRATCH_FILES, Files

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
    # First of all, lest it cover a course that lies in /tmp itself.
    _mount_tmpfs(root / "tmp", _SMALL)
    for path in files.visible:
        _show(root, path)
    for path in files.hidden:
        _cover(root, path)
    for name in DEVICES:
        _bind(Path("/dev", name), root / "dev" / name)
    for path in files.fonts:
        _bind(path, root / "tmp" / path.name)
    system.make_read_only(str(root))
    system.make_writable(str(root / "tmp"))
    _mount_tmpfs(root / "dev/shm", _SMALL)
    system.mount("proc", str(root / "proc"), "proc", flags=system.NO_SUID | system.NO_DEV)
    system.enter_root(str(root))


def _mount_tmpfs(path: Path, options: str) -> None:
    system.mount("tmpfs", str(path), "tmpfs", system.NO_SUID | system.NO_DEV, options)


def _show(root: Path, path: Path) -> None:
    place = root / path.relative_to("/")
    if path.is_symlink():
        place.parent.mkdir(parents=True, exist_ok=True)
        place.symlink_to(os.readlink(path))
    elif path.exists():
        _bind(path, place)


def _bind(path: Path, place: Path) -> None:
    if path.is_dir():
        place.mkdir(parents=True, exist_ok=True)
    else:
        place.parent.mkdir(parents=True, exist_ok=True)
        place.touch()
    system.mount(str(path), str(place), flags=system.BIND | system.RECURSIVE)


def _cover(root: Path, path: Path) -> None:
    """Put nothing in a file's or a folder's place, so that reading it gives nothing."""
    place = root / path.relative_to("/")
    if path.is_dir():
        _mount_tmpfs(place, "size=4k,mode=555")
    else:
        system.mount("/dev/null", str(place), flags=system.BIND)
