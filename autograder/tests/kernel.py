"""What this machine's kernel supports, found out without the grader's own code.

A back end that the kernel supports and that does not work is a fault, and fails its tests. Only
where the kernel lacks something are they left out.
"""

import ctypes
import os
import shutil
import socket
import sys
from functools import cache

import pytest
from robust_slam_autograder.sandbox import BACK_ENDS, Sandbox, Unsandboxed

from . import as_user

_LANDLOCK_CREATE_RULESET, _ASK_VERSION = 444, 1
_MOUNTS = "mount -t tmpfs none /mnt && mount -t proc none /proc"


def free_port() -> int:
    """A port of this machine that nothing listens on, chosen by the system."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


@cache
def supports(back_end: str) -> bool:
    """Whether the kernel supports a back end for this user."""
    if sys.platform != "linux":
        return False
    return {"fork": _namespaces, "landlock": _landlock}[back_end]()


@cache
def quickest() -> Sandbox:
    """What starts student code with the least work here, for tests of something else than walls.

    A fork server has imported numpy already, so that a start takes a third of the time.
    """
    return next((BACK_ENDS[name] for name in usable()), Unsandboxed())


def usable() -> list[str]:
    """The back ends that should work here, the preferred one first."""
    return [name for name, wall in BACK_ENDS.items() if supports(name) or wall.problem() is None]


def leave_out(reason: str) -> None:
    """Skip a test for want of something on this machine; under STRICT=1 fail instead."""
    if os.environ.get("ROBUST_SLAM_STRICT"):
        pytest.fail(f"STRICT: {reason}", pytrace=False)
    pytest.skip(reason)


def working(back_end: str) -> Sandbox:
    """A back end that works; where the kernel supports it and it does not, the test fails."""
    wall = BACK_ENDS[back_end]
    problem = wall.problem()
    if problem is not None and supports(back_end):
        pytest.fail(f"The kernel supports {back_end}, but it does not work: {problem}", False)
    if problem is not None:
        leave_out(f"{back_end} does not work here: {problem}")
    return wall


def is_soak(config: pytest.Config) -> bool:
    """Tell whether a test may take minutes: ``--depth soak`` in the course, ``-m ""`` here."""
    depth = config.getoption("depth", None)
    return bool(depth == "soak" if depth else "soak" not in config.option.markexpr)


def _namespaces() -> bool:
    own = [] if os.getuid() == 0 else ["--user", "--map-root-user"]
    kinds = ["--mount", "--pid", "--net", "--ipc", "--uts", "--fork"]
    if shutil.which("unshare") is None:
        return False
    command = ["unshare", *own, *kinds, "sh", "-c", _MOUNTS]
    return as_user.ended(command, cwd="/", timeout=60).returncode == 0


def _landlock() -> bool:
    libc = ctypes.CDLL(None)
    version = libc.syscall(_LANDLOCK_CREATE_RULESET, None, ctypes.c_size_t(0), _ASK_VERSION)
    if os.getuid() != 0:
        return bool(version >= 6)  # from here on no signal leaves the sandbox
    # Student code is another user, who may not enter a closed home where Python is.
    return bool(version >= 1) and not any(as_user.closed(way / "lib") for way in as_user.NEEDED)
