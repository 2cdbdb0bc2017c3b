"""The search finds sections and shows their text; a query loads the parts of the index it needs.

Pagefind makes the index of the pages as they are read: formulas are no longer TeX, and what stands
around the text is left out.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import tempfile
from html import escape
from pathlib import Path
from typing import Any
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.errors import ExtensionError

FOLDER = "pagefind"
SCRIPT = "search.js"
TEXT = "article"
NO_TEXT = ".headerlink, .prev-next-area, .rs-cited, .cell, .rs-forget, script, style, svg, button"
SECTION = re.compile(
    r'<section (?P<id>id="[^"]+")[^>]*>\s*(?:<span id="[^"]*"></span>)*<(?P<level>h\d)>'
)
"""Pagefind takes the addresses of sections from the headings, Sphinx writes them before these."""
FORMULA = re.compile(r"<math\b.*?</math>", re.DOTALL)


def add_script(
    app: Sphinx, page: str, template: str, context: dict[str, Any], doctree: nodes.document | None
) -> None:
    """Load the script on the page of results."""
    if page == "search":
        app.add_js_file(SCRIPT, loading_method="defer")


def index(app: Sphinx, exception: Exception | None) -> None:
    """Make the index.

    Raises
    ------
    ExtensionError
        Pagefind failed; with what it printed.
    """
    if exception or app.builder.format != "html":
        return
    site = Path(app.outdir)
    shutil.rmtree(site / FOLDER, ignore_errors=True)  # its files are named by what is in them
    with tempfile.TemporaryDirectory() as temporary:
        for name in app.env.found_docs:
            source = Path(app.builder.get_outfilename(name))
            target = Path(temporary) / source.relative_to(site)
            target.parent.mkdir(parents=True, exist_ok=True)
            page = source.read_text(encoding="utf-8")
            target.write_text(for_the_index(page), encoding="utf-8")
        command = [sys.executable, "-m", "pagefind", "--site", temporary]
        command += ["--output-path", str(site / FOLDER)]
        command += ["--root-selector", TEXT, "--exclude-selectors", NO_TEXT]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise ExtensionError(f"Pagefind made no index:\n{done.stdout}{done.stderr}")
    for pattern in ("*-ui.*", "*-highlight.js"):  # for which the site has its own
        for path in (site / FOLDER).glob(pattern):
            path.unlink()


def for_the_index(page: str) -> str:
    """Return a page whose headings have their sections' addresses and whose formulas are text."""
    page = SECTION.sub(r"<section><\g<level> \g<id>>", page)
    return FORMULA.sub(lambda match: escape(in_a_line(ElementTree.fromstring(match[0]))), page)


def in_a_line(formula: Element) -> str:
    """Return a formula in MathML as text: a half is 1/2, and not 12."""
    parts = [formula.text or "", *map(in_a_line, formula)]
    joint = {"mfrac": "/", "msup": "^"}.get(formula.tag.rpartition("}")[2], "")
    return joint.join(part for part in parts if part.strip())


def setup(app: Sphinx) -> dict[str, bool]:
    """Connect the above to the build, when the pages are as they stay."""
    app.connect("html-page-context", add_script)
    app.connect("build-finished", index, priority=950)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
