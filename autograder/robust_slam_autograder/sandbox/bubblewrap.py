"""Debian's bubblewrap: own namespaces, no network, only read-only files."""

from __future__ import annotations

import contextlib
import os
import shlex
import shutil
import sys
from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path

from robust_slam_autograder.sandbox import cgroup, inside, seccomp, view
from robust_slam_autograder.sandbox.cgroup import Group
from robust_slam_autograder.sandbox.inside import ENVIRONMENT, SCRATCH_BYTES, Launch
from robust_slam_autograder.sandbox.process import Process, popen


class Bubblewrap:
    """Debian's bubblewrap: own namespaces, no network, only read-only files."""

    name = "bubblewrap"

    def problem(self) -> str | None:
        """Try it once."""
        return bubblewrap_problem()

    def start(self, launch: Launch) -> Process:
        """Start it behind the wall; as root, it then drops to a user id of its own."""
        uid = inside.FIRST_UID + os.getpid() % inside.UIDS if os.getuid() == 0 else None
        mounts, command = _mounts(launch), inside.python_command(launch, uid, walled=True)
        group = cgroup.make()
        with _filter() as (options, descriptors):
            command = [*_before(group), *_walls(uid), *options, *mounts, "--", *command]
            process = popen(command, cwd="/", environment={}, pass_fds=descriptors)
        return Process(process, watched=True, group=group)


def _before(group: Group | None) -> list[str]:
    """What happens outside, before student code could undo it: it is counted, and killed first."""
    script = "echo 1000 > /proc/self/oom_score_adj\n"
    script += f"echo 0 > {shlex.quote(str(group.members))}\n" if group else ""
    return ["/bin/sh", "-ec", script + 'exec env -i "$@"', "sh"]


@contextlib.contextmanager
def _filter() -> Iterator[tuple[list[str], tuple[int, ...]]]:
    """The system-call filter on a pipe: bubblewrap's options and the descriptors to hand on."""
    program = seccomp.program()
    if program is None:
        yield [], ()
        return
    reader, writer = os.pipe()
    os.write(writer, program)
    os.close(writer)
    try:
        yield ["--seccomp", str(reader)], (reader,)
    finally:
        os.close(reader)


@cache
def bubblewrap_problem() -> str | None:
    """Say why bubblewrap does not work on this machine; None where it does."""
    if sys.platform != "linux" or shutil.which("bwrap") is None:
        return "bwrap is not installed"
    running = Bubblewrap().start(Launch(withheld=(), used=(), cpu_seconds=20))
    try:
        error = running.await_ready()
    finally:
        running.stop()
    return None if error is None else f"bwrap fails: {error}"


def _walls(uid: int | None) -> list[str]:
    options = ["bwrap", "--die-with-parent", "--new-session", "--clearenv"]
    options += ["--unshare-pid", "--unshare-net", "--unshare-ipc", "--unshare-uts"]
    options += ["--unshare-cgroup-try", "--hostname", "sandbox", "--cap-drop", "ALL"]
    if uid is None:
        options += ["--unshare-user", "--disable-userns"]
    else:
        options += ["--cap-add", "CAP_SETUID", "--cap-add", "CAP_SETGID"]
    for name, value in ENVIRONMENT.items():
        options += ["--setenv", name, value]
    return options


def _mounts(launch: Launch) -> list[str]:
    """Read-only interpreter and library, a small writable /tmp, and nothing else."""
    small = ["--perms", "1777", "--size", str(SCRATCH_BYTES), "--tmpfs"]
    # Read-only: a process could otherwise excuse itself from the kernel's memory killer.
    options = ["--proc", "/proc", "--remount-ro", "/proc", "--dev", "/dev"]
    # Shared maps of /dev/zero are memory that no process's size shows.
    options += ["--dev-bind", "/dev/null", "/dev/zero", "--remount-ro", "/dev"]
    # Before the rest, which may be in the machine's /tmp.
    options += [*small, "/dev/shm", *small, "/tmp"]
    files = view.files(launch.packages, launch.withheld)
    acts = {"make": _make, "show": _show, "cover": _cover}
    for kind, path in view.steps(files):
        options += acts[kind](path)
    covers = [path for path, is_shown in files.rules if not is_shown and path.is_dir()]
    closed = [option for path in (*covers, "/") for option in ("--remount-ro", str(path))]
    return [*options, *_font_lists(files.fonts), *closed, "--chdir", "/tmp"]


def _font_lists(fonts: Sequence[Path]) -> list[str]:
    pairs = [(str(path), f"{ENVIRONMENT['HOME']}/{path.name}") for path in fonts]
    return [option for pair in pairs for option in ("--ro-bind", *pair)]


def _make(path: Path) -> list[str]:
    """Make a folder that the user id to which the sandbox drops can enter."""
    return ["--perms", "0755", "--dir", str(path)]


def _show(path: Path) -> list[str]:
    return ["--ro-bind", str(path), str(path)]


def _cover(path: Path) -> list[str]:
    """Put nothing in a file's or a folder's place, so that reading it gives nothing."""
    if path.is_file():
        return ["--ro-bind", "/dev/null", str(path)]
    return ["--perms", "0755", "--size", str(2**20), "--tmpfs", str(path)]
