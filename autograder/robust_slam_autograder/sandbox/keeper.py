"""One per untrusted process: starts it behind its walls, watches it, and ends all of it.

The fork server forks a keeper for each request. The keeper stays outside, in no
reach of student code; its connection to the trusted side is the lifeline: when that
closes, for whatever reason, all that the untrusted process started is killed.
"""

import contextlib
import os
import select
import shutil
import signal
import socket
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn

import numpy as np
import psutil

from robust_slam_autograder.sandbox import (
    cgroup,
    landlock,
    root_filesystem,
    seccomp,
    system,
    terms,
    view,
    watch,
)
from robust_slam_autograder.sandbox.cgroup import Group
from robust_slam_autograder.sandbox.terms import ENVIRONMENT, Launch
from robust_slam_autograder.sandbox.view import Files
from robust_slam_autograder.student import untrusted

TERMINAL = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
NAMESPACES = ("pid", "net", "ipc", "uts")


@dataclass(frozen=True)
class Server:
    """What is the same for all untrusted processes of a fork server.

    Attributes:
        home: the server's folder.
        namespaces: whether each gets namespaces and a root of its own; else Landlock
            alone keeps it from files.
        files: what they may read.
        view: what stands before a path where these files are taken from.
    """

    home: Path
    namespaces: bool
    files: Files
    view: str = ""


def keep(
    connection: socket.socket, pipes: tuple[int, int], launch: Launch, server: Server
) -> None:
    """Run an untrusted process until the other end of ``connection`` closes.

    What goes wrong at the start is written there. The pipes become its standard input and output.
    """
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    for ignored in TERMINAL:
        signal.signal(ignored, signal.SIG_IGN)
    system.adopt_orphans()
    uid = terms.FIRST_UID + os.getpid() % terms.UIDS if os.getuid() == 0 else None
    with _scratch(server, uid) as scratch, cgroup.made() as group:
        try:
            if server.namespaces:
                system.leave(*NAMESPACES)
                socket.sethostname("sandbox")
            child = os.fork()
        except OSError as error:
            connection.send(str(error).encode())
            return
        if child == 0:
            _become(connection, pipes, launch, server, uid, scratch, group)
        system.let_trace(False)
        for descriptor in pipes:
            os.close(descriptor)
        _watch(connection, child, server, scratch)


@contextlib.contextmanager
def _scratch(server: Server, uid: int | None) -> Iterator[Path | None]:
    """Make a folder of its own; with a private root /tmp is that."""
    if server.namespaces:
        yield None
        return
    folder = server.home / f"scratch-{os.getpid()}"
    folder.mkdir(mode=0o700)
    if uid is not None:
        os.chown(folder, uid, uid)
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _watch(connection: socket.socket, child: int, server: Server, scratch: Path | None) -> None:
    """Wait for the lifeline's end; before that, end what uses too much."""
    poller = select.poll()
    poller.register(connection, select.POLLIN | select.POLLHUP)
    try:
        while not poller.poll(watch.SECONDS * 1000):
            if not server.namespaces:
                _reap()
            if watch.uses_too_much(watch.descendants(os.getpid()), scratch):
                _kill_all(child, server)
    finally:
        _kill_all(child, server)


def _kill_all(child: int, server: Server) -> None:
    """Kill until nothing is left: a process may fork while the others are being killed."""
    if server.namespaces:
        # With the first process of a namespace the kernel ends all others.
        with contextlib.suppress(ProcessLookupError, ChildProcessError):
            os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)
        return
    while _reap():
        for process in watch.descendants(os.getpid()):
            with contextlib.suppress(psutil.Error):
                process.kill()
        time.sleep(0.001)


def _reap() -> bool:
    """Forget those that have ended; False where no descendant is left, not even an orphan."""
    try:
        while os.waitpid(-1, os.WNOHANG)[0]:
            pass
    except ChildProcessError:
        return False
    return True


