"""The untrusted process: runs the student's cells and answers calls of their functions.

Started by ``session`` inside a sandbox, as a script. Nothing here guards
anything: student code shares this process and may rewrite all of it. What it
can reach is the sandbox's business, what it says is checked on the other side.
"""

from __future__ import annotations
import __future__

import ast
import builtins
import contextlib
import inspect
import linecache
import os
import sys
import types
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import asyncio

READY = b"ready\n"
_FEATURES = (getattr(__future__, name) for name in __future__.all_feature_names)
FUTURE_FLAGS = sum(feature.compiler_flag for feature in _FEATURES)


class Shell:
    """Stands in for IPython's shell: magics and shell commands do nothing."""

    def __getattr__(self, name: str) -> Callable[..., None]:
        return do_nothing


def do_nothing(*args: object, **kwargs: object) -> None:
    """Stand in for what only shows something."""


def notebook_names() -> dict[str, Any]:
    """Names that a notebook has without defining them."""
    shell = Shell()
    return {"get_ipython": lambda: shell, "display": do_nothing}


@dataclass(frozen=True)
class Cell:
    """A cell that was read: its code, and whether only its definitions run."""

    label: str
    tree: ast.Module
    own: bool


class Notebook:
    """A module that cells run in: first all are read, then each is run."""

    def __init__(self, module: types.ModuleType, used: Collection[str] = ()) -> None:
        # Dataclasses and type hints look their module up by name.
        sys.modules[module.__name__] = module
        self.names = module.__dict__
        self.names.update(notebook_names())
        self._used = set(used)
        self._cells: dict[int, Cell] = {}
        self._future = 0

    def read(self, number: int, label: str, source: str, own: bool) -> None:
        """Read a cell; ``label`` names it in messages, ``own`` is as in ``source.helpers``."""
        from robust_slam_autograder.reading.source import plain_python

        linecache.cache[label] = (len(source), None, source.splitlines(True), label)
        self._cells[number] = Cell(label, ast.parse(plain_python(source), label), own)

    def run(self, number: int) -> None:
        """Run a cell that was read, as far as it is to run."""
        cell = self._cells[number]
        if not cell.own:
            self._execute(cell.tree, cell.label)
            return
        for node in cell.tree.body:
            if node in self._helpers:
                with contextlib.suppress(BaseException):  # a scratch cell may fail in any way
                    self._execute(ast.Module([node], []), cell.label)

    @cached_property
    def _helpers(self) -> set[ast.stmt]:
        from robust_slam_autograder.reading.source import helpers, used_names

        cells = self._cells.values()
        used = self._used.union(*(used_names(*cell.tree.body) for cell in cells if not cell.own))
        return helpers([cell.tree for cell in cells if cell.own], used)

    def compiled(self, tree: ast.Module, label: str) -> types.CodeType:
        """Compile what is about to run."""
        flags = self._future | ast.PyCF_ALLOW_TOP_LEVEL_AWAIT
        code: types.CodeType = compile(
            tree, label, "exec", flags=flags, dont_inherit=True, optimize=0
        )
        return code

    def _execute(self, tree: ast.Module, label: str) -> None:
        code = self.compiled(tree, label)
        # As in a notebook, `from __future__ import …` holds for the cells that follow too.
        self._future |= code.co_flags & FUTURE_FLAGS
        result = eval(code, self.names)
        if code.co_flags & inspect.CO_COROUTINE:
            self._loop.run_until_complete(result)

    @cached_property
    def _loop(self) -> asyncio.AbstractEventLoop:
        """One for all cells, as in a notebook: a task may be awaited in a later cell."""
        import asyncio

        loop = asyncio.new_event_loop()
        asyncio.set_event_loop(loop)
        return loop

    def kinds(self, names: list[str]) -> dict[str, str]:
        """Say of each name whether it is a "function", a "value" or "missing"."""
        found = {name: self.names[name] for name in names if name in self.names}
        said = {name: "function" if callable(item) else "value" for name, item in found.items()}
        return {name: said.get(name, "missing") for name in names}

    def value(self, name: str) -> object:
        """A variable's value."""
        return self.names[name]

    def call(self, name: str, args: list[Any], kwargs: dict[str, Any]) -> object:
        """Call a function of the notebook by name."""
        return self.names[name](*args, **kwargs)

    def describe(self, error: BaseException) -> dict[str, Any]:
        """Tell an exception's classes, its message and the line of the student's cell."""
        from robust_slam_autograder.student.channel import describe_error

        told = describe_error(error)
        if isinstance(error, SyntaxError):
            told["message"], told["line"] = str(error.msg), error.lineno
            return told
        labels = {cell.label for cell in self._cells.values()}
        trace = error.__traceback__
        while trace is not None:
            if trace.tb_frame.f_code.co_filename in labels:
                told["line"] = trace.tb_lineno
            trace = trace.tb_next
        return told


