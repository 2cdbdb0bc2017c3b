"""``python -m tools.runtime`` fills ``build/runtime``; with ``site FOLDER`` it copies it there."""

from __future__ import annotations

import os
import shutil
import sys
from collections.abc import Sequence
from pathlib import Path

from tools.runtime import pyodide, wheels

ROOT = Path(__file__).resolve().parents[2]
RUNTIME = ROOT / "build" / "runtime"


def make(root: Path = ROOT, runtime: Path = RUNTIME) -> None:
    """Collect all files of the runtime.

    Raises:
        RuntimeUnavailable: a file cannot be had; ``wheels.json`` is then missing.
    """
    (runtime / "wheels" / wheels.INDEX).unlink(missing_ok=True)
    pyodide.fetch(runtime / "pyodide", os.environ.get(pyodide.FOLDER))
    print("the course's packages and those that they need")
    wheels.build(root, runtime / "wheels", runtime / "pyodide")


def copy_to(site: Path, runtime: Path = RUNTIME) -> None:
    """Put the runtime into a built site, as links where the file system has them."""
    for name in ("pyodide", "wheels"):
        target = site / "python" / name
        shutil.rmtree(target, ignore_errors=True)
        shutil.copytree(runtime / name, target, copy_function=_link)


def _link(source: str, target: str) -> str:
    try:
        os.link(source, target)
    except OSError:
        shutil.copyfile(source, target)
    return target


def main(arguments: Sequence[str]) -> int:
    """Run one of the two; return 0, or 1 after a message that says what to do."""
    try:
        if arguments[:1] == ["site"]:
            copy_to(Path(arguments[1]))
        else:
            make()
    except pyodide.RuntimeUnavailable as error:
        print(f"ERROR: {error}", flush=True)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
