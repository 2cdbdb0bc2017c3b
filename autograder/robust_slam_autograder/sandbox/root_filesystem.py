"""A private root for one untrusted process: read-only files, and a small /tmp of its own."""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import cache
from pathlib import Path

from robust_slam_autograder.sandbox import system, view
from robust_slam_autograder.sandbox.terms import SCRATCH_BYTES, SCRATCH_FILES
from robust_slam_autograder.sandbox.view import Files

DEVICES = ("null", "full", "random", "urandom")
"""Not zero: shared maps of it are memory that no process's size shows."""
MADE = ("/dev", "/dev/shm", "/tmp")
"""No /proc: it shows paths of the grader, and counters of the whole machine, in which one run
could leave a message for another. Nothing that student code needs reads it."""
_SMALL = f"size={SCRATCH_BYTES},nr_inodes={SCRATCH_FILES},mode=1777"


def enter(root: Path, files: Files) -> None:
    """Build the private root and make it this process's.

    The caller has a mount namespace of its own.

    Args:
        root: an empty folder to build it on.
        files: what it holds.

    Raises:
        OSError: the kernel refuses a mount.
    """
    os.umask(0o022)
    system.mount("none", "/", flags=system.PRIVATE | system.RECURSIVE)
    _mount_tmpfs(root, "size=1m,mode=755")
    for folder in MADE:
        os.mkdir(f"{root}{folder}")
    # Before the rest, which may be in the machine's /tmp.
    _mount_tmpfs(root / "tmp", _SMALL)
    for act, path in plan(files):
        act(str(root), path)
    for font in files.fonts:
        _show_file(str(font), f"{root}/tmp/{font.name}")
    system.make_read_only(str(root))
    system.make_writable(str(root / "tmp"))
    _mount_tmpfs(root / "dev/shm", _SMALL)
    system.enter_root(str(root))


def _mount_tmpfs(path: Path, options: str) -> None:
    system.mount("tmpfs", str(path), "tmpfs", system.NO_SUID | system.NO_DEV, options)


@cache
def plan(files: Files) -> tuple[tuple[Callable[[str, str], None], str], ...]:
    """Say what ``enter`` does with paths, found out ahead of it: there are a hundred of them."""
    devices = [(_show_file_at, f"/dev/{name}") for name in DEVICES]
    acts = {"make": _make, "cover": _cover}
    found = []
    for kind, path in view.steps(files):
        if str(path) not in MADE:
            show = _show_folder_at if path.is_dir() else _show_file_at
            found.append((acts.get(kind, show), str(path)))
    return (*found, *devices)


def _make(root: str, path: str) -> None:
    os.mkdir(root + path)


def _show_folder_at(root: str, path: str) -> None:
    os.mkdir(root + path)
    system.mount(path, root + path, flags=system.BIND | system.RECURSIVE)


def _show_file_at(root: str, path: str) -> None:
    _show_file(path, root + path)


def _show_file(path: str, place: str) -> None:
    os.mknod(place)
    system.mount(path, place, flags=system.BIND | system.RECURSIVE)


def _cover(root: str, path: str) -> None:
    """Put nothing in a file's or a folder's place, so that reading it gives nothing."""
    if os.path.isdir(path):
        _mount_tmpfs(Path(root + path), "size=1m,mode=755")
    else:
        system.mount("/dev/null", root + path, flags=system.BIND)
