"""The page *Your own graph*: its form where the runtime is there, and the command where not.

``chapters/_templates/own_graph.html`` is the form, and ``chapters/python`` what it does. Only the
page with the directive ``your-graph`` asks for its style and its script.
"""

from __future__ import annotations

import posixpath
from pathlib import Path
from typing import Any

from docutils import nodes
from docutils.parsers.rst import Directive
from jinja2 import Environment, FileSystemLoader
from sphinx.application import Sphinx

TEMPLATES = Environment(
    loader=FileSystemLoader(Path(__file__).parents[1] / "_templates"), autoescape=True
)


class own_graph(nodes.General, nodes.Element):
    """The place of the form on its page."""


class OwnGraph(Directive):
    """Puts the form here."""

    def run(self) -> list[nodes.Node]:
        """Return the place, which is filled when the page is written."""
        return [own_graph()]


def fill(app: Sphinx, doctree: nodes.document, page: str) -> None:
    """Put the form into its place, or the command alone where there is no runtime."""
    for place in list(doctree.findall(own_graph)):
        folder = posixpath.relpath("python", posixpath.dirname(app.builder.get_target_uri(page)))
        template = TEMPLATES.get_template("own_graph.html")
        html = template.render(bytes=app.config.course_bytes, folder=folder)
        place.replace_self(nodes.raw("", html, format="html"))


def add_style(
    app: Sphinx, page: str, template: str, context: dict[str, Any], doctree: nodes.document | None
) -> None:
    """Let the page of the form ask for its style."""
    if app.config.course_bytes and "own-graph" in context.get("body", ""):
        folder = context["pathto"]("python", 1)
        context["metatags"] += f'\n<link rel="stylesheet" href="{folder}/own.css" />'


def setup(app: Sphinx) -> dict[str, Any]:
    """Connect the above to the build."""
    app.add_node(own_graph)
    app.add_directive("your-graph", OwnGraph)
    app.connect("doctree-resolved", fill)
    app.connect("html-page-context", add_style)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
