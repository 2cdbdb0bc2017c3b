"""Our own back end: a fork server that is ready before the student is.

Each untrusted process is forked from a server that has imported numpy and the rest
already. It drops to a user id of its own where the grader is root, gives up every
right to gain one, and is held by Landlock, by a filter of system calls and by limits;
where the kernel grants namespaces it also gets those and a private root.
"""

import atexit
import contextlib
import fcntl
import hashlib
import os
import pickle
import platform
import secrets
import shutil
import socket
import stat
import subprocess
import sys
import tempfile
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from typing import Any

from robust_slam_autograder.errors import GraderFailure
from robust_slam_autograder.reading.assignment import DEFAULT_PACKAGES
from robust_slam_autograder.sandbox import fork_server, landlock, seccomp, terms, view
from robust_slam_autograder.sandbox.keeper import Server
from robust_slam_autograder.sandbox.process import Piped
from robust_slam_autograder.sandbox.terms import ENVIRONMENT, Launch

END_SECONDS = 10.0
LONGEST = 60
"""A temporary folder's path; a socket's may have 108 bytes in all."""


@dataclass(frozen=True)
class Forked(Piped):
    """An untrusted process that a server forked; its keeper started it and watches it."""

    connection: socket.socket
    """To the keeper."""

    def last_words(self) -> str:
        """Return what the keeper said."""
        with contextlib.suppress(OSError):
            self.connection.settimeout(1.0)
            return self.connection.recv(500).decode(errors="replace")
        return ""

    def stop(self) -> None:
        """Cut the lifeline and wait until the keeper has ended everything."""
        for descriptor in (self.reader, self.writer):
            os.close(descriptor)
        with self.connection, contextlib.suppress(OSError):
            self.connection.shutdown(socket.SHUT_WR)
            self.connection.settimeout(END_SECONDS)
            while self.connection.recv(500):
                pass


class Fork:
    """The fork server's back end."""

    name = "fork"

    def __init__(self, *, namespaces: bool = True) -> None:
        """Choose the walls; servers are started when they are first wanted.

        Args:
            namespaces: whether each untrusted process gets namespaces and a private
                root; without, Landlock alone keeps student code from files.
        """
        self._namespaces = namespaces
        # Servers end with this process; others that get a copy of this object share them.
        self._owner = os.getpid()
        folder = tempfile.gettempdir()
        short = folder if len(folder) <= LONGEST else "/tmp"
        self.home = Path(short, f"autograder-{secrets.token_hex(8)}")
        """Folder of the servers' sockets and of scratch folders; it goes with its owner."""

    def __getstate__(self) -> dict[str, Any]:
        """Make the servers' folder before others get a copy: none but the owner may."""
        if os.getpid() == self._owner:
            self._make_home()
        return self.__dict__

    def problem(self) -> str | None:
        """Try it once."""
        return _problem(self)

    def start(self, launch: Launch) -> Forked:
        """Have a server fork it; the first start of its kind starts the server.

        Raises:
            GraderFailure: the server does not start; says why.
        """
        connection = self._connect(launch)
        student_reader, writer = os.pipe()
        reader, student_writer = os.pipe()
        request = repr(asdict(launch)).encode()
        socket.send_fds(connection, [request], [student_reader, student_writer])
        os.close(student_reader)
        os.close(student_writer)
        said = connection.recv(fork_server.PID.size)
        if len(said) < fork_server.PID.size:
            for descriptor in (reader, writer, connection.detach()):
                os.close(descriptor)
            raise GraderFailure("The fork server started nothing.")
        (keeper,) = fork_server.PID.unpack(said)
        return Forked(keeper, reader, writer, connection)

    def _connect(self, launch: Launch) -> socket.socket:
        kind = repr((launch.withheld, launch.preload, launch.packages)).encode()
        address = self.home / hashlib.sha256(kind).hexdigest()[:16]
        with contextlib.suppress(OSError):
            return _dial(address)
        if os.getpid() == self._owner:
            self._make_home()
        if not self.home.is_dir():
            raise GraderFailure("The fork servers have ended with the process that owned them.")
        # Closed to other users, who could hold a lock on any file that they can open.
        descriptor = os.open(self.home / "lock", os.O_WRONLY | os.O_CREAT, 0o600)
        with open(descriptor, "w") as file:
            fcntl.flock(file, fcntl.LOCK_EX)
            with contextlib.suppress(OSError):
                return _dial(address)  # another process was faster
            address.unlink(missing_ok=True)
            self._start_server(launch, address)
        return _dial(address)

    def _make_home(self) -> None:
        if self.home.is_dir():
            return
        self.home.mkdir(mode=0o700)
        atexit.register(shutil.rmtree, self.home, ignore_errors=True)
        (self.home / "root").mkdir()
        if os.getuid() == 0:
            # Scratch folders are in it, and student code has a user id of its own.
            self.home.chmod(0o711)

    def _start_server(self, launch: Launch, address: Path) -> None:
        settings = {
            **terms.imports(launch),
            "withheld": launch.withheld,
            "preload": launch.preload,
            "address": str(address),
            "owner": self._owner,
        }
        files = view.files(launch.packages, launch.withheld)
        done = subprocess.run(
            terms.python_script(Path(fork_server.__file__), settings),
            input=pickle.dumps(Server(self.home, self._namespaces, files)),
            capture_output=True,
            cwd="/",
            env=ENVIRONMENT | {"MPLCONFIGDIR": str(view.font_folder())},
        )
        if done.stdout != fork_server.READY:
            why = done.stderr.decode(errors="replace").strip()[-500:]
            raise GraderFailure(f"The fork server did not start: {why or 'it says nothing'}")


def _dial(address: Path) -> socket.socket:
    connection = socket.socket(socket.AF_UNIX)
    try:
        connection.connect(str(address))
    except OSError:
        connection.close()
        raise
    return connection


@cache
def _problem(wall: Fork) -> str | None:
    if sys.platform != "linux":
        return "it needs Linux"
    if platform.machine() not in seccomp.ARCHITECTURES:
        return f"no filter of system calls is known for {platform.machine()}"
    problem = None if wall._namespaces else _landlock_problem()
    if problem:
        return problem
    try:
        running = wall.start(Launch(withheld=(), used=(), cpu_seconds=20, packages=()))
    except (GraderFailure, OSError) as error:
        return str(error)
    try:
        return running.await_ready()
    finally:
        running.stop()


def _landlock_problem() -> str | None:
    is_root = os.getuid() == 0
    found, wanted = landlock.version(), 1 if is_root else landlock.SIGNALS_VERSION
    if found < wanted:
        return f"the kernel's Landlock has version {found}, and {wanted} is needed"
    closed = _closed_folders() if is_root else []
    if closed:
        return f"student code, as a user of its own, cannot enter {closed[0]}, where Python is"
    return None


def _closed_folders() -> list[Path]:
    """Return folders on the way to what student code needs that other users cannot enter."""
    needed = [path for path, _ in view.readable(view.files(DEFAULT_PACKAGES, ()))]
    ways = dict.fromkeys(folder for path in needed for folder in [path, *path.parents])
    return [way for way in ways if way.is_dir() and not way.stat().st_mode & stat.S_IXOTH]
