"""The wall around student code: one small interface, one module per back end.

A back end starts ``untrusted.py`` with pipes for its standard input and output.
"""

import sys

from robust_slam_autograder.errors import WrongUse
from robust_slam_autograder.sandbox.in_process import InProcess
from robust_slam_autograder.sandbox.terms import Launch, Running, Sandbox

BACK_ENDS: dict[str, Sandbox] = {}
"""By the name to choose them by, the one to prefer first."""
if sys.platform != "emscripten":  # a browser starts no process
    from robust_slam_autograder.sandbox.fork import Fork
    from robust_slam_autograder.sandbox.process import Unsandboxed

    BACK_ENDS = {"fork": Fork(), "landlock": Fork(namespaces=False)}

__all__ = [
    "BACK_ENDS",
    "Fork",
    "InProcess",
    "Launch",
    "Running",
    "Sandbox",
    "Unsandboxed",
    "choose",
]


def choose(name: str | None = None, *, unsandboxed: bool = False) -> Sandbox:
    """Take a back end by its name, else the first that works here.

    Raises:
        WrongUse: none works and ``unsandboxed`` was not asked for; says what to install.
    """
    if unsandboxed:
        return InProcess() if sys.platform == "emscripten" else Unsandboxed()
    problems = []
    for key, wall in BACK_ENDS.items():
        if name in (None, key):
            problem = wall.problem()
            if problem is None:
                return wall
            problems.append(f"{key}: {problem}")
    which, remedy = ("This sandbox does not work", "name another --sandbox")
    if name is None:
        which, remedy = ("No sandbox works", "trust the submissions with --unsandboxed")
    raise WrongUse(
        f"{which} here ({'; '.join(problems)}), so hidden tests are not run: "
        f"see `autograder doctor`, or {remedy}."
    )
