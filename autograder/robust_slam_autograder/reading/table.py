"""Settings that a person wrote as TOML: read whole, with keys and types that are known."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

from robust_slam_autograder.errors import WrongUse


def read_table(path: Path, types: dict[str, Any]) -> dict[str, Any]:
    """Return the table of a TOML file, whose keys have the ``types``.

    Raises:
        WrongUse: names the file, and what cannot be read or the key.
    """
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise WrongUse(f"{path} cannot be read: {error.strerror}.") from error
    except ValueError as error:
        raise WrongUse(f"{path} is not valid TOML: {error}.") from error
    check_table(path, table, types)
    return table


def check_table(path: Path, table: dict[str, Any], types: dict[str, Any]) -> None:
    """Refuse keys of a TOML file that are unknown, or whose values have a wrong type.

    Raises:
        WrongUse: names the file and the key.
    """
    for key, value in table.items():
        if key not in types:
            raise WrongUse(f"{path}: unknown key {key!r}; known are {', '.join(types)}.")
        if not isinstance(value, types[key]) or isinstance(value, bool):
            raise WrongUse(f"{path}: {key} has a value of the wrong type ({value!r}).")
