"""Runs the cells of a page one after the other, as a notebook would, and says what came of it.

The page needs little of a notebook: the value of the last line, ``display``, figures, and
errors to read. IPython would be another 5 MB to load.
"""

import ast
import base64
import builtins
import contextlib
import io
import json
import linecache
import sys
import traceback
from collections.abc import Callable, Iterator
from itertools import dropwhile
from types import ModuleType
from typing import Any

from page_packages import Read, Shelf

LONGEST = 200_000
"""Characters that a cell may print; the rest is left out."""
LARGEST = 20_000_000
"""Characters of one thing that a cell shows, as a drawing has some."""
REPRESENTATIONS = {
    "_repr_html_": "text/html",
    "_repr_markdown_": "text/markdown",
    "_repr_svg_": "image/svg+xml",
    "_repr_png_": "image/png",
}
"""What an object may say of itself, in the order of IPython's documentation."""
PACKAGES = "/site-packages/"
CELL = "<cell "
"""How the names of cells begin in a traceback, before it is made readable."""

Shown = dict[str, Any]
"""One thing shown: ``data`` by type, and ``metadata``."""


class Printed(io.StringIO):
    """Keeps what is printed, up to a length."""

    is_cut = False

    def write(self, text: str) -> int:
        """Keep the text, or as much of it as there is room for."""
        if not self.is_cut:
            kept = cut(text, LONGEST - self.tell())
            self.is_cut = kept is not text
            super().write(kept)
        return len(text)


def cut(text: str, room: int = LONGEST) -> str:
    """Return the text, or as much of it as there is room for and a line that says so."""
    if len(text) <= room:
        return text
    return text[:room] + f"\n… cut after {LONGEST:,} characters\n"


class Session:
    """One namespace, in which cells run."""

    def __init__(self) -> None:
        self._module = ModuleType("__main__")
        self._shown: list[Shown] = []
        self._displayed: list[object] = []
        self._count = 0

    def run(self, code: str) -> dict[str, Any]:
        """Run a cell.

        Returns:
            ``text`` that it printed, ``shown``, a list of things with their ``data`` by type
            and ``metadata``, ``error``, a traceback or None, and its ``line`` of the cell.
        """
        self._count += 1
        name = f"{CELL}{self._count}>"
        linecache.cache[name] = len(code), None, code.splitlines(keepends=True), name
        self._shown, self._displayed = [], []
        printed, error, line = Printed(), None, None
        # Dataclasses and pickles look for the module of a class under its name.
        sys.modules["__main__"] = self._module
        with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(printed):
            try:
                self._execute(code, name)
                self.show_figures()
            except BaseException as raised:  # the reader's exit() and KeyboardInterrupt too
                error, line = readable(raised, name), line_of(raised, name)
                self.show_figures()
        return {"text": printed.getvalue(), "shown": self._shown, "error": error, "line": line}

    def _execute(self, code: str, name: str) -> None:
        """Run the statements; show the value of the last one, unless a semicolon ends it."""
        tree = ast.parse(code, name)
        last = None
        if tree.body and isinstance(tree.body[-1], ast.Expr):
            last = ast.Expression(tree.body.pop().value)
        names = self._module.__dict__
        exec(compile(tree, name, "exec"), names)
        if last is not None:
            value = eval(compile(last, name, "eval"), names)
            if value is not None and not code.rstrip().endswith(";"):
                names["_"] = value
                self.display(value)

    def display(self, *values: object, metadata: dict[str, Any] | None = None) -> None:
        """Show the values, as IPython's function of this name does."""
        for value in values:
            self._displayed.append(value)
            data, own = bundle(value)
            self._shown.append({"data": data, "metadata": own | (metadata or {})})

    def show_figures(self) -> None:
        """Show the figures that pyplot holds and the cell has not shown itself; close them."""
        pyplot = sys.modules.get("matplotlib.pyplot")
        if pyplot is not None:
            figures = [pyplot.figure(number) for number in pyplot.get_fignums()]
            done = {id(value) for value in self._displayed}
            self.display(*(figure for figure in figures if id(figure) not in done))
            pyplot.close("all")


