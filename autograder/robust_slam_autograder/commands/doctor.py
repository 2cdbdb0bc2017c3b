"""``autograder doctor``: say which sandboxes work on this machine."""

import argparse
import os
import platform
import sys
from pathlib import Path

from robust_slam_autograder import sandbox
from robust_slam_autograder.commands import places
from robust_slam_autograder.errors import WrongUse
from robust_slam_autograder.grading import exposed_folders, pythons
from robust_slam_autograder.reading import assignment as assignments
from robust_slam_autograder.sandbox import cgroup, landlock

SETTINGS = Path("/proc/sys")
SEEN = "Student code sees Python and the allowed packages: no tests, submissions or results."
RESTRICTIONS = {
    "kernel.apparmor_restrict_unprivileged_userns": ("1", "0"),
    "kernel.unprivileged_userns_clone": ("0", "1"),
    "user.max_user_namespaces": ("0", "10000"),
}
"""Settings of the kernel that keep ordinary users from namespaces, and what would let them."""


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    places.add(parser, "--submitted", "--out")


def run(options: argparse.Namespace) -> int:
    """Try every back end; exit status 1 where none works or student code sees the tests."""
    who = "root" if os.getuid() == 0 else "an ordinary user"
    print(f"{platform.system()} {platform.release()}, {platform.machine()}, run by {who}")
    print(f"{pythons.shown(pythons.OURS)} grades what was written in it or in an older one.")
    places.warn_of_python(options.solutions, sys.stdout)
    problems = {name: one.problem() for name, one in sandbox.BACK_ENDS.items()}
    for name, problem in problems.items():
        print(f"✓ works       {name}" if problem is None else f"✗ unusable    {name}: {problem}")
        if problem is not None:
            print(f"              {remedy(name, problem)}")
    works = next((name for name, problem in problems.items() if problem is None), None)
    if works is None:
        print("Hidden tests are refused here, unless --unsandboxed says that all is trusted.")
        return 1
    print(f"Grading uses {works}; --sandbox NAME takes another.")
    print(_memory())
    problem = _exposure(options)
    print(problem or SEEN)
    return 1 if problem else 0


def _memory() -> str:
    """Return how the memory of a sandbox is counted."""
    problem = cgroup.problem()
    if problem is None:
        return "Memory is counted by the kernel, in a control group for each sandbox."
    return (
        f"Memory is counted process by process, since {problem}: "
        "grade as root, or inside `systemd-run --user --scope`, and the kernel counts it all."
    )


def _exposure(options: argparse.Namespace) -> str:
    """Return the sentence with which grading refuses this course; empty where it does not."""
    try:
        names = assignments.find_names(options.solutions) if options.solutions.is_dir() else []
        there = [assignments.of(options.solutions, name) for name in names]
        folders = [options.solutions, options.submitted, options.out]
        exposed_folders.refuse_unsafe(there, folders, sandbox.choose())
    except WrongUse as error:
        return f"Grading refuses this course: {error}"
    return ""


def remedy(name: str, problem: str) -> str:
    """Say what to do about a back end that does not work, by what it said."""
    if platform.system() != "Linux":
        return "Grade on Linux: in a virtual machine, WSL, or your CI's Ubuntu runner."
    if name == "landlock":
        return _landlock_remedy()
    closed = [f"{key}={good}" for key, (bad, good) in RESTRICTIONS.items() if _setting(key) == bad]
    if closed:
        return f"Allow namespaces: sysctl -w {closed[0]}, or grade as root."
    if "denied" in problem or "permitted" in problem:
        return "Something keeps namespaces from this user: grade as root, outside a container."
    return "Report this with the line above."


def _landlock_remedy() -> str:
    if landlock.version() == 0:
        return "Boot a kernel with Landlock (Linux 5.13, lsm=landlock), outside a container."
    if os.getuid() == 0:
        return "Put Python and the course where every user may read them, such as /usr/local."
    return "Use Linux 6.12 or newer, or grade as root."


def _setting(key: str) -> str:
    try:
        return Path(SETTINGS, *key.split(".")).read_text().strip()
    except OSError:
        return ""
