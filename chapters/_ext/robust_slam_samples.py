"""Sample pages of the grader on the site, where the course has made them.

The instructor's course writes them to build/shown/pages before it builds the book. Elsewhere
there are none, and what a page says of them is left out.
"""

from __future__ import annotations

import posixpath
import re
import shutil
from pathlib import Path

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective, SphinxRole

SOURCE = "build/shown/pages"
FOLDER = "samples"
"""Where they are on the site."""
INDEX = "report/index.html"


COLOURS = {
    "all": "#0067a3",
    "most": "#7fb8dd",
    "some": "#f0b775",
    "zero": "#c55a11",
    "unmarked": "#9aa3ad",
}
"""Of the levels of points in the report's heat map; they show on light and on dark."""
SQUARE = 10


def thumbnail(report: str) -> str:
    """Draw the heat map of a report's index small, a square for each student and exercise."""
    rows = (
        report.partition('class="heat"')[2]
        .partition("<tbody>")[2]
        .partition("</tbody>")[0]
        .split("<tr>")[1:]
    )
    levels = [re.findall(r'<td class="(\w+)( first)?"', row) for row in rows]
    squares, width = [], 0
    for n, row in enumerate(levels):
        x = -SQUARE // 2  # an assignment begins half a square after the one before
        for level, first in row:
            x += SQUARE // 2 if first else 0
            place = f'x="{x}" y="{n * SQUARE}" width="{SQUARE - 1}" height="{SQUARE - 1}"'
            squares.append(f'<rect {place} fill="{COLOURS[level]}"/>')
            x += SQUARE
        width = max(width, x)
    words = (
        f"The heat map of the sample class, small: {len(levels)} rows of students, a square for "
        "each exercise, from blue for all points to orange for none."
    )
    size = f'viewBox="0 0 {width} {SQUARE * len(levels)}" width="{2 * width}"'
    return f'<p><svg role="img" aria-label="{words}" {size}>{"".join(squares)}</svg></p>'


class Samples(SphinxDirective):
    """Keeps its content where the sample pages are there."""

    has_content = True

    def run(self) -> list[nodes.Node]:
        """Return the content, or nothing."""
        pages = Path(self.env.srcdir, SOURCE)
        # A file that is missing is a change: the page is read anew until it is there.
        self.env.note_dependency(str(pages / INDEX))
        if not (pages / INDEX).is_file():
            return []
        picture = thumbnail((pages / INDEX).read_text(encoding="utf-8"))
        return [nodes.raw("", picture, format="html"), *self.parse_content_to_nodes()]


class Sample(SphinxRole):
    """Links its text to a sample page: ``the text <path below the folder>``."""

    def run(self) -> tuple[list[nodes.Node], list[nodes.system_message]]:
        """Return the link; a page that is not there is a warning of the build."""
        text, _, path = self.text.rstrip(">").partition(" <")
        if not Path(self.env.srcdir, SOURCE, path).is_file():
            return [], [self.inliner.reporter.warning(f"no sample page {path}", line=self.lineno)]
        target = self.env.app.builder.get_target_uri(self.env.docname)
        address = posixpath.relpath(f"{FOLDER}/{path}", posixpath.dirname(target))
        return [nodes.reference("", text, refuri=address, internal=True)], []


def copy(app: Sphinx, exception: Exception | None) -> None:
    """Put the pages on the site; those of a build before are gone."""
    if exception is None:
        shutil.rmtree(Path(app.outdir, FOLDER), ignore_errors=True)
        if Path(app.srcdir, SOURCE, INDEX).is_file():
            shutil.copytree(Path(app.srcdir, SOURCE), Path(app.outdir, FOLDER))


def setup(app: Sphinx) -> dict[str, bool]:
    """Connect the above to the build."""
    app.add_directive("samples", Samples)
    app.add_role("sample", Sample())
    app.connect("build-finished", copy)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
