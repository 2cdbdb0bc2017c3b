"""Writing a text file at once: it is complete or not there."""

from __future__ import annotations

import os
import secrets
from collections.abc import Iterable
from pathlib import Path


def write_lines(path: str | os.PathLike[str], lines: Iterable[str]) -> None:
    """Write ``lines`` to a temporary file beside ``path``, then rename it to ``path``.

    Raises:
        OSError: the file cannot be written.
    """
    target = Path(path)
    part = target.with_name(f".{target.name}.{secrets.token_hex(4)}.part")
    try:
        with part.open("x", encoding="utf-8", newline="\n") as file:
            file.writelines(lines)
        part.replace(target)
    finally:
        part.unlink(missing_ok=True)