def limit(limits: dict[str, int]) -> None:
    """Set resource limits by their names in the resource module, soft and hard alike."""
    import resource  # a browser has none

    for name, value in limits.items():
        kind = getattr(resource, name, None)
        if kind is None:
            continue
        hard = resource.getrlimit(kind)[1]
        if hard != resource.RLIM_INFINITY:
            value = min(value, hard)
        # Only Linux has a wall and keeps every limit; macOS refuses some.
        with contextlib.suppress(*(() if sys.platform == "linux" else (ValueError, OSError))):
            resource.setrlimit(kind, (value, value))


def volunteer_for_the_memory_killer() -> None:
    """When memory runs out, the kernel shall end this process and not a neighbour."""
    with contextlib.suppress(OSError), open("/proc/self/oom_score_adj", "w") as file:
        file.write("1000")


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

    def leave_the_conversation() -> None:
        for descriptor in (read_fd, write_fd):
            os.dup2(null, descriptor)

    # A forked child that answered too would spoil the exercises that follow.
    os.register_at_fork(after_in_child=leave_the_conversation)
    return read_fd, write_fd


def main() -> None:
    """Read the settings from the command line, then serve the other side."""
    settings = ast.literal_eval(sys.argv[1])
    sys.path[:] = settings["path"]
    # By its file: until it is there, no package in a source folder is found.
    sys.path.insert(0, settings["grader"])
    from robust_slam_autograder.student import imports

    del sys.path[0]
    imports.Installed(**settings["installed"]).install()
    volunteer_for_the_memory_killer()
    limit(settings["limits"])
    drop_to(settings["uid"])
    serve(settings["withheld"], settings["used"], settings["packages"])


def serve(withheld: Sequence[str], used: Sequence[str], packages: Sequence[str]) -> None:
    """Answer calls on standard input and output until they close.

    Args:
        withheld: modules that may not be imported.
        used: names that tests use.
        packages: what student code may import beside the standard library.
    """
    from robust_slam_autograder.student import imports
    from robust_slam_autograder.student.channel import Channel, ChannelClosed

    sys.argv[:] = [""]
    read_fd, write_fd = set_aside_pipes()
    sys.meta_path.insert(0, imports.Withheld(withheld))
    builtins.exit = builtins.quit = sys.exit  # type: ignore[assignment]
    builtins.help = do_nothing  # type: ignore[assignment]
    # Notebooks know themselves as __main__.
    notebook = Notebook(types.ModuleType("__main__"), used)
    notebook.names["__builtins__"] = imports.student_builtins(packages, withheld)
    served = (notebook.read, notebook.run, notebook.kinds, notebook.value, notebook.call)
    channel = Channel(
        read_fd,
        write_fd,
        named={function.__name__: function for function in served},
        describe=notebook.describe,
        tells=BaseException,
    )
    try:
        channel.serve()
    except ChannelClosed:
        os._exit(0)


if __name__ == "__main__":
    main()
