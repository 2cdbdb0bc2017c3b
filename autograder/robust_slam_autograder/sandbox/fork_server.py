"""The fork server: a clean process that has imported what student code will want.

Started by ``fork`` as a script; it never sees a test, a seed or a submission, so
neither do the processes that it forks. One server for each set of withheld modules.
"""

from __future__ import annotations

import ast
import contextlib
import gc
import importlib
import os
import pickle
import select
import signal
import socket
import struct
import sys
from dataclasses import replace
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from robust_slam_autograder.sandbox.keeper import Server

READY = b"ready\n"
PID = struct.Struct(">q")
"""What a keeper says first: its process id, so that its child's CPU time can be read."""
OWN = (
    "robust_slam_autograder.protocol.channel",
    "robust_slam_autograder.protocol.notebook",
    "robust_slam_autograder.reading.source",
)
"""What every untrusted process imports."""


def main() -> None:
    """Read the settings from the command line and the standard input, import, then serve."""
    gc.disable()  # what is imported stays, and to look through it again and again takes time
    settings = ast.literal_eval(sys.argv[1])
    sys.path[:] = [*settings["path"], settings["grader"]]
    sys.argv[:] = [""]
    from robust_slam_autograder import temporary
    from robust_slam_autograder.sandbox import (
        access_times,
        cgroup,
        copied_view,
        root_filesystem,
        view,
    )
    from robust_slam_autograder.student.imports import Installed

    server: Server = pickle.load(sys.stdin.buffer)
    try:
        owner = os.pidfd_open(settings["owner"])
    except ProcessLookupError:  # it was killed meanwhile
        temporary.remove(server.home)
        raise
    if server.namespaces:
        server = replace(server, view=copied_view.enter(server.home, server.files))
    # What a student's process may not import later shall not be in its memory already.
    sys.path.pop()
    Installed(**settings["installed"]).install()
    preload(settings["preload"], settings["withheld"])
    with socket.socket(socket.AF_UNIX) as listener:
        before = os.umask(0o077)  # no other user may ask
        listener.bind(settings["address"])
        os.umask(before)
        listener.listen(64)
        # Found out once, for all keepers.
        cgroup.problem()
        root_filesystem.steps(server.files)
        if not server.namespaces:
            access_times.settle(view.readable(server.files))
        if child := _leave_the_starter():
            copied_view.note(server.home, child)
            os.write(1, READY)
            os._exit(0)
        try:
            serve(listener, owner, server)
        finally:
            copied_view.leave(server.home)
            temporary.remove(server.home)


def preload(modules: list[str], withheld: tuple[str, ...]) -> None:
    """Import what can be, and nothing that is withheld.

    Raises:
        ImportError: the grader itself needs a module that is withheld.
    """
    from robust_slam_autograder.student.imports import Withheld

    finder = Withheld(withheld)
    sys.meta_path.insert(0, finder)
    for module in OWN:
        importlib.import_module(module)
    for module in modules:
        with contextlib.suppress(Exception):  # it may not be installed, or need what is withheld
            importlib.import_module(module)
    for module in list(sys.modules):
        finder.find_spec(module)
    sys.meta_path.remove(finder)
    gc.collect()
    gc.freeze()
    gc.enable()


def serve(listener: socket.socket, owner: int, server: Server) -> None:
    """Fork a keeper for each connection, until the owner has ended."""
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)
    poller = select.poll()
    poller.register(listener, select.POLLIN)
    poller.register(owner, select.POLLIN)
    while owner not in (ready := dict(poller.poll())):
        if listener.fileno() in ready:
            connection, _ = listener.accept()
            if os.fork() == 0:
                os.close(owner)
                listener.close()
                _keep(connection, server)
            connection.close()


def _keep(connection: socket.socket, server: Server) -> None:
    from robust_slam_autograder.sandbox.keeper import keep
    from robust_slam_autograder.sandbox.terms import Launch

    try:
        data, pipes, _, _ = socket.recv_fds(connection, 1 << 20, 2)
        connection.send(PID.pack(os.getpid()))
        keep(connection, (pipes[0], pipes[1]), Launch(**ast.literal_eval(data.decode())), server)
    finally:
        os._exit(0)


def _leave_the_starter() -> int:
    """Go on in a child, whose number the starter gets: that need not wait for the server's end."""
    if child := os.fork():
        return child
    # A signal for the starter's group, such as Ctrl-C, is not for the servers.
    os.setsid()
    null = os.open(os.devnull, os.O_RDWR)
    for descriptor in (0, 1, 2):
        os.dup2(null, descriptor)
    return 0


if __name__ == "__main__":
    main()
