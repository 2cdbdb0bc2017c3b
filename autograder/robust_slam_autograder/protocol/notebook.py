"""A module that cells run in: the student's in the untrusted process, tests in the trusted one."""

from __future__ import annotations
import __future__

import ast
import contextlib
import inspect
import linecache
import sys
import types
from collections.abc import Callable, Collection
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import asyncio

_FEATURES = (getattr(__future__, name) for name in __future__.all_feature_names)
FUTURE_FLAGS = sum(feature.compiler_flag for feature in _FEATURES)


class Shell:
    """Stands in for IPython's shell: magics and shell commands do nothing."""

    def __getattr__(self, name: str) -> Callable[..., None]:
        return do_nothing


def do_nothing(*args: object, **kwargs: object) -> None:
    """Stand in for what only shows something."""


def notebook_names() -> dict[str, Any]:
    """Return names that a notebook has without defining them."""
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
        code: types.CodeType = compile(tree, label, "exec", flags, dont_inherit=True, optimize=0)
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
        """Return one for all cells: as in a notebook a task may be awaited in a later one."""
        import asyncio

        loop = asyncio.new_event_loop()
        asyncio.set_event_loop(loop)
        return loop

    def kinds(self, names: list[str]) -> dict[str, str]:
        """Say of each name whether it is a "function", a "value" or "missing"."""
        found = {name: self.names[name] for name in names if name in self.names}
        said = {name: "function" if callable(item) else "value" for name, item in found.items()}
        return {name: said.get(name, "missing") for name in names}

    def reached(self, names: list[str]) -> dict[str, list[str]]:
        """Say of each name which of the names what it stands for depends on."""
        from robust_slam_autograder.reading.source import reached

        return reached(names, [cell.tree for cell in self._cells.values()])

    def value(self, name: str) -> object:
        """Return a variable's value."""
        return self.names[name]

    def call(self, name: str, args: list[Any], kwargs: dict[str, Any]) -> object:
        """Call a function of the notebook by name."""
        return self.names[name](*args, **kwargs)

    def describe(self, error: BaseException) -> dict[str, Any]:
        """Tell an exception's classes and message, and the line of the student's cell.

        The functions are the one that was called, and the one that raised.
        """
        from robust_slam_autograder.protocol.channel import describe_error

        told = describe_error(error)
        if isinstance(error, SyntaxError):
            told["message"], told["line"] = str(error.msg), error.lineno
            return told
        labels = {cell.label for cell in self._cells.values()}
        trace, names = error.__traceback__, []
        while trace is not None:
            code = trace.tb_frame.f_code
            if code.co_filename in labels:
                told["line"] = trace.tb_lineno
                names.append(code.co_name)
            trace = trace.tb_next
        return told | {"functions": [*names[:1], *names[-1:]]}
