"""Pictures for the assignments: what a student's function does, beside the truth.

One module per assignment, one function per exercise. The truth is the library's own.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any, ParamSpec

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike
from robust_slam._arrays import Array
from robust_slam.graphs.pose_graph import PoseGraph
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


def panel(title: str, height: float = 3.5) -> tuple[Figure, Axes]:
    """Return a figure of one panel with a title, and the panel; its height is in inches."""
    figure = Figure(figsize=(5.6, height))
    ax = figure.subplots()
    ax.set_title(title)
    return figure, ax


def shaped(values: ArrayLike, shape: tuple[int, ...]) -> Array:
    """Return what a student's function gave as numbers of a shape.

    Raises:
        ValueError: they have another shape.
    """
    array = np.asarray(values, dtype=np.float64)
    if array.shape != shape:
        raise ValueError(f"the shape is {array.shape}; give {shape}")
    return array


def as_dict(graph: PoseGraph) -> dict[str, Any]:
    """Return the graph as assignments have it, its arrays copied."""
    names = ("edges", "measurement", "information", "is_odometry")
    return {"n": graph.n} | {name: np.array(getattr(graph, name)) for name in names}


def names_truth(ax: Axes) -> bool:
    """Tell whether the truth is named in a panel."""
    return "the truth" in ax.get_legend_handles_labels()[1]


def draw_beside(
    ax: Axes, x: ArrayLike, truth: ArrayLike, yours: ArrayLike, label: str = "yours"
) -> Axes:
    """Draw a curve over the broad true one, which is named once; the arguments are (n,).

    Raises:
        ValueError: matplotlib cannot draw them: their shapes differ.
    """
    name = "_" if names_truth(ax) else "the truth"
    ax.plot(x, truth, "-", color=PALETTE["muted"], linewidth=6, alpha=0.4, label=name)
    drawn: Array = np.asarray(yours, dtype=np.float64)
    ax.plot(x, drawn, color=PALETTE["estimate"], linestyle="--", label=label)
    return ax
