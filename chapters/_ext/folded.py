"""Folded code stands below what it makes, as it is read, and its bar says what it holds."""

from __future__ import annotations

import itertools
import re
from typing import Any

from docutils import nodes
from myst_nb.sphinx_ import HideCodeCellNode
from sphinx.application import Sphinx

from .printed import is_stream, set_tables

PICTURE = 'class="rs-picture"'
NUMBERS = "Code and its numbers"
NAMES = (
    (r"(?m)^(?:from|import) ", "Code: imports"),
    (r"(?m)^\s*assert\b", "Code of the check"),
    ("", "Code for what follows"),
)
"""Of code that shows nothing: what is in it, and what its bar says."""


def finish(app: Sphinx, doctree: nodes.document, page: str) -> None:
    """Put the folded code of each cell below its outputs, and name its bar; merge neighbours.

    What such a cell printed stands with its code, because the text has these numbers already; only
    a table is on the page.
    """
    figures = app.env.toc_fignumbers.get(page, {}).get("figure", {})
    cells = list(doctree.findall(lambda node: "cell_metadata" in getattr(node, "attributes", ())))
    shown = {id(cell) for cell in cells if set_tables(cell)}
    for folded in list(doctree.findall(HideCodeCellNode)):
        cell = folded.parent
        if cell is not None and cell.get("hide_mode") == "input":
            outputs = [part for part in cell.children if part is not folded]
            folded["prompt_show"] = name(folded.astext(), outputs, figures, id(cell) in shown)
            folded["prompt_hide"] = folded["prompt_show"]
            if folded["prompt_show"] == NUMBERS:
                folded += outputs
                outputs = []
            cell.children = [*outputs, folded]
    for cell in list(doctree.findall(shows_nothing)):
        if shows_nothing(cell) and not join(cell):
            merge(cell)


def shows_nothing(node: nodes.Node) -> bool:
    """Return whether a node is a cell with folded code and without outputs."""
    return (
        isinstance(node, nodes.container)
        and node.get("hide_mode") == "input"
        and [type(part) for part in node.children] == [HideCodeCellNode]
    )


def join(cell: nodes.container) -> bool:
    """Put a cell's numbers behind the bar right above it, if it has some and there is one."""
    (folded,) = cell.children
    at = cell.parent.index(cell)
    above = cell.parent[at - 1] if at else None
    if folded["prompt_show"] != NUMBERS or not isinstance(above, nodes.container):
        return False
    bar = above.children[-1] if above.children else None
    if not isinstance(bar, HideCodeCellNode) or above.get("hide_mode") != "input":
        return False
    cell.parent.remove(cell)
    cell.children = []
    cell += folded.children
    bar += cell
    return True


def merge(cell: nodes.container) -> None:
    """Put a cell that shows nothing, and those right behind it, behind one bar."""
    parent = cell.parent
    start = parent.index(cell)
    others = list(itertools.takewhile(shows_nothing, parent.children[start + 1 :]))
    if not others:
        return
    bar = cell.children[0]
    said = {each.children[0]["prompt_show"] for each in (cell, *others)}
    for each in (cell, *others):
        code = list(each.children[0].children)
        parent.remove(each)
        each.clear()
        each += code
    bar.clear()
    bar += [cell, *others]
    bar["prompt_show"] = bar["prompt_hide"] = (
        NUMBERS if NUMBERS in said else "Code: imports and data"
    )
    parent.insert(start, nodes.container("", bar, classes=["cell", "rs-merged"]))


def name(
    code: str,
    outputs: list[nodes.Node],
    figures: dict[str, tuple[int, ...]],
    has_tables: bool = False,
) -> str:
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
    if has_tables or any(isinstance(part, nodes.table) for part in shown):
        return "Code for this table"
    if outputs and all(is_stream(part) for output in outputs for part in output.children):
        return NUMBERS
    if outputs:
        return "Code for this result"
    return next(said for found, said in NAMES if re.search(found, code))


def setup(app: Sphinx) -> dict[str, Any]:
    """Connect the above to the build."""
    app.connect("doctree-resolved", finish)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
