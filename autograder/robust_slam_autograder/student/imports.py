"""What student code may import: an allow-list of packages, less the withheld modules.

This tells students early and clearly what an assignment allows. It is no wall: student code
shares the process and may take it away. Behind the wall other packages are not on the disk.
"""

import builtins
import importlib.abc
import importlib.util
import sys
import types
from collections.abc import Mapping, Sequence
from importlib.machinery import ModuleSpec, PathFinder
from pathlib import Path

from robust_slam_autograder.protocol.notebook import do_nothing

NOTEBOOK_PACKAGES = ("IPython", "tqdm")
"""Always allowed: they show things in a notebook."""
REFUSED = "in this assignment"
_COMPANIONS = {"matplotlib": ("mpl_toolkits", "pylab")}
"""Further modules that come with a package."""
NOT_INSTALLED = ("ensurepip", "idlelib", "lib2to3", "test", "tkinter", "turtledemo", "venv")
"""Parts of the standard library that are not in the sandbox: windows, installers, tests."""
_NATIVE = ("ctypes", "_ctypes")
_PROGRAMS = ("subprocess", "_posixsubprocess", "pty")
_NETWORK = (
    *("ftplib", "http.client", "http.server", "imaplib", "nntplib", "poplib", "smtplib"),
    *("_socket", "socket", "socketserver", "_ssl", "ssl", "telnetlib", "urllib.request"),
    *("webbrowser", "wsgiref", "xmlrpc"),
)
NOT_HARMLESS = (*NOT_INSTALLED, "_tkinter", "turtle", *_NATIVE, *_PROGRAMS, *_NETWORK)
"""Parts of the standard library that student code may not import unless an assignment says so:
they open windows, call native code, start programs or use the network."""


def is_standard(module: str) -> bool:
    """Tell whether a module belongs to the standard library."""
    return module.partition(".")[0] in sys.stdlib_module_names


def refusal(module: str, packages: Sequence[str]) -> str | None:
    """Say why student code may not import a module where these packages are; None if it may."""
    top = module.partition(".")[0]
    allowed = [*packages, *NOTEBOOK_PACKAGES, "__main__"]
    allowed += [name for package in packages for name in _COMPANIONS.get(package, ())]
    if top in allowed or _within(module, packages):
        return None
    if is_standard(module) and not _within(module, NOT_HARMLESS):
        return None
    return (
        f"{module} is not available {REFUSED}, which allows "
        f"{', '.join([*packages, *NOTEBOOK_PACKAGES])} and those parts of the standard library "
        "that need no window, native code, other program or network."
    )


def _within(module: str, names: Sequence[str]) -> bool:
    return any(module == name or module.startswith(f"{name}.") for name in names)


def student_builtins(packages: Sequence[str], withheld: Sequence[str]) -> types.ModuleType:
    """Return the builtins of a student's cells, with an ``import`` that keeps to what is allowed.

    Only code that runs with these builtins is checked, so that packages import what they need.

    Args:
        packages: what student code may import.
        withheld: modules that ``Withheld`` refuses with a sentence of its own.
    """
    found = types.ModuleType(builtins.__name__, builtins.__doc__)
    found.__dict__.update(builtins.__dict__)
    plain_import = builtins.__import__

    def checked_import(
        name: str,
        globals: Mapping[str, object] | None = None,
        locals: Mapping[str, object] | None = None,
        fromlist: Sequence[str] | None = (),
        level: int = 0,
    ) -> types.ModuleType:
        if level == 0:
            for module in (name, *(f"{name}.{item}" for item in fromlist or ())):
                sentence = refusal(module, packages)
                if sentence is not None and not _within(module, withheld):
                    raise ModuleNotFoundError(sentence, name=module)
        found = plain_import(name, globals, locals, fromlist or (), level)
        draw_nowhere()
        return found

    found.__dict__["__import__"] = checked_import
    return found


def draw_nowhere() -> None:
    """Have every graphical back end be Agg, which needs no window, under whatever name."""
    matplotlib, pyplot = map(sys.modules.get, ("matplotlib", "matplotlib.pyplot"))
    switch = getattr(pyplot, "switch_backend", do_nothing)
    if pyplot is not None and switch.__module__ == pyplot.__name__:
        vars(pyplot)["switch_backend"] = lambda newbackend: switch("agg")
    if matplotlib is not None:
        vars(matplotlib)["use"] = do_nothing


class Withheld(importlib.abc.MetaPathFinder):
    """Refuses the modules that hold an assignment's answers."""

    def __init__(self, modules: Sequence[str]) -> None:
        self._modules = tuple(modules)

    def find_spec(self, fullname: str, path: object = None, target: object = None) -> None:
        """Raise ImportError, with the sentence that says why, for a withheld module."""
        for module in self._modules:
            if _within(fullname, [module]):
                raise ImportError(withheld_sentence(module), name=fullname)


def withheld_sentence(module: str) -> str:
    """Say why a module is not there."""
    return (
        f"{module} is withheld {REFUSED}: "
        "it holds the answer that you are asked to write yourself."
    )


class Installed(PathFinder):
    """Finds the allowed packages and what they need; no other package is installed.

    So the fork server, which has no wall, imports what a sandbox with one would.
    """

    def __init__(
        self, names: Sequence[str], in_place: Mapping[str, str], standard: Sequence[str]
    ) -> None:
        """Say what there is.

        Args:
            names: modules at the top level, beside the standard library's.
            in_place: of these the packages in a source folder, or one file, with that place.
            standard: the folders of the standard library.
        """
        self._names = frozenset(names)
        self._in_place = dict(in_place)
        self._standard = list(standard)

    def install(self) -> None:
        """Take the place of Python's own search of the import path."""
        sys.meta_path[:] = [self if finder is PathFinder else finder for finder in sys.meta_path]

    def find_spec(  # type: ignore[override]
        self,
        fullname: str,
        path: Sequence[str] | None = None,
        target: types.ModuleType | None = None,
    ) -> ModuleSpec | None:
        """Find a module of these packages or of the standard library."""
        if path is None and fullname in self._in_place:
            place = Path(self._in_place[fullname])
            if place.is_file():
                return importlib.util.spec_from_file_location(fullname, place)
            return importlib.util.spec_from_file_location(
                fullname, place / "__init__.py", submodule_search_locations=[str(place)]
            )
        if path is None and fullname not in self._names:
            path = self._standard
        return PathFinder.find_spec(fullname, path, target)
