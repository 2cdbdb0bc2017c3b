"""Pictures for the assignments: what a student's function does, beside the truth.

One module per assignment, one function per exercise. The truth is the library's own.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import ParamSpec

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike
from robust_slam.palette import PALETTE

from robust_slam_course.style import figure_style, show_figures

NOT_YET = "A picture appears here once your function returns something that can be drawn."

P = ParamSpec("P")


def once_it_works(draw: Callable[P, Figure]) -> Callable[P, Figure | None]:
    """Draw in the course's style, once the functions can be drawn; until then say so.

    A student's unfinished function may raise any error or return any value. The checks below
    explain what is wrong, so the picture shows no traceback.
    """

    @functools.wraps(draw)
    def drawn(*args: P.args, **kwargs: P.kwargs) -> Figure | None:
        try:
            with figure_style():
                figure = draw(*args, **kwargs)
        except Exception:
            print(NOT_YET)
            return None
        show_figures()
        return figure

    return drawn


def draw_beside(
    ax: Axes, x: ArrayLike, truth: ArrayLike, yours: ArrayLike, label: str = "yours"
) -> Axes:
    """Draw a curve over the true one; the arguments are of shape (n,).

    Raises:
        ValueError: matplotlib cannot draw them: their shapes differ.
    """
    ax.plot(x, truth, "-", color=PALETTE["muted"], linewidth=6, alpha=0.4, label="the truth")
    ax.plot(x, yours, color=PALETTE["estimate"], linestyle="--", label=label)
    return ax
