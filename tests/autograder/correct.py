"""Correct submissions of any assignment, each unusual in one way and each right."""

from __future__ import annotations

import json
from collections.abc import Callable
from copy import deepcopy
from pathlib import Path

from tests.autograder.hostile.cells import from_file, own_cell
from tests.autograder.hostile.entry import Entry, Place, hand_in, put
from tests.autograder.hostile.target import Notebook, Target, grade_id_of

Change = Callable[[Notebook, Target], object]


def plain(target: Target, place: Place) -> None:
    """The right answers in the release, as JupyterLab would save them."""
    hand_in(target.solved(), target, place)


def _changed(name: str, kind: str, change: Change) -> Entry:
    def write(target: Target, place: Place) -> None:
        notebook = target.solved()
        change(notebook, target)
        hand_in(notebook, target, place)

    return Entry(name, f"correct: {kind}", "full", write)


def _bytes(name: str, kind: str, data: Callable[[str], bytes]) -> Entry:
    def write(target: Target, place: Place) -> None:
        put(data(json.dumps(target.solved(), indent=1, ensure_ascii=False)), target, place)

    return Entry(name, f"correct: {kind}", "full", write)


def _another_name(target: Target, place: Place) -> None:
    plain(target, place)
    (place.folder / target.file).rename(place.folder / "Homework (1).ipynb")


def _is(what: str) -> Callable[[dict[str, object]], bool]:
    def matches(cell: dict[str, object]) -> bool:
        metadata = cell["metadata"]
        assert isinstance(metadata, dict)
        return bool(metadata.get("nbgrader", {}).get(what))

    return matches


def _without(what: str) -> Change:
    def change(notebook: Notebook, target: Target) -> None:
        is_such = _is(what)
        notebook["cells"] = [cell for cell in notebook["cells"] if not is_such(cell)]

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


def _drop_metadata(notebook: Notebook, target: Target) -> None:
    for cell in notebook["cells"]:
        cell["metadata"] = {}


def _lines(notebook: Notebook, target: Target) -> None:
    for cell in notebook["cells"]:
        cell["source"] = "".join(cell["source"]).splitlines(keepends=True)


def _windows_cells(notebook: Notebook, target: Target) -> None:
    for cell in notebook["cells"]:
        cell["source"] = "".join(cell["source"]).replace("\n", "\r\n")


def _answers_last(notebook: Notebook, target: Target) -> None:
    notebook["cells"].sort(key=lambda cell: grade_id_of(cell) in target.answers)


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
    _changed("no-metadata", "a copied cell", _drop_metadata),
    _changed("answers-last", "a copied cell", _answers_last),
    _changed("lists-of-lines", "crlf", _lines),
    _changed("windows-lines-in-cells", "crlf", _windows_cells),
    _changed("long-outputs", "prints", _long_outputs),
    _bytes("windows-lines", "crlf", lambda text: text.replace("\n", "\r\n").encode()),
    _bytes("byte-order-mark", "bom", lambda text: text.encode("utf-8-sig")),
    Entry("another-name", "correct: a copied cell", "full", _another_name),
]
CORRECT = [*from_file(Path(__file__).with_name("correct_cells.txt")), *NOTEBOOKS]
