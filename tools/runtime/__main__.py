"""``python -m tools.runtime`` fills ``build/runtime``."""

import os
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from tools.runtime import editor, jupyterlite, pyodide, wheels

ROOT = Path(__file__).resolve().parents[2]
RUNTIME = ROOT / "build" / "runtime"
READY = ".ready"
"""Stands in the runtime's folder when all of it is there."""
JUPYTERLITE = ROOT / "build" / "jupyterlite"
"""Where its packages are installed."""


def make(root: Path = ROOT, runtime: Path = RUNTIME, packages: Path = JUPYTERLITE) -> None:
    """Collect all files of the runtime, and make the site of the assignments.

    The editor, which mostly waits for npm's registry, is made meanwhile.

    Raises:
        RuntimeUnavailable: a file cannot be had; ``READY`` is then missing.
    """
    (runtime / READY).unlink(missing_ok=True)
    with ThreadPoolExecutor(1) as beside:
        joined = beside.submit(editor.build, runtime / "editor.js")
        pyodide.fetch(runtime / "pyodide", os.environ.get(pyodide.FOLDER))
        print("the course's packages and those that they need")
        wheels.build(root, runtime / "wheels", runtime / "pyodide")
        print("JupyterLab for the assignments", flush=True)
        jupyterlite.build(root, runtime, packages)
        print("the editor", flush=True)
        joined.result()
    (runtime / READY).touch()


def main() -> int:
    """Make the runtime; return 0, or 1 after a message that says what to do."""
    try:
        make()
    except pyodide.RuntimeUnavailable as error:
        print(f"ERROR: {error}", flush=True)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
