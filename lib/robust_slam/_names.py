"""Short names of a package, loaded when first used, and where a name is that it lacks."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module

import lazy_loader  # type: ignore[import-untyped]

FOLDERS = ("estimators", "graphs", "descent", "consistency", "certificates", "factors", "fleet")


def attach(
    package: str, file: str
) -> tuple[Callable[[str], object], Callable[[], list[str]], list[str]]:
    """Return what ``lazy_loader.attach_stub`` does; the first names the place of other names."""
    load, listed, names = lazy_loader.attach_stub(package, file)

    def find(name: str) -> object:
        try:
            return load(name)
        except AttributeError:
            root = __name__.partition(".")[0]
            for other in (root, *(f"{root}.{folder}" for folder in FOLDERS)):
                if other != package and name in import_module(other).__all__:
                    raise AttributeError(
                        f"{package} has no {name}; it is {other}.{name}", name=name
                    ) from None
            raise

    return find, listed, names
