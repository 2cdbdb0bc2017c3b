"""Where a page names an assignment's zip and the course has it, the name is a link to it.

The public course has the zips in assignments/, the instructor's in build/release/ once they
are released. Elsewhere the name is plain text.
"""

from __future__ import annotations

import posixpath
from pathlib import Path

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.fileutil import copy_asset

FOLDER = "assignments"
"""Where the zips are on the site."""
SOURCES = (FOLDER, "build/release")


def zips(app: Sphinx) -> dict[str, Path]:
    """The course's zips by their names."""
    folders = [Path(app.srcdir) / name for name in reversed(SOURCES)]
    return {path.name: path for folder in folders for path in sorted(folder.glob("*.zip"))}


def link(app: Sphinx, doctree: nodes.document, page: str) -> None:
    """Make a link of each `NAME.zip` in code type that is there."""
    target = app.builder.get_target_uri(page)
    known = zips(app)
    for literal in list(doctree.findall(nodes.literal)):
        name = literal.astext()
        if name in known:
            address = posixpath.relpath(f"{FOLDER}/{name}", posixpath.dirname(target))
            made = nodes.reference("", "", literal.deepcopy(), refuri=address, internal=True)
            literal.replace_self(made)


def copy(app: Sphinx, exception: Exception | None) -> None:
    """Put the zips beside the pages."""
    if exception is None:
        for path in zips(app).values():
            copy_asset(path, Path(app.outdir) / FOLDER)


def setup(app: Sphinx) -> dict[str, bool]:
    """Connect the above to the build."""
    app.connect("doctree-resolved", link)
    app.connect("build-finished", copy)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
