"""What a cell shows, as it is read: printed tables are tables, and code stands below them.

A printed table is a line of heads above lines with as many cells, with two spaces or more between
them, and each of these lines holds a number. A line with one cell right above it is its caption;
otherwise the caption is ``caption`` in the cell's metadata. Folded code stands below what it
makes, and its bar says what it holds. It is in sight once the link to a chapter's code was
followed, and from the start where a cell has the tag ``to-change``: the text asks for a change.
"""

import itertools
import re
from dataclasses import dataclass
from typing import Any

from docutils import nodes
from myst_nb.sphinx_ import HideCodeCellNode
from sphinx.application import Sphinx

from . import TEMPLATES

GAP = re.compile(r" {2,}")
NUMBER = re.compile(r"[-+−]?\d\S*|-|nan|[-+−]?\d\S* \S{1,2}")
"""A cell that stands on the right of its column, with its unit."""
ROWS = 2
"""How many lines below its heads a table has at least."""
PICTURE, TABLE = 'class="rs-picture"', 'class="table rs-printed"'
NUMBERS = "Code and its numbers"
NAMES = (
    (r"(?m)^(?:from|import) ", "Code: imports"),
    (r"(?m)^\s*assert\b", "Code of the check"),
    ("", "Code for what follows"),
)
"""Of code that shows nothing: what is in it, and what its bar says."""


@dataclass(frozen=True)
class Table:
    """A table that a cell printed: its caption, heads and rows, all of the same length."""

    caption: str
    heads: list[str]
    rows: list[list[str]]

    def html(self) -> str:
        """Return the table as the theme draws one, with its numbers on the right."""
        columns = zip(*self.rows, strict=True)
        right = [all(map(_is_number, filter(None, column))) for column in columns]
        return TEMPLATES.get_template("printed.html").render(table=self, right=right)


def parts(text: str, caption: str = "") -> list[str | Table]:
    """Split what was printed into tables and the lines between them."""
    lines = text.rstrip("\n").split("\n")
    found: list[str | Table] = []
    plain: list[str] = []
    at = 0
    while at < len(lines):
        table = _table(lines[at:])
        if table is None:
            plain.append(lines[at])
            at += 1
            continue
        if plain and len(_cells(plain[-1])) == 1:
            caption = plain.pop().strip().removesuffix(":")
        found += ["\n".join(plain)] if plain else []
        found.append(Table(caption, *table))
        plain, caption = [], ""
        at += 1 + len(table[1])
    return [*found, "\n".join(plain)] if plain else found


def _table(lines: list[str]) -> tuple[list[str], list[list[str]]] | None:
    """Return the heads and rows of the table that begins with the first of the lines."""
    heads, below = _cells(lines[0]), lines[1:]
    width = max((len(_cells(line)) for line in below[:ROWS]), default=0)
    if len(heads) < 2 or width - len(heads) not in {0, 1} or not all(map(_is_head, heads)):
        return None
    last = len(lines[0]) - len(heads[-1])
    # Only the last cell of a row can be empty, since its place alone shows that.
    rows = ([*_cells(line), ""] if len(line) <= last else _cells(line) for line in below)
    whole = itertools.takewhile(lambda row: len(row) == width and any(map(_is_number, row)), rows)
    found = list(whole)
    return ([""] * (width - len(heads)) + heads, found) if len(found) >= ROWS else None


def _cells(line: str) -> list[str]:
    return GAP.split(line.strip())


def _is_number(cell: str) -> bool:
    return NUMBER.fullmatch(cell) is not None


def _is_head(cell: str) -> bool:
    return not set(cell) & set("[]=") and (cell.endswith("%") or not _is_number(cell))


def is_stream(node: nodes.Node) -> bool:
    """Return whether a node is what a cell printed."""
    return isinstance(node, nodes.literal_block) and "stream" in node["classes"]


def set_tables(cell: nodes.container) -> None:
    """Draw the tables that a cell printed."""
    for stream in list(cell.findall(is_stream)):
        found = parts(stream.astext(), cell["cell_metadata"].get("caption", ""))
        if any(isinstance(part, Table) for part in found):
            # With replace_self a table would have the stream's classes, and its box.
            at = stream.parent.index(stream)
            stream.parent[at : at + 1] = [_drawn(part, stream) for part in found]


def _drawn(part: str | Table, stream: nodes.Element) -> nodes.Node:
    if isinstance(part, Table):
        return nodes.raw("", part.html(), format="html")
    plain = stream.deepcopy()
    plain.rawsource = part
    plain.children = [nodes.Text(part)]
    return plain


def finish(app: Sphinx, doctree: nodes.document, page: str) -> None:
    """Put the folded code of each cell below its outputs, and name its bar; merge neighbours.

    What such a cell printed stands with its code, because the text has these numbers already; only
    a table is on the page.
    """
    figures = app.env.toc_fignumbers.get(page, {}).get("figure", {})
    for cell in list(doctree.findall(nodes.container)):
        if "cell_metadata" in cell:
            set_tables(cell)
    for folded in list(doctree.findall(HideCodeCellNode)):
        cell = folded.parent
        if cell is not None and cell.get("hide_mode") == "input":
            outputs = [part for part in cell.children if part is not folded]
            folded["prompt_show"] = name(folded.astext(), outputs, figures)
            folded["prompt_hide"] = folded["prompt_show"]
            if folded["prompt_show"] == NUMBERS:
                folded += outputs
                outputs = []
            cell.children = [*outputs, folded]
    for cell in list(doctree.findall(shows_nothing)):
        if shows_nothing(cell) and not join(cell):
            merge(cell)


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
    html = "".join(part.astext() for part in shown if isinstance(part, nodes.raw))
    if PICTURE in html:
        return "Code for this picture"
    if TABLE in html or any(isinstance(part, nodes.table) for part in shown):
        return "Code for this table"
    if outputs and all(is_stream(part) for output in outputs for part in output.children):
        return NUMBERS
    if outputs:
        return "Code for this result"
    return next(said for found, said in NAMES if re.search(found, code))


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
    group = list(itertools.takewhile(shows_nothing, parent.children[start:]))
    if len(group) == 1:
        return
    bar = cell.children[0]
    said = {each.children[0]["prompt_show"] for each in group}
    for each in group:
        code = list(each.children[0].children)
        parent.remove(each)
        each.clear()
        each += code
    bar.clear()
    bar += group
    bar["prompt_show"] = bar["prompt_hide"] = (
        NUMBERS if NUMBERS in said else "Code: imports and data"
    )
    parent.insert(start, nodes.container("", bar, classes=["cell", "rs-merged"]))


def setup(app: Sphinx) -> dict[str, Any]:
    """Connect the above to the build."""
    app.connect("doctree-resolved", finish)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
