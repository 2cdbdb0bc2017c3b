"""Folded code stands below what it makes, as it is read, and its bar says what it holds."""

from __future__ import annotations

import itertools
import re
from typing import Any

from docutils import nodes
from myst_nb.sphinx_ import HideCodeCellNode
from sphinx.application import Sphinx

PICTURE = 'class="rs-picture"'
NAMES = (
    (r"(?m)^(?:from|import) ", "Code: imports"),
    (r"(?m)^\s*assert\b", "Code of the check"),
    ("", "Code for what follows"),
)
"""Of code that shows nothing: what is in it, and what its bar says."""


def finish(app: Sphinx, doctree: nodes.document, page: str) -> None:
    """Put the folded code of each cell below its outputs, and name its bar; merge neighbours."""
    figures = app.env.toc_fignumbers.get(page, {}).get("figure", {})
    for folded in list(doctree.findall(HideCodeCellNode)):
        cell = folded.parent
        if cell is not None and cell.get("hide_mode") == "input":
            outputs = [part for part in cell.children if part is not folded]
            folded["prompt_show"] = name(folded.astext(), outputs, figures)
            folded["prompt_hide"] = folded["prompt_show"]
            cell.children = [*outputs, folded]
    for cell in list(doctree.findall(shows_nothing)):
        merge(cell)


def shows_nothing(node: nodes.Node) -> bool:
    """Return whether a node is a cell with folded code and without outputs."""
    return (
        isinstance(node, nodes.container)
        and node.get("hide_mode") == "input"
        and [type(part) for part in node.children] == [HideCodeCellNode]
    )


def merge(cell: nodes.container) -> None:
    """Put a cell that shows nothing, and those right behind it, behind one bar."""
    parent = cell.parent
    start = parent.index(cell)
    others = list(itertools.takewhile(shows_nothing, parent.children[start + 1 :]))
    if not others:
        return
    bar = cell.children[0]
    for each in (cell, *others):
        code = list(each.children[0].children)
        parent.remove(each)
        each.clear()
        each += code
    bar.clear()
    bar += [cell, *others]
    bar["prompt_show"] = bar["prompt_hide"] = "Code: imports and data"
    parent.insert(start, nodes.container("", bar, classes=["cell"]))


def name(code: str, outputs: list[nodes.Node], figures: dict[str, tuple[int, ...]]) -> str:
    """Return what a bar says: the number of the figure that its code draws, or what it holds."""
    shown = [part for output in outputs for part in output.findall()]
    numbers = [
        ".".join(map(str, figures[key]))
        for figure in shown
        if isinstance(figure, nodes.figure)
        for key in figure["ids"]
        if key in figures
    ]
    if numbers:
        return f"Code for Fig. {' and '.join(numbers)}"
    if any(isinstance(part, nodes.raw) and PICTURE in part.astext() for part in shown):
        return "Code for this picture"
    if any(isinstance(part, nodes.table) for part in shown):
        return "Code for this table"
    if outputs:
        return "Code for this result"
    return next(said for found, said in NAMES if re.search(found, code))


def setup(app: Sphinx) -> dict[str, Any]:
    """Connect the above to the build."""
    app.connect("doctree-resolved", finish)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
