"""Correct submissions of any assignment, each unusual in one way and each right."""

import json
from collections.abc import Callable
from copy import deepcopy
from pathlib import Path
from typing import Any

from .hostile.cells import Change, changed, each, from_file, in_bytes, own_cell
from .hostile.entry import Entry, Place, hand_in
from .hostile.target import Notebook, Target


def plain(target: Target, place: Place) -> None:
    """The right answers in the release, as JupyterLab would save them."""
    hand_in(target.solved(), target, place)


def _changed(name: str, kind: str, change: Change) -> Entry:
    return changed(name, f"correct: {kind}", "full", change)


def _spelt(name: str, kind: str, data: Callable[[str], bytes]) -> Entry:
    def text(notebook: Notebook) -> str:
        return json.dumps(notebook, indent=1, ensure_ascii=False)

    return in_bytes(name, f"correct: {kind}", "full", lambda notebook: data(text(notebook)))


def _another_name(target: Target, place: Place) -> None:
    plain(target, place)
    (place.folder / target.file).rename(place.folder / "Homework (1).ipynb")


def _without(what: str) -> Change:
    def change(notebook: Notebook, target: Target) -> None:
        cells = notebook["cells"]
        notebook["cells"] = [c for c in cells if not c["metadata"].get("nbgrader", {}).get(what)]

    return change


def _copy_cell(notebook: Notebook, target: Target) -> None:
    """A first, wrong version above the right one: both carry the same grade id."""
    at = target.index(notebook)
    wrong = "".join(f"def {name}(*args):\n    return None\n" for name in target.functions)
    notebook["cells"].insert(at, deepcopy(notebook["cells"][at]) | {"source": wrong})


def _split_cell(notebook: Notebook, target: Target) -> None:
    """The answer stands in a cell of its own, the marked one holds the rest."""
    at = target.index(notebook)
    notebook["cells"][at]["source"] = "factor = 2\n"
    notebook["cells"].insert(at + 1, own_cell(target.reference))


def _lines(cell: dict[str, Any]) -> None:
    cell["source"] = "".join(cell["source"]).splitlines(keepends=True)


def _long_outputs(notebook: Notebook, target: Target) -> None:
    output = {"output_type": "stream", "name": "stderr", "text": "step\n" * 200_000}
    notebook["cells"][target.index(notebook)]["outputs"] = [output]


NOTEBOOKS = [
    Entry("plain", "correct: prints", "full", plain),
    _changed("deleted-tests", "deleted tests", _without("grade")),
    _changed("deleted-setup", "deleted tests", _without("locked")),
    _changed("no-kernelspec", "no kernelspec", lambda notebook, _: notebook.update(metadata={})),
    _changed("copied-cell", "a copied cell", _copy_cell),
    _changed("split-cell", "a copied cell", _split_cell),
    _changed("lists-of-lines", "crlf", each(_lines)),
    _changed("long-outputs", "prints", _long_outputs),
    _spelt("windows-lines", "crlf", lambda text: text.replace("\n", "\r\n").encode()),
    _spelt("byte-order-mark", "bom", lambda text: text.encode("utf-8-sig")),
    Entry("another-name", "correct: a copied cell", "full", _another_name),
]
CORRECT = [*from_file(Path(__file__).with_name("correct_cells.txt")), *NOTEBOOKS]
