"""Figures as parts of a page: its font, its colours, and a drawing of its own for phones.

`page_html` draws a matplotlib figure twice, as it is and for a narrow page, both as SVG that
stands in the page itself. The page's style sheet says what the colours are, in the light, in the
dark and on paper, and which of the two drawings there is room for.
"""

import io
import os

from matplotlib.figure import Figure

from robust_slam_course.figures.narrow import narrowed
from robust_slam_course.figures.svg import inline

BUILD = "ROBUST_SLAM_BOOK"
"""The environment variable that a build of the book sets for its notebooks."""


def is_for_a_page() -> bool:
    """Tell whether this notebook is run for the pages of the book."""
    return bool(os.environ.get(BUILD))


def page_html(figure: Figure) -> str:
    """Return a figure as an element that needs a role and a label.

    It holds two drawings, `rs-wide` and `rs-narrow`; the style sheet shows one of them. The
    figure itself stays as it is.
    """
    narrow = narrowed(figure)
    drawings = inline(_svg(figure), "rs-wide") + inline(_svg(narrow), "rs-narrow")
    return f'<div class="rs-figure">{drawings}</div>'


def _svg(figure: Figure) -> str:
    """Return the figure as SVG without a ground, cut to what is drawn as in a notebook."""
    text = io.StringIO()
    figure.savefig(
        text, format="svg", bbox_inches="tight", pad_inches=0.03, transparent=True,
        metadata={"Date": None},
    )  # fmt: skip
    return text.getvalue()
