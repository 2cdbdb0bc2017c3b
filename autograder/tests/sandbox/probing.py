"""How tests look at a sandbox from within, and at its processes from outside."""

from pathlib import Path
from typing import Any

import psutil
from robust_slam_autograder import sandbox
from robust_slam_autograder.reading.defaults import DEFAULT_PACKAGES, Limits
from robust_slam_autograder.sandbox import Launch, Sandbox

from .. import as_user, kernel
from ..sessions import started

ATTACKERS = (*DEFAULT_PACKAGES, "ctypes", "socket", "subprocess")
"""What attacks import: they are to reach the wall, not what tells students of the allow-list."""
LAUNCH = Launch(withheld=(), used=(), cpu_seconds=20)


def walls() -> list[str]:
    """All back ends; Landlock where student code can reach Python, else see the views."""
    closed = as_user.may() and not kernel.supports("landlock")
    return [name for name in sandbox.BACK_ENDS if not (closed and name == "landlock")]


def is_private(wall: Sandbox) -> bool:
    """Whether it gives student code a root and processes of its own."""
    return wall is not sandbox.BACK_ENDS["landlock"]


def run(wall: Sandbox, name: str, *cells: str, **options: Any) -> Any:
    """Run cells behind a wall and call one of their functions."""
    limits = Limits(call_seconds=30, cell_seconds=30, notebook_seconds=60)
    options = {"packages": ATTACKERS, **options}
    with started(*cells, names=(name,), limits=limits, wall=wall, **options) as session:
        assert not session.errors, {label: str(error) for label, error in session.errors.items()}
        return session.bindings()[name]()


def processes_of(home: Path) -> list[psutil.Process]:
    """The fork servers of a folder, and what they forked."""
    found = []
    for process in psutil.process_iter():
        try:
            if str(home) in " ".join(process.cmdline()):
                found.append(process)
        except psutil.Error:
            continue
    return found
