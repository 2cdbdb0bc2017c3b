"""Settings that a person wrote as TOML: read whole, with keys and types that are known."""

import tomllib
from collections.abc import Mapping
from pathlib import Path
from types import EllipsisType
from typing import Any

from robust_slam_autograder.errors import WrongUse

Kinds = Mapping[str | EllipsisType, Any]
"""By key, or for any by ``...``, a type or several, kinds for a table, or a list with one kind."""


def read_table(path: Path, kinds: Kinds) -> dict[str, Any]:
    """Return the table of a TOML file, whose keys and values are of the ``kinds``.

    Raises:
        WrongUse: names the file, and what cannot be read or the key.
    """
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise WrongUse(f"{path} cannot be read: {error.strerror}.") from error
    except ValueError as error:
        raise WrongUse(f"{path} is not valid TOML: {error}.") from error
    _check(path, table, kinds)
    return table


def _check(path: Path, table: Mapping[str, Any], kinds: Kinds, within: str = "") -> None:
    for key, value in table.items():
        kind = kinds.get(key, kinds.get(...))
        if kind is None:
            raise WrongUse(f"{path}: unknown key {key!r}; known are {', '.join(map(str, kinds))}.")
        whole = type(kind) if isinstance(kind, dict | list) else kind
        if not isinstance(value, whole) or isinstance(value, bool):
            raise WrongUse(f"{path}: {within}{key} has a value of the wrong type ({value!r}).")
        if isinstance(kind, list):
            value, kind = {f"{n}": one for n, one in enumerate(value, start=1)}, {...: kind[0]}
        if isinstance(kind, dict):
            _check(path, value, kind, f"{within}{key}.")
