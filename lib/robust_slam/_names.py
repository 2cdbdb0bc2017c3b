"""Short names of a package, loaded when first used, and where a name is that it lacks."""

import ast
import inspect
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib import import_module
from importlib.abc import InspectLoader, MetaPathFinder
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import ModuleType

FOLDERS = ["estimators", "groups", "files", "graphs", "descent", "consistency", "certificates"]
FOLDERS += ["factors", "fleet"]


def attach(
    package: str, file: str
) -> tuple[Callable[[str], object], Callable[[], list[str]], list[str]]:
    """Return ``__getattr__``, ``__dir__`` and ``__all__`` of a package, by its stub.

    The stub beside ``file`` imports the names, from the package or from another one. The error
    about a name that it lacks tells the place.
    """
    stub = ast.parse(Path(file).with_suffix(".pyi").read_text(encoding="utf-8"))
    imports = [node for node in stub.body if isinstance(node, ast.ImportFrom)]
    places = {name.name: node for node in imports for name in node.names}
    root = __name__.partition(".")[0]

    def find(name: str) -> object:
        if name in places:
            node = places[name]
            if not node.module:
                return import_module(f".{name}", package)
            return getattr(import_module("." * node.level + node.module, package), name)
        for other in (root, *(f"{root}.{folder}" for folder in FOLDERS)):
            if other != package and name in import_module(other).__all__:
                words = f"{package} has no {name}; it is {other}.{name}"
                raise AttributeError(words, name=name)
        raise AttributeError(f"{package} has no {name}", name=name)

    return find, lambda: sorted(places), sorted(places)


@dataclass(frozen=True)
class Moved(MetaPathFinder, InspectLoader):
    """Finds modules, ``now`` by name, under the names that they had in earlier releases."""

    now: dict[str, str]

    def find_spec(
        self, name: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Return a spec where ``name`` is an earlier one."""
        return ModuleSpec(name, self) if name in self.now else None

    def exec_module(self, module: ModuleType) -> None:
        """Put the module as it is called now in the place of ``module``."""
        sys.modules[module.__name__] = import_module(self.now[module.__name__])

    def get_source(self, name: str) -> str:
        """Return the source of the module, for ``python -m``."""
        return inspect.getsource(import_module(self.now[name]))
