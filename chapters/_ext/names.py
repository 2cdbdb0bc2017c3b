"""Keeps what a notebook's names stand for after each cell, while it runs for its page.

A number of the text is then compared with the very run whose outputs the page shows.
"""

from __future__ import annotations

import functools
import hashlib
import io
import os
import pickle
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import cloudpickle
from IPython import get_ipython
from IPython.core.interactiveshell import ExecutionResult

FOLDER = "ROBUST_SLAM_NAMES"
"""The variable that tells a kernel where to keep names."""
BESIDE = "names"
"""The folder in the cache of executed notebooks."""
CACHED = type(functools.cache(abs))
PYTHONS = frozenset({"In", "Out", "exit", "quit", "open", "get_ipython"})


def keep() -> None:
    """Keep the names of this kernel's notebook after each of its cells."""
    shell, digest = get_ipython(), hashlib.sha256()
    before: dict[str, bytes] = {}

    def after_a_cell(result: ExecutionResult) -> None:
        changed = {}
        for name, value in shell.user_ns.items():
            if name not in PYTHONS and not name.startswith("_"):
                data = _pickled(value)
                if data is not None and before.get(name) != data:
                    changed[name] = before[name] = data
        path = _path(Path(os.environ[FOLDER]), _next(digest, result.info.raw_cell))
        path.parent.mkdir(parents=True, exist_ok=True)
        whole = path.with_suffix(f".{os.getpid()}")
        whole.write_bytes(pickle.dumps(changed))
        whole.replace(path)  # another page may begin with the same cells

    shell.events.register("post_run_cell", after_a_cell)


def kept(folder: Path, sources: Iterable[str]) -> Iterator[dict[str, Any]]:
    """Yield the names after each cell of a notebook, as they were when it ran.

    Args:
        folder: Where they are kept.
        sources: The code of the notebook, cell by cell; cells without any do not run.

    Raises:
        FileNotFoundError: The notebook has not run as it is now.
    """
    digest = hashlib.sha256()
    names: dict[str, Any] = {}
    for source in sources:
        if source.strip():
            changed = pickle.loads(_path(folder, _next(digest, source)).read_bytes())
            names |= {name: pickle.loads(data) for name, data in changed.items()}
        yield names


class _Keeper(cloudpickle.Pickler):  # type: ignore[misc]
    """Keeps data and functions, and in place of what is drawn, which would be most of it, None."""

    def reducer_override(self, value: object) -> object:
        """Return how a value is made again."""
        if type(value).__module__.startswith("matplotlib."):
            return type(None), ()
        if isinstance(value, CACHED):  # would be looked for by its name alone
            return functools.cache, (value.__wrapped__,)
        return super().reducer_override(value)


def _pickled(value: object) -> bytes | None:
    """Return a value as bytes, or nothing where it cannot be kept, as a lock."""
    data = io.BytesIO()
    try:
        _Keeper(data).dump(value)
    except Exception:  # whatever a class raises that was not made to be kept
        return None
    return data.getvalue()


def _next(digest: hashlib._Hash, source: str) -> str:
    """Return what names a cell: all that has run before it and the cell itself."""
    digest.update(repr(source).encode())
    return str(digest.hexdigest()[:20])


def _path(folder: Path, key: str) -> Path:
    return folder / f"{key}.pickle"
