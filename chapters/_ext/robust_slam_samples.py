"""Sample pages of the grader on the site, where the course has made them.

The instructor's course writes them to build/shown/pages before it builds the book. Elsewhere
there are none, and what a page says of them is left out.
"""

from __future__ import annotations

import posixpath
import shutil
from pathlib import Path

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective, SphinxRole

SOURCE = "build/shown/pages"
FOLDER = "samples"
"""Where they are on the site."""
INDEX = "report/index.html"


class Samples(SphinxDirective):
    """Keeps its content where the sample pages are there."""

    has_content = True

    def run(self) -> list[nodes.Node]:
        """Return the content, or nothing."""
        pages = Path(self.env.srcdir, SOURCE)
        # A file that is missing is a change: the page is read anew until it is there.
        self.env.note_dependency(str(pages / INDEX))
        return self.parse_content_to_nodes() if (pages / INDEX).is_file() else []


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
