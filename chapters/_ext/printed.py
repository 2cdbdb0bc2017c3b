"""What a cell printed is shown as it is read: a table as a table, and a check behind its bar.

A printed table is a line of heads above lines with as many cells, with two spaces or more between
them, and each of these lines holds a number. A line with one cell right above it is its caption;
otherwise the caption is ``caption`` in the cell's metadata.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from html import escape
from itertools import takewhile

from docutils import nodes

GAP = re.compile(r" {2,}")
NUMBER = re.compile(r"[-+−]?\d\S*|-|nan|[-+−]?\d\S* \S{1,2}")
"""A cell that stands on the right of its column, with its unit."""
ROWS = 2
"""How many lines below its heads a table has at least."""


@dataclass(frozen=True)
class Table:
    """A table that a cell printed: its caption, heads and rows, all of the same length."""

    caption: str
    heads: list[str]
    rows: list[list[str]]

    def html(self) -> str:
        """Return the table as the theme draws one, with its numbers on the right."""
        right = [
            all(map(_is_number, filter(None, column))) for column in zip(*self.rows, strict=True)
        ]
        heads = _row("th", self.heads, right)
        rows = "".join(_row("td", row, right) for row in self.rows)
        caption = f"<caption>{escape(self.caption)}</caption>" if self.caption else ""
        return (
            '<div class="pst-scrollable-table-container"><table class="table rs-printed">'
            f"{caption}<thead>{heads}</thead><tbody>{rows}</tbody></table></div>"
        )


def _row(tag: str, texts: list[str], right: list[bool]) -> str:
    sides = [' class="rs-number"' if side else "" for side in right]
    cells = (
        f"<{tag}{side}>{escape(text)}</{tag}>" for text, side in zip(texts, sides, strict=True)
    )
    return f"<tr>{''.join(cells)}</tr>"


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
    whole = list(takewhile(lambda row: len(row) == width and any(map(_is_number, row)), rows))
    return ([""] * (width - len(heads)) + heads, whole) if len(whole) >= ROWS else None


def _cells(line: str) -> list[str]:
    return GAP.split(line.strip())


def _is_number(cell: str) -> bool:
    return NUMBER.fullmatch(cell) is not None


def _is_head(cell: str) -> bool:
    return not set(cell) & set("[]=") and (cell.endswith("%") or not _is_number(cell))


def is_stream(node: nodes.Node) -> bool:
    """Return whether a node is what a cell printed."""
    return isinstance(node, nodes.literal_block) and "stream" in node["classes"]


def set_tables(cell: nodes.container) -> bool:
    """Draw the tables that a cell printed; return whether it has any."""
    caption = cell.get("cell_metadata", {}).get("caption", "")
    has_tables = False
    for stream in list(cell.findall(is_stream)):
        found = parts(stream.astext(), caption)
        if not all(isinstance(part, str) for part in found):
            # With replace_self a table would have the stream's classes, and its box.
            at = stream.parent.index(stream)
            stream.parent[at : at + 1] = [_drawn(part, stream) for part in found]
            has_tables = True
    return has_tables


def _drawn(part: str | Table, stream: nodes.Element) -> nodes.Node:
    if isinstance(part, Table):
        return nodes.raw("", part.html(), format="html")
    plain = stream.deepcopy()
    plain.rawsource = part
    plain.children = [nodes.Text(part)]
    return plain
