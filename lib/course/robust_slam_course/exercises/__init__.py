"""Pictures for the assignments: what a student's function does, next to the truth.

One module per assignment, one function per exercise. Each takes a student's functions, of the
same names, and draws what they give dashed or as markers over the truth, which is broad and grey
and the library's own. Residuals u are whitened, without unit; x and z share one unit.
"""

import functools
from collections.abc import Callable
from typing import Any, Concatenate, ParamSpec

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike, NDArray
from robust_slam._arrays import Array, Mask
from robust_slam.graphs import generate, outliers
from robust_slam.graphs.pose_graph import ROWS, PoseGraph
from robust_slam.palette import PALETTE

from robust_slam_course.style import figure_style, show_figures

NOT_YET = "A picture appears here once your function returns something that can be drawn."
READINGS = np.array([0.1, -0.2, 0.15, -0.1, 5.0])
"""The lesson's readings, the last one an outlier."""

P = ParamSpec("P")
Settings = dict[str, Any]
"""Keyword arguments for matplotlib."""
Panels = NDArray[Any]
"""Axes in rows and columns."""


def picture(
    title: str = "",
    xlabel: str = "",
    ylabel: str = "",
    *,
    height: float = 3.5,
    width: float = 5.6,
    **grid: Any,  # noqa: ANN401
) -> Callable[[Callable[Concatenate[Any, P], None]], Callable[P, Figure | None]]:
    """Make a figure of what draws on panels, once the student's functions can be drawn.

    A student's unfinished function may raise any error or return any value. The checks below
    explain what is wrong, so the picture shows a sentence and no traceback.

    Args:
        title: that of the panel or, of several panels, that of the figure; so are the labels.
        xlabel: the label along the bottom.
        ylabel: the label at the left.
        height, width: of the figure, in inches.
        **grid: the arguments of ``Figure.subplots``, which gives the panels.
    """

    def decorate(draw: Callable[Concatenate[Any, P], None]) -> Callable[P, Figure | None]:
        @functools.wraps(draw)
        def drawn(*args: P.args, **kwargs: P.kwargs) -> Figure | None:
            try:
                with figure_style():
                    figure = Figure(figsize=(width, height))
                    panels = figure.subplots(**grid)
                    if isinstance(panels, Axes):
                        panels.set(title=title, xlabel=xlabel, ylabel=ylabel)
                    else:
                        _name_all(figure, title, xlabel, ylabel)
                    draw(panels, *args, **kwargs)
            except Exception:
                print(NOT_YET)
                return None
            show_figures()
            return figure

        return drawn

    return decorate


def _name_all(figure: Figure, title: str, xlabel: str, ylabel: str) -> None:
    """Write what is common to all panels beside them; empty words would take room."""
    for write, words in (
        (figure.suptitle, title),
        (figure.supxlabel, xlabel),
        (figure.supylabel, ylabel),
    ):
        if words:
            write(words, fontsize=11)


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
    return {"n": graph.n} | {name: np.array(getattr(graph, name)) for name in ROWS}


def town(count: int) -> tuple[PoseGraph, Mask, Array]:
    """Return a walk through a town, the mask of its ``count`` outliers, and the true poses."""
    rng = np.random.default_rng(2)
    graph, truth = generate.manhattan(60, rng, side=6, closures=20)
    graph, is_outlier = outliers.add_random_closures(graph, count, rng, poses=truth)
    return graph, is_outlier, truth


def draw_truth(
    ax: Axes,
    x: ArrayLike,
    y: ArrayLike,
    label: str = "the truth",
    **look: Any,  # noqa: ANN401
) -> None:
    """Draw a broad grey curve through points (n,); a panel's legend names all of them once."""
    name = "_" if label in ax.get_legend_handles_labels()[1] else label
    broad: Settings = {"color": PALETTE["muted"], "linestyle": "-", "linewidth": 6, "alpha": 0.4}
    ax.plot(x, y, **(broad | look), label=name)


def draw_beside(
    ax: Axes,
    x: ArrayLike,
    truth: ArrayLike,
    yours: ArrayLike,
    **look: Any,  # noqa: ANN401
) -> None:
    """Draw a student's curve over the true one, in a look of its own; the arguments are (n,).

    Raises:
        ValueError: matplotlib cannot draw them: their shapes differ.
    """
    draw_truth(ax, x, truth)
    drawn: Array = np.asarray(yours, dtype=np.float64)
    dashed: Settings = {"color": PALETTE["estimate"], "linestyle": "--", "label": "yours"}
    ax.plot(x, drawn, **(dashed | look))
