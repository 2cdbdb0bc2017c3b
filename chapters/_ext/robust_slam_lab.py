"""Where a page names an assignment's zip, a link opens the assignment in the browser.

``make runtime`` makes the site with JupyterLab that the links lead to. Without it the pages have
no such links.
"""

from __future__ import annotations

import posixpath
import shutil
from pathlib import Path

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.config import Config

from robust_slam_links import replace_by_links

SOURCE = "build/runtime/lab"
TARGET = "lab"
"""Where it is on the site."""
LOCK = "pyodide-lock.json"
"""The file that is written last."""
TEXT = "open in the browser"


def look_for_the_lab(app: Sphinx, config: Config) -> None:
    """Note which assignments are there: with others all pages are written again."""
    lab = Path(app.srcdir) / SOURCE
    paths = sorted(lab.glob("files/*.ipynb")) if (lab / LOCK).is_file() else []
    config.robust_slam_assignments = [path.stem for path in paths]


def link(app: Sphinx, doctree: nodes.document, page: str) -> None:
    """Put a link behind each `NAME.zip` in code type whose assignment is there."""
    folder = posixpath.dirname(app.builder.get_target_uri(page))
    for literal in list(doctree.findall(nodes.literal)):
        name, kind = posixpath.splitext(literal.astext())
        if kind != ".zip" or name not in app.config.robust_slam_assignments:
            continue
        path = f"{TARGET}/lab/index.html?path={name}.ipynb"
        address = posixpath.relpath(path, folder)
        made = nodes.reference("", TEXT, refuri=address, internal=True)
        shown = literal.parent if isinstance(literal.parent, nodes.reference) else literal
        index = shown.parent.index(shown) + 1
        shown.parent.insert(index, [nodes.Text(" ("), made, nodes.Text(")")])


def copy(app: Sphinx, exception: Exception | None) -> None:
    """Put JupyterLab beside the pages, or take away what was there."""
    if exception is None:
        target = Path(app.outdir) / TARGET
        if app.config.robust_slam_assignments:
            replace_by_links(Path(app.srcdir) / SOURCE, target)
        else:
            shutil.rmtree(target, ignore_errors=True)


def setup(app: Sphinx) -> dict[str, bool]:
    """Connect the above to the build; after the zips, which become links themselves."""
    app.add_config_value("robust_slam_assignments", [], "html")
    app.connect("config-inited", look_for_the_lab)
    app.connect("doctree-resolved", link, priority=600)
    app.connect("build-finished", copy)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
