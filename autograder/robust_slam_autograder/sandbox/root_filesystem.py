"""A private root for one untrusted process: read-only files, and a small /tmp of its own."""

import os
from collections.abc import Callable
from functools import cache
from pathlib import Path

from robust_slam_autograder.sandbox import system
from robust_slam_autograder.sandbox.terms import SCRATCH_BYTES, SCRATCH_FILES
from robust_slam_autograder.sandbox.view import Files

DEVICES = ("null", "full", "random", "urandom")
"""Not zero: shared maps of it are memory that no process's size shows."""
MADE = ("/dev", "/dev/shm", "/tmp")
"""No /proc: it shows paths of the grader, and counters of the whole machine, in which one run
could leave a message for another. Nothing that student code needs reads it."""
_SMALL = f"size={SCRATCH_BYTES},nr_inodes={SCRATCH_FILES},mode=1777"


def enter(root: Path, files: Files, view: str = "") -> None:
    """Build the private root and make it this process's.

    The caller has a mount namespace of its own.

    Args:
        root: an empty folder to build it on.
        files: what it holds.
        view: what stands before a path where these files are taken from.

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
    for act, path in steps(files):
        act(f"{view}{path}", f"{root}{path}")
    for name in DEVICES:
        _show(f"/dev/{name}", f"{root}/dev/{name}")
    for font in files.fonts:
        _show(str(font), f"{root}/tmp/{font.name}")
    system.make_read_only(str(root))
    system.make_writable(str(root / "tmp"))
    _mount_tmpfs(root / "dev/shm", _SMALL)
    system.enter_root(str(root))


def _mount_tmpfs(path: Path, options: str) -> None:
    system.mount("tmpfs", str(path), "tmpfs", system.NO_SUID | system.NO_DEV, options)


Step = Callable[[str, str], None]
"""Makes something of the machine's path, the first, at a place in the new root, the second."""


@cache
def steps(files: Files) -> tuple[tuple[Step, str], ...]:
    """Say what makes the private root, in order: empty folders, what is shown, what is covered."""
    rules, made = dict(files.rules), {Path(path) for path in MADE}
    found: list[tuple[Step, str]] = []
    for path, is_shown in files.rules:
        # In a folder that is shown nothing can be made, and all its folders are there.
        around = next((parent for parent in path.parents if parent in rules), Path("/"))
        for parent in reversed(path.parents) if is_shown else ():
            if parent.is_relative_to(around) and parent != around and parent not in made:
                made.add(parent)
                found.append((lambda path, place: os.mkdir(place), str(parent)))
        found.append((_show if is_shown else _cover, str(path)))
    return tuple(found)


def _show(path: str, place: str) -> None:
    if os.path.isdir(path):
        os.mkdir(place)
    else:
        os.mknod(place)
    system.mount(path, place, flags=system.BIND | system.RECURSIVE)


def _cover(path: str, place: str) -> None:
    """Put nothing in a file's or a folder's place, so that reading it gives nothing."""
    if os.path.isdir(path):
        _mount_tmpfs(Path(place), "size=1m,mode=755")
    else:
        system.mount("/dev/null", place, flags=system.BIND)
