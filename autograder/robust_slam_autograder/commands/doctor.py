"""``autograder doctor``: which sandboxes work here, why the others do not, and what to do."""

from __future__ import annotations

import argparse
import os
import platform
import shutil
from pathlib import Path
from typing import Any

from robust_slam_autograder import sandbox
from robust_slam_autograder.sandbox import landlock

RESTRICTIONS = {
    "kernel.apparmor_restrict_unprivileged_userns": ("1", "0"),
    "kernel.unprivileged_userns_clone": ("0", "1"),
    "user.max_user_namespaces": ("0", "10000"),
}
"""Settings of the kernel that keep ordinary users from namespaces, and what would let them."""


def add(commands: Any) -> None:  # noqa: ANN401
    """Declare the command."""
    parser = commands.add_parser("doctor", help="say which sandboxes work on this machine")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Try every back end; exit status 1 where none works."""
    who = "root" if os.getuid() == 0 else "an ordinary user"
    print(f"{platform.system()} {platform.release()}, {platform.machine()}, run by {who}")
    problems = {name: wall.problem() for name, wall in sandbox.BACK_ENDS.items()}
    for name, problem in problems.items():
        print(f"✓ works       {name}" if problem is None else f"✗ unusable    {name}: {problem}")
        if problem is not None:
            print(f"              {mend(name, problem)}")
    works = next((name for name, problem in problems.items() if problem is None), None)
    print(
        f"Grading uses {works}; --sandbox NAME takes another."
        if works
        else "Hidden tests are refused here, unless --unsandboxed says that all is trusted."
    )
    return 0 if works else 1


def mend(name: str, problem: str) -> str:
    """Say what to do about a back end that does not work.

    Args:
        name: the back end's.
        problem: what it said.
    """
    if platform.system() != "Linux":
        return "Grade on Linux: in a virtual machine, WSL, or your CI's Ubuntu runner."
    if name == "bubblewrap" and shutil.which("bwrap") is None:
        return "Install it: apt-get install bubblewrap, dnf install bubblewrap."
    if name == "landlock":
        return _mend_landlock()
    closed = [f"{key}={good}" for key, (bad, good) in RESTRICTIONS.items() if _setting(key) == bad]
    if closed:
        return f"Allow namespaces: sysctl -w {closed[0]}, or grade as root."
    if "denied" in problem or "permitted" in problem:
        return "Something keeps namespaces from this user: grade as root, outside a container."
    return "Report this with the line above."


def _mend_landlock() -> str:
    if landlock.version() == 0:
        return "Boot a kernel with Landlock (Linux 5.13, lsm=landlock), outside a container."
    if os.getuid() == 0:
        return "Put Python and the course where every user may read them, such as /usr/local."
    return "Use Linux 6.12 or newer, or grade as root."


def _setting(key: str) -> str:
    try:
        return Path("/proc/sys", key.replace(".", "/")).read_text().strip()
    except OSError:
        return ""
