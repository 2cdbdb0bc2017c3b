"""What the site offers beside its pages: assignments, in the browser too, and sample pages.

- Where a page names an assignment's zip and the course has it, the name is a link to it. The
  public course has the zips in assignments/, the instructor's in build/release/ once they are
  released. Elsewhere the name is plain text.
- Behind the name a link opens the assignment in the JupyterLab that ``make runtime`` makes.
- The instructor's course writes sample pages of the grader to build/shown/pages before it builds
  the book. Elsewhere there are none, and what a page says of them is left out.
"""

import posixpath
import shutil
from pathlib import Path
from typing import Any

from bs4 import BeautifulSoup
from docutils import nodes
from sphinx.application import Sphinx
from sphinx.config import Config
from sphinx.util.docutils import SphinxDirective
from sphinx.util.fileutil import copy_asset

from . import TEMPLATES

ZIPS, RELEASED = "assignments", "build/release"
"""Where the zips are on the site and in the public course, and where they are made."""
LAB, LAB_SOURCE = "lab", "build/runtime/lab"
"""Where JupyterLab is on the site, and where it is made."""
LOCK = "pyodide-lock.json"
"""The file of JupyterLab that is written last."""
SAMPLES, SAMPLES_SOURCE = "samples", "build/shown/pages"
"""Where the sample pages are on the site, and where they are made."""
REPORT = "report/index.html"


def zips(app: Sphinx) -> dict[str, Path]:
    """Return the course's zips by their names."""
    folders = [Path(app.srcdir, name) for name in (RELEASED, ZIPS)]
    return {path.name: path for folder in folders for path in sorted(folder.glob("*.zip"))}


def look_for_the_lab(app: Sphinx, config: Config) -> None:
    """Note which assignments are there: with others all pages are written again."""
    lab = Path(app.srcdir, LAB_SOURCE)
    paths = sorted(lab.glob("files/*.ipynb")) if (lab / LOCK).is_file() else []
    config.course_assignments = [path.stem for path in paths]


def link(app: Sphinx, doctree: nodes.document, page: str) -> None:
    """Make links of each `NAME.zip` in code type: to the zip, and to the assignment in the lab."""
    folder = posixpath.dirname(app.builder.get_target_uri(page))

    def leading_to(path: str, *shown: nodes.Node) -> nodes.reference:
        address = posixpath.relpath(path, folder)
        return nodes.reference("", "", *shown, refuri=address, internal=True)

    known = zips(app)
    for literal in list(doctree.findall(nodes.literal)):
        name, kind = posixpath.splitext(literal.astext())
        made: list[nodes.Node] = [literal.deepcopy()]
        if literal.astext() in known:
            made = [leading_to(f"{ZIPS}/{name}.zip", *made)]
        if kind == ".zip" and name in app.config.course_assignments:
            opened = f"{LAB}/lab/index.html?path={name}.ipynb"
            words = leading_to(opened, nodes.Text("open in the browser"))
            around = (nodes.Text(" ("), words, nodes.Text(")"))
            made.append(nodes.inline("", "", *around, classes=["rs-screen"]))
        literal.replace_self(made)


def put_in_place(source: Path, target: Path) -> None:
    """Put a folder at a place of the site, instead of what was there."""
    shutil.rmtree(target, ignore_errors=True)
    shutil.copytree(source, target)


class Samples(SphinxDirective):
    """Keeps its content where the sample pages are there."""

    has_content = True

    def run(self) -> list[nodes.Node]:
        """Return the content, below the report's heat map, or nothing."""
        report = Path(self.env.srcdir, SAMPLES_SOURCE, REPORT)
        # A file that is missing is a change: the page is read anew until it is there.
        self.env.note_dependency(str(report))
        if not report.is_file():
            return []
        picture = thumbnail(report.read_text(encoding="utf-8"))
        return [nodes.raw("", picture, format="html"), *self.parse_content_to_nodes()]


def thumbnail(report: str) -> str:
    """Draw the heat map of a report's index small, a square for each student and exercise."""
    rows = BeautifulSoup(report, "html.parser").select("table.heat tbody tr")
    cells = [[cell["class"] for cell in row.select("td[class]")] for row in rows]
    return TEMPLATES.get_template("heat.svg").render(rows=cells)


def copy(app: Sphinx, exception: Exception | None) -> None:
    """Put zips, JupyterLab and sample pages beside the pages; what has gone goes there too."""
    if exception is not None:
        return
    for path in zips(app).values():
        copy_asset(path, Path(app.outdir, ZIPS))
    offered = {
        LAB: (LAB_SOURCE, bool(app.config.course_assignments)),
        SAMPLES: (SAMPLES_SOURCE, Path(app.srcdir, SAMPLES_SOURCE, REPORT).is_file()),
    }
    for target, (source, is_there) in offered.items():
        if is_there:
            put_in_place(Path(app.srcdir, source), Path(app.outdir, target))
        else:
            shutil.rmtree(Path(app.outdir, target), ignore_errors=True)


def setup(app: Sphinx) -> dict[str, Any]:
    """Connect the above to the build."""
    app.add_config_value("course_assignments", [], "html")
    app.add_directive("samples", Samples)
    app.connect("config-inited", look_for_the_lab)
    app.connect("doctree-resolved", link)
    app.connect("build-finished", copy)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
