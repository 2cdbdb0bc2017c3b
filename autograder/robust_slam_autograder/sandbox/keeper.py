"""One per untrusted process: starts it behind its walls, watches it, and ends all of it.

The fork server forks a keeper for each request. The keeper stays outside, in no
reach of student code; its connection to the trusted side is the lifeline: when that
closes, for whatever reason, all that the untrusted process started is killed.
"""

from __future__ import annotations

import contextlib
import os
import select
import signal
import socket
import subprocess
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn

import psutil

from robust_slam_autograder import untrusted
from robust_slam_autograder.sandbox import house, inside, landlock, seccomp, system, watch
from robust_slam_autograder.sandbox.inside import ENVIRONMENT, Files, Launch

NAMESPACES = ("pid", "net", "ipc", "uts")


@dataclass(frozen=True)
class Place:
    """Where a server's untrusted processes live.

    Attributes:
        home: the server's folder.
        namespaces: whether each gets namespaces and a root of its own; else Landlock
            alone keeps it from files.
        files: what they may read.
    """

    home: Path
    namespaces: bool
    files: Files


def keep(connection: socket.socket, pipes: tuple[int, int], launch: Launch, place: Place) -> None:
    """Run an untrusted process until the other end of ``connection`` closes.

    Args:
        connection: to the trusted side; what goes wrong at the start is written to it.
        pipes: standard input and output of the untrusted process.
        launch: what it is started with.
        place: where.
    """
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    system.adopt_orphans()
    uid = inside.FIRST_UID + os.getpid() % inside.UIDS if os.getuid() == 0 else None
    with _scratch(place, uid) as scratch:
        try:
            if place.namespaces:
                _leave_namespaces()
            child = os.fork()
        except OSError as error:
            connection.send(str(error).encode())
            return
        if child == 0:
            _become(connection, pipes, launch, place, uid, scratch)
        system.let_trace(False)
        for descriptor in pipes:
            os.close(descriptor)
        _watch(connection, child, place, scratch)


@contextlib.contextmanager
def _scratch(place: Place, uid: int | None) -> Iterator[Path | None]:
    """A folder of its own; with a private root /tmp is that."""
    if place.namespaces:
        yield None
        return
    folder = place.home / f"scratch-{os.getpid()}"
    folder.mkdir(mode=0o700)
    if uid is not None:
        os.chown(folder, uid, uid)
    try:
        yield folder
    finally:
        # Python's own rmtree gives up on folders that are nested a thousand levels deep.
        subprocess.run(["rm", "-rf", "--", str(folder)], stderr=subprocess.DEVNULL)


def _leave_namespaces() -> None:
    uid, gid = os.getuid(), os.getgid()
    if uid == 0:
        system.unshare(*NAMESPACES)
        return
    system.unshare("user", *NAMESPACES)
    Path("/proc/self/setgroups").write_text("deny")
    Path("/proc/self/uid_map").write_text(f"{uid} {uid} 1")
    Path("/proc/self/gid_map").write_text(f"{gid} {gid} 1")


def _watch(connection: socket.socket, child: int, place: Place, scratch: Path | None) -> None:
    """Wait for the lifeline's end; before that, end what uses too much."""
    poller = select.poll()
    poller.register(connection, select.POLLIN | select.POLLHUP)
    while not poller.poll(watch.SECONDS * 1000):
        _reap()
        if watch.uses_too_much(watch.descendants(os.getpid()), scratch):
            _kill_all(child, place)
    _kill_all(child, place)


def _kill_all(child: int, place: Place) -> None:
    """Kill until nothing is left: a process may fork while the others are being killed."""
    if place.namespaces:
        # With the first process of a namespace the kernel ends all others.
        with contextlib.suppress(ProcessLookupError, ChildProcessError):
            os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)
        return
    while found := watch.descendants(os.getpid()):
        for process in found:
            with contextlib.suppress(psutil.Error):
                process.kill()
        _reap()
        time.sleep(0.001)


def _reap() -> None:
    with contextlib.suppress(ChildProcessError):
        while os.waitpid(-1, os.WNOHANG)[0]:
            pass


def _become(
    connection: socket.socket,
    pipes: tuple[int, int],
    launch: Launch,
    place: Place,
    uid: int | None,
    scratch: Path | None,
) -> NoReturn:
    """Turn this process into the untrusted one."""
    try:
        os.setsid()
        if place.namespaces:
            _enter_house(place)
        untrusted.volunteer_for_the_memory_killer()
        _settle(scratch)
        rules = landlock.rules(_allowed(place.files, scratch)) if landlock.version() else None
        untrusted.limit(_limits(launch, place))
        _shut_the_door(uid, rules)
        _keep_only(pipes)
    except BaseException as error:
        connection.send(f"{type(error).__name__}: {error}".encode()[:500])
        os._exit(1)
    try:
        untrusted.serve(launch.withheld, launch.used)
    finally:
        os._exit(0)


def _settle(scratch: Path | None) -> None:
    """Forget the server's environment, and go home."""
    homes = dict.fromkeys(("HOME", "MPLCONFIGDIR", "TMPDIR"), str(scratch or ENVIRONMENT["HOME"]))
    os.environ.clear()
    os.environ.update(ENVIRONMENT | homes)
    os.chdir(homes["HOME"])


def _enter_house(place: Place) -> None:
    system.unshare("mount")
    house.enter(place.home / "root", place.files)
    child = os.fork()
    if child:
        _be_the_first_process(child)


def _be_the_first_process(child: int) -> NoReturn:
    """Reap orphans until the untrusted process itself has ended; all others end with this one."""
    os.closerange(0, 1 << 16)
    untrusted.drop_to(inside.FIRST_UID - 1 if os.getuid() == 0 else None)
    system.drop_capabilities()
    system.let_trace(False)
    with contextlib.suppress(ChildProcessError):
        while os.wait()[0] != child:
            pass
    os._exit(0)


def _allowed(files: Files, scratch: Path | None) -> list[tuple[Path, int]]:
    devices = [(Path("/dev", name), landlock.USE) for name in house.DEVICES]
    if scratch:
        opened = [
            (path, landlock.READ if whole else landlock.LIST)
            for path, whole in inside.readable(files)
        ]
        return [*opened, *devices, (scratch, landlock.ALL)]
    own = [(Path(path), landlock.ALL) for path in ("/tmp", "/dev/shm")]
    return [(Path("/"), landlock.READ), *devices, *own]


def _limits(launch: Launch, place: Place) -> dict[str, int]:
    limits = inside.limits(launch, walled=place.namespaces)
    if "RLIMIT_NPROC" not in limits:
        # All of the user's processes count here: this stops a flood, the keeper counts exactly.
        mine = [p for p in psutil.process_iter() if p.uids().real == os.getuid()]
        limits["RLIMIT_NPROC"] = sum(p.num_threads() for p in mine) + 4 * inside.PROCESSES
    return limits


def _shut_the_door(uid: int | None, rules: int | None) -> None:
    """Give up every right but those of the rules; nothing after this can be taken back."""
    untrusted.drop_to(uid)
    system.drop_capabilities()
    system.forbid_new_privileges()
    if rules is not None:
        landlock.enter(rules)
    program = seccomp.program()
    if program is not None:
        system.install_filter(program)
    system.let_trace(True)


def _keep_only(pipes: tuple[int, int]) -> None:
    """Make the pipes standard input and output, and close all else."""
    for number, descriptor in enumerate(pipes):
        os.dup2(descriptor, number)
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
    os.closerange(3, 1 << 16)
