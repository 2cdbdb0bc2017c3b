"""``python -m tools.runtime`` fills ``build/runtime``; with ``site FOLDER`` it copies it there."""

from __future__ import annotations

import os
import shutil
import sys
from collections.abc import Sequence
from pathlib import Path

from tools.runtime import editor, jupyterlite, pyodide, wheels

ROOT = Path(__file__).resolve().parents[2]
RUNTIME = ROOT / "build" / "runtime"
READY = ".ready"
"""Stands in the runtime's folder when all of it is there."""
PLACES = {"pyodide": "python/pyodide", "wheels": "python/wheels", "lab": "lab"}
"""Where the runtime's folders stand on the site."""
JUPYTERLITE = ROOT / "build" / "jupyterlite"
"""Where its packages are installed."""


def make(root: Path = ROOT, runtime: Path = RUNTIME, packages: Path = JUPYTERLITE) -> None:
    """Collect all files of the runtime, and make the site of the assignments.

    Raises:
        RuntimeUnavailable: a file cannot be had; ``READY`` is then missing.
    """
    (runtime / READY).unlink(missing_ok=True)
    pyodide.fetch(runtime / "pyodide", os.environ.get(pyodide.FOLDER))
    print("the editor")
    editor.build(runtime / "editor.js")
    print("the course's packages and those that they need")
    wheels.build(root, runtime / "wheels", runtime / "pyodide")
    print("JupyterLab for the assignments", flush=True)
    jupyterlite.build(root, runtime, packages)
    (runtime / READY).touch()


def copy_to(site: Path, runtime: Path = RUNTIME) -> None:
    """Put the runtime into a built site, as links where the file system has them."""
    for name, place in PLACES.items():
        target = site / place
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
