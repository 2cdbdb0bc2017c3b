"""Folders that are whole or not there: made beside their place, and renamed into it."""

import contextlib
import os
import shutil
from collections.abc import Iterator
from pathlib import Path


@contextlib.contextmanager
def made_beside(target: Path) -> Iterator[Path]:
    """An empty folder beside ``target``, on the same disk; it is gone afterwards.

    A run that was killed leaves it, under a fixed name: the next one clears it away.
    """
    folder = target.resolve()
    folder = folder.with_name(f".{folder.name}.part")
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def put(made: Path, target: Path) -> None:
    """Move a finished file or folder to its place; what was there goes when it is in."""
    target.parent.mkdir(parents=True, exist_ok=True)
    if not made.is_dir():
        os.replace(made, target)
        return
    old = made.with_name(f".{made.name}.old")
    there = target.exists()
    if there:
        os.rename(target, old)
    try:
        os.rename(made, target)
    except OSError:
        if there:
            os.rename(old, target)
        raise
    shutil.rmtree(old, ignore_errors=True)
