"""Figures of notebooks stand in the page itself, in its font and its colours.

While the book is built the course's style draws figures as elements of a page
(``robust_slam_course.figures``); MyST-NB takes them for images. Here they take the images' place.
"""

from __future__ import annotations

import os
from html import escape
from pathlib import Path

from docutils import nodes
from robust_slam_course.figures import page
from robust_slam_course.style import site_colours
from sphinx.application import Sphinx
from sphinx.transforms import SphinxTransform

BEGINS = '<div class="rs-figure"'
COLOURS = "colours.css"


class InlineFigures(SphinxTransform):
    """Puts figures that are HTML into the page, before the images of a page are collected."""

    default_priority = 10

    def apply(self) -> None:
        """Replace the images of this page that are HTML."""
        for image in list(self.document.findall(nodes.image)):
            path = Path(self.env.srcdir, image["uri"].lstrip("/"))
            if path.suffix != ".svg" or not path.is_file():
                continue
            html = path.read_text(encoding="utf-8")
            if html.startswith(BEGINS):
                label = escape(image.get("alt", ""))
                html = html.replace(BEGINS, f'{BEGINS} role="img" aria-label="{label}"', 1)
                image.replace_self(nodes.raw("", html, format="html"))


def write_colours(app: Sphinx, exception: Exception | None) -> None:
    """Put the style sheet with the course's colours among the static files."""
    if exception is None and app.builder.format == "html":
        path = Path(app.outdir) / "_static" / COLOURS
        path.write_text(site_colours(), encoding="utf-8")


def setup(app: Sphinx) -> dict[str, bool]:
    """Add the above, and tell the notebooks that their figures are for pages."""
    os.environ[page.BUILD] = "1"
    app.add_transform(InlineFigures)
    app.add_css_file(COLOURS)
    # Before the style sheets are joined.
    app.connect("build-finished", write_colours, priority=400)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