def _become(
    connection: socket.socket,
    pipes: tuple[int, int],
    launch: Launch,
    server: Server,
    uid: int | None,
    scratch: Path | None,
    group: Group | None,
) -> NoReturn:
    """Turn this process into the untrusted one."""
    try:
        if group is not None:
            group.join()
        untrusted.volunteer_for_the_memory_killer()
        limits = _limits(launch, server)  # before the root without /proc
        os.setsid()
        for ignored in TERMINAL:
            signal.signal(ignored, signal.SIG_DFL)
        if server.namespaces:
            _enter_root(server)
        _settle(scratch)
        rules = landlock.rules(_allowed(server.files, scratch)) if landlock.version() else None
        untrusted.limit(limits)
        _shut_the_door(uid, rules, shared_disk=not server.namespaces)
        _keep_only(pipes)
    except BaseException as error:
        connection.send(f"{type(error).__name__}: {error}".encode()[:500])
        os._exit(1)
    try:
        untrusted.serve(launch.withheld, launch.used, launch.packages)
    finally:
        os._exit(0)


def _settle(scratch: Path | None) -> None:
    """Go home. The server's environment, in which this begins, has nothing of its user's."""
    homes = dict.fromkeys(("HOME", "MPLCONFIGDIR", "TMPDIR"), str(scratch or ENVIRONMENT["HOME"]))
    os.environ.update(ENVIRONMENT | homes)
    os.chdir(homes["HOME"])
    tempfile.tempdir = None  # the server's
    if "numpy.random" in sys.modules:
        np.random.seed()


def _enter_root(server: Server) -> None:
    system.unshare("mount")
    root_filesystem.enter(server.home / "root", server.files, server.view)
    child = os.fork()
    if child:
        _be_the_first_process(child)


def _be_the_first_process(child: int) -> NoReturn:
    """Reap orphans until the untrusted process itself has ended; all others end with this one."""
    os.closerange(0, 1 << 16)
    untrusted.drop_to(terms.FIRST_UID - 1 if os.getuid() == 0 else None)
    system.drop_capabilities()
    system.let_trace(False)
    system.die_with_parent()
    with contextlib.suppress(ChildProcessError):
        while os.wait()[0] != child:
            pass
    os._exit(0)


def _allowed(files: Files, scratch: Path | None) -> list[tuple[Path, int]]:
    devices = [(Path("/dev", name), landlock.USE) for name in root_filesystem.DEVICES]
    if scratch:
        opened = [
            (path, landlock.READ if whole else landlock.LIST)
            for path, whole in view.readable(files)
        ]
        return [*opened, *devices, (scratch, landlock.FLAT)]
    own = [(Path(path), landlock.ALL) for path in ("/tmp", "/dev/shm")]
    return [(Path("/"), landlock.READ), *devices, *own]


def _limits(launch: Launch, server: Server) -> dict[str, int]:
    processes = terms.PROCESSES
    if os.getuid() != 0 and not server.namespaces:
        # All of the user's processes count here: this stops a flood, the keeper counts exactly.
        processes = _own_threads() + 4 * terms.PROCESSES
    return terms.limits(launch) | {"RLIMIT_NPROC": processes}


def _own_threads() -> int:
    """Return all threads of the present user."""
    found = (process.info for process in psutil.process_iter(["uids", "num_threads"]))
    mine = (one for one in found if one["uids"] and one["uids"].real == os.getuid())
    return sum(one["num_threads"] for one in mine)


def _shut_the_door(uid: int | None, rules: int | None, *, shared_disk: bool) -> None:
    """Give up every right but those of the rules; nothing after this can be taken back."""
    untrusted.drop_to(uid)
    system.drop_capabilities()
    system.forbid_new_privileges()
    if rules is not None:
        landlock.enter(rules)
    system.install_filter(seccomp.program(shared_disk=shared_disk))
    system.let_trace(True)


def _keep_only(pipes: tuple[int, int]) -> None:
    """Make the pipes standard input and output, and close all else."""
    for number, descriptor in enumerate(pipes):
        os.dup2(descriptor, number)
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
    os.closerange(3, 1 << 16)
