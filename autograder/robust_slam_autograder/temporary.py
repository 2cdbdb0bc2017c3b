"""Temporary folders of a process that may be killed: a server that outlives it removes them."""

import shutil
import time
from pathlib import Path


def remove(folder: Path) -> None:
    """Remove a folder; processes that are just ending may still put a file there."""
    for _ in range(50):
        shutil.rmtree(folder, ignore_errors=True)
        if not folder.exists():
            return
        time.sleep(0.1)