def bundle(value: object) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return what a value says of itself, by type, and its metadata."""
    data: dict[str, Any] = {"text/plain": cut(repr(value))}
    metadata: dict[str, Any] = {}
    for method, kind in REPRESENTATIONS.items():
        said = _call(value, method)
        if said is not None:
            is_bytes = isinstance(said, bytes)
            data[kind] = base64.b64encode(said).decode() if is_bytes else said
    said = _call(value, "_repr_mimebundle_")
    if isinstance(said, tuple):
        said, metadata = said
    if isinstance(said, dict):
        data |= said
    figure = getattr(sys.modules.get("matplotlib.figure"), "Figure", None)
    if figure is not None and isinstance(value, figure):
        from robust_slam_course.figures import page_html

        data["image/svg+xml"] = page_html(value)
    large = [kind for kind, said in data.items() if len(str(said)) > LARGEST]
    for kind in large:
        del data[kind]
        data["text/plain"] = f"The {kind} of this value is too large for the page."
    return data, metadata


def _call(value: object, method: str) -> object:
    """Call a method of an object; classes and objects without it say nothing."""
    found: Callable[[], object] | None = getattr(value, method, None)
    return found() if callable(found) and not isinstance(value, type) else None


def readable(error: BaseException, cell: str) -> str:
    """Return what went wrong and the way to it, with the lines of cells and packages alone."""
    told = traceback.TracebackException.from_exception(error)
    for each in _chain(told):
        from_cells = dropwhile(lambda frame: not frame.filename.startswith(CELL), each.stack)
        each.stack[:] = [frame for frame in from_cells if frame.filename != __file__]
        for frame in each.stack:
            assert frame.line is not None  # reads the line, before the file has another name
            frame.filename = _place(frame.filename, cell)
        if isinstance(error, SyntaxError) and each.filename == cell:
            each.filename = _place(cell, cell)
    last = "".join(told.format_exception_only()).rstrip()
    way = "".join(told.format()).rstrip()
    cause = below = last.split("\n")[-1] if isinstance(error, SyntaxError) else last
    if isinstance(error, ModuleNotFoundError):
        # What Pyodide adds speaks of its own installer.
        cause = cause.split("\nThe module ")[0]
        cause += "\nIn the page there are NumPy, SciPy, Matplotlib and the course's library."
    if isinstance(error, SyntaxError) and (error.text or "").lstrip().startswith(("!", "%")):
        cause += "\nCommands that begin with ! or % are for notebooks; the page runs Python alone."
    return f"{cause}\n\n{way.removesuffix(below).rstrip()}"


def line_of(error: BaseException, cell: str) -> int | None:
    """Return the line of the cell at which an error arose, or None."""
    if isinstance(error, SyntaxError) and error.filename == cell:
        return error.lineno
    lines = [line for frame, line in traceback.walk_tb(error.__traceback__)
             if frame.f_code.co_filename == cell]  # fmt: skip
    return lines[-1] if lines else None


def _chain(told: traceback.TracebackException | None) -> Iterator[traceback.TracebackException]:
    """The error, and those that led to it."""
    if told is not None:
        yield told
        yield from _chain(told.__cause__)
        yield from _chain(told.__context__)


def _place(path: str, cell: str) -> str:
    """Return how a reader calls a file."""
    if path == cell:
        return "this cell"
    if path.startswith(CELL):
        return "another cell"
    return path.split(PACKAGES)[-1]


def _no_input(prompt: object = "") -> str:
    raise RuntimeError("input() cannot ask in the page: write the answer into the code.")


class _Text:
    """Text that is shown as its type says."""

    def __init__(self, data: str) -> None:
        self.data = data


class Markdown(_Text):
    """Text that is shown as Markdown."""

    def _repr_markdown_(self) -> str:
        return self.data


class HTML(_Text):
    """Text that is shown as HTML."""

    def _repr_html_(self) -> str:
        return self.data


SESSION = Session()


def run(code: str) -> str:
    """Run a cell of the page, and return what came of it as JSON."""
    return json.dumps(SESSION.run(code))


def show(*_: object, **__: object) -> None:
    """Show the figures: ``pyplot.show`` of the page."""
    SESSION.show_figures()


def stand_in_for_ipython() -> None:
    """Put modules in IPython's place that hold what the chapters and the library import."""
    package, core, getter, shown = (
        ModuleType(name)
        for name in ("IPython", "IPython.core", "IPython.core.getipython", "IPython.display")
    )
    getter.get_ipython = package.get_ipython = lambda: None  # type: ignore[attr-defined]
    package.version_info = (8, 23, 0)  # type: ignore[attr-defined]  # pyplot asks
    package.display = shown  # type: ignore[attr-defined]
    for name, value in {"display": SESSION.display, "Markdown": Markdown, "HTML": HTML}.items():
        setattr(shown, name, value)
    sys.modules |= {module.__name__: module for module in (package, core, getter, shown)}


def prepare(packages: str, read: Read, link: Callable[[str], object]) -> Callable[[str], object]:
    """Make this process a page's: called once, before any cell.

    Args:
        packages: what code may import, the list of ``Shelf`` as JSON.
        read: as in ``Shelf``.
        link: as in ``Shelf``.

    Returns:
        A function that tells which files a cell's imports need, and are not at hand.
    """
    shelf = Shelf(json.loads(packages), read, link)
    sys.meta_path.insert(0, shelf)
    stand_in_for_ipython()
    names = SESSION._module.__dict__
    names |= {"display": SESSION.display, "__builtins__": builtins}
    builtins.input = _no_input
    return shelf.missing
