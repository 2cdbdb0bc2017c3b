"""The untrusted process: runs the student's cells and answers calls of their functions.

Started by ``session`` inside a sandbox, as a script. Nothing here guards
anything: student code shares this process and may rewrite all of it. What it
can reach is the sandbox's business, what it says is checked on the other side.
"""

from __future__ import annotations

import ast
import builtins
import importlib.abc
import linecache
import os
import resource
import sys
import types
from collections.abc import Callable, Sequence
from typing import Any

READY = b"ready\n"
CELL_MAGICS_THAT_RUN = frozenset({"time", "timeit", "capture", "prun"})


class Withheld(importlib.abc.MetaPathFinder):
    """Refuses the modules that hold an assignment's answers."""

    def __init__(self, modules: Sequence[str]) -> None:
        self._modules = tuple(modules)

    def find_spec(self, fullname: str, path: object = None, target: object = None) -> None:
        """Raise ImportError, with the sentence that says why, for a withheld module."""
        for module in self._modules:
            if fullname == module or fullname.startswith(module + "."):
                raise ImportError(withheld_sentence(module), name=fullname)


def withheld_sentence(module: str) -> str:
    """Say why a module is not there."""
    return (
        f"{module} is withheld in this assignment: "
        "it holds the answer that you are asked to write yourself."
    )


class Shell:
    """Stands in for IPython's shell: line magics do nothing, cell magics run their cell."""

    def __init__(self, run: Callable[[str], object]) -> None:
        self._run = run

    def run_cell_magic(self, name: str, line: str, cell: str) -> None:
        """Run the body of ``%%time`` and its like; other cell magics are left out."""
        if name in CELL_MAGICS_THAT_RUN:
            self._run(cell)

    def __getattr__(self, name: str) -> Callable[..., None]:
        return lambda *args, **kwargs: None


class Notebook:
    """The module that the student's cells run in."""

    def __init__(self) -> None:
        # Dataclasses and type hints look their module up by name: it must be registered,
        # and notebooks know themselves as __main__.
        self.module = types.ModuleType("__main__")
        sys.modules["__main__"] = self.module
        self.module.__dict__["get_ipython"] = lambda: Shell(self._run_magic)
        self._labels: set[str] = set()

    def run(self, label: str, source: str) -> None:
        """Run one cell; ``label`` names it in messages."""
        self._labels.add(label)
        linecache.cache[label] = (len(source), None, source.splitlines(True), label)
        tree = ast.parse(source, label)
        code = compile(tree, label, "exec", dont_inherit=True)
        exec(code, self.module.__dict__)  # running student code is what this process is for

    def _run_magic(self, source: str) -> None:
        self.run("magic", source)

    def kinds(self, names: list[str]) -> dict[str, str]:
        """Say of each name whether it is a "function", a "value" or "missing"."""
        found = self.module.__dict__
        said = {name: "function" if callable(found[name]) else "value" for name in found}
        return {name: said.get(name, "missing") for name in names}

    def value(self, name: str) -> object:
        """A variable's value."""
        return self.module.__dict__[name]

    def call(self, name: str, args: list[Any], kwargs: dict[str, Any]) -> object:
        """Call a function of the notebook by name."""
        return self.module.__dict__[name](*args, **kwargs)

    def describe(self, error: BaseException) -> dict[str, Any]:
        """Tell an exception's classes, its message and the line of the student's cell."""
        from robust_slam_autograder.channel import describe_error

        told = describe_error(error)
        if isinstance(error, SyntaxError):
            told["message"], told["line"] = str(error.msg), error.lineno
            return told
        trace = error.__traceback__
        while trace is not None:
            if trace.tb_frame.f_code.co_filename in self._labels:
                told["line"] = trace.tb_lineno
            trace = trace.tb_next
        return told


def limit(limits: dict[str, int]) -> None:
    """Set resource limits by their names in the resource module, soft and hard alike."""
    for name, value in limits.items():
        kind = getattr(resource, name, None)
        if kind is None:
            continue
        hard = resource.getrlimit(kind)[1]
        if hard != resource.RLIM_INFINITY:
            value = min(value, hard)
        resource.setrlimit(kind, (value, value))


def drop_to(uid: int | None) -> None:
    """Become an ordinary user for good."""
    if uid is not None:
        os.setgroups([])
        os.setresgid(uid, uid, uid)
        os.setresuid(uid, uid, uid)


def set_aside_pipes() -> tuple[int, int]:
    """Move the pipes away from 0 and 1, so that print and input cannot touch them."""
    read_fd, write_fd = os.dup(0), os.dup(1)
    os.write(write_fd, READY)
    null = os.open(os.devnull, os.O_RDWR)
    for descriptor in (0, 1, 2):
        os.dup2(null, descriptor)
    return read_fd, write_fd


def main() -> None:
    """Read the settings from the command line, then serve the other side."""
    settings = ast.literal_eval(sys.argv[1])
    sys.path[:] = settings["path"]
    sys.argv[:] = [""]
    from robust_slam_autograder.channel import Channel, ChannelClosed

    limit(settings["limits"])
    drop_to(settings["uid"])
    read_fd, write_fd = set_aside_pipes()
    sys.meta_path.insert(0, Withheld(settings["withheld"]))
    notebook = Notebook()
    builtins.exit = builtins.quit = sys.exit  # type: ignore[assignment]
    channel = Channel(
        read_fd,
        write_fd,
        named={
            "run": notebook.run,
            "kinds": notebook.kinds,
            "value": notebook.value,
            "call": notebook.call,
        },
        describe=notebook.describe,
    )
    try:
        channel.serve()
    except ChannelClosed:
        os._exit(0)


if __name__ == "__main__":
    main()
