"""A live picture on a page that is no notebook: ``{picture}`` and its name."""

from __future__ import annotations

from docutils import nodes
from docutils.parsers.rst import Directive
from robust_slam_course import pictures
from robust_slam_course.style import figure_style
from sphinx.application import Sphinx


class Picture(Directive):
    """The live picture that is named."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        """Return the picture as HTML; builds for paper leave it out."""
        name = self.arguments[0]
        if name not in pictures.__all__:
            known = ", ".join(pictures.__all__)
            raise self.error(f"picture: there is none named {name!r}; give one of {known}")
        with figure_style():
            html = getattr(pictures, name)().static_html()
        return [nodes.raw("", html, format="html")]


def setup(app: Sphinx) -> dict[str, bool]:
    """Add the directive."""
    app.add_directive("picture", Picture)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
