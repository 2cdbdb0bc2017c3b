"""The same figure for a narrow page: its panels stand one below the other."""

from copy import deepcopy
from itertools import pairwise
from math import ceil

from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.axis import XAxis
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec, SubplotSpec
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.legend import Legend
from matplotlib.text import Text

WIDTH = 3.85
"""Inches. On 350 pixels, what a phone leaves, a point is 1.25 pixels."""
SMALLEST = 9.0
"""Points: letters of 11 pixels on a phone."""
_LETTERS = 0.86
"""The size of letters, as a share of that in the wide figure."""
_APART = 6.0
"""Pixels between two numbers of an axis."""
_ROOM = 0.96
"""The share of the width that a legend may take."""
_LEGEND = 0.5
"""The height of a panel that has only a legend, as a share of the others'."""


def narrowed(figure: Figure) -> Figure:
    """Return a copy that is narrow; panels that stood side by side are stacked."""
    copy = deepcopy(figure)
    # pyplot would show it at the end of the cell.
    plt.close(copy)
    width, height = map(float, copy.get_size_inches())
    if width > WIDTH:
        copy.set_size_inches(WIDTH, height * _stack(copy))
    for text in copy.findobj(Text):
        text.set_fontsize(max(_LETTERS * float(text.get_fontsize()), SMALLEST))
    _fit_legends(copy)
    for ax in copy.axes:
        _thin_out(ax.xaxis)
    return copy


def _stack(figure: Figure) -> float:
    """Put panels of one grid below each other, and return by how much the figure gets taller."""
    panels = [ax for ax in figure.axes if ax.figure is figure and ax.get_subplotspec()]
    grids = {_spec(ax).get_gridspec() for ax in panels}
    grid = grids.pop() if len(grids) == 1 else None
    if grid is None or grid.ncols == 1:
        return 1.0
    _name_axes_that_shared(panels)
    panels.sort(key=lambda ax: _spec(ax).num1)
    heights = [1.0 if ax.has_data() else _LEGEND for ax in panels]
    below = GridSpec(len(panels), 1, figure=figure, height_ratios=heights)
    for place, ax in enumerate(panels):
        ax.set_subplotspec(below[place])
    engine = figure.get_layout_engine()
    if isinstance(engine, ConstrainedLayoutEngine):
        engine.set(hspace=0.06)
    return sum(heights) / grid.nrows


def _spec(ax: Axes) -> SubplotSpec:
    """Return a panel's place in its grid."""
    spec = ax.get_subplotspec()
    assert spec is not None  # panels have one
    return spec


def _name_axes_that_shared(panels: list[Axes]) -> None:
    """Repeat labels and numbers that a panel had in common with those beside or below it."""
    for ax in panels:
        row = [other for other in panels if _spec(other).rowspan == _spec(ax).rowspan]
        column = [other for other in panels if _spec(other).colspan == _spec(ax).colspan]
        if ax.axison and ax.has_data():
            ax.set_ylabel(ax.get_ylabel() or row[0].get_ylabel())
            ax.set_xlabel(ax.get_xlabel() or column[-1].get_xlabel())
        if ax.get_shared_y_axes().joined(ax, row[0]):
            ax.yaxis.set_tick_params(which="both", labelleft=True)
        if ax.get_shared_x_axes().joined(ax, column[-1]):
            ax.xaxis.set_tick_params(which="both", labelbottom=True)


def _fit_legends(figure: Figure) -> None:
    """Give a legend beside the panels fewer columns if it is too wide.

    The ground of one in a panel hides most of the lines below it.
    """
    for ax in figure.axes:
        legend = ax.get_legend()
        if legend is not None:
            legend.set_frame_on(True)
            legend.get_frame().set(facecolor="white", edgecolor="none", alpha=0.8)
    figure.draw_without_rendering()
    for legend in list(figure.legends):
        count, rows = len(legend.get_texts()), 1
        while rows < count and legend.get_window_extent().width > _ROOM * figure.bbox.width:
            rows += 1
            legend = _repeated(figure, legend, ceil(count / rows))


def _repeated(figure: Figure, legend: Legend, columns: int) -> Legend:
    """Put a legend of so many columns in the place of one above or below the panels."""
    is_above = legend.get_window_extent().y0 > 0.5 * figure.bbox.height
    names = [text.get_text() for text in legend.get_texts()]
    # In a copy of a figure its own remove() looks into the list of the first one.
    figure.legends.remove(legend)
    made = figure.legend(
        [handle for handle in legend.legend_handles if handle is not None],
        names,
        loc="outside upper center" if is_above else "outside lower center",
        ncols=columns,
        fontsize=SMALLEST,
    )
    figure.draw_without_rendering()
    return made


def _thin_out(axis: XAxis) -> None:
    """Leave out every second of the numbers that would touch each other."""
    labels = [label for label in axis.get_ticklabels() if label.get_text()]
    boxes = [label.get_window_extent() for label in labels]
    if any(left.x1 + _APART > right.x0 for left, right in pairwise(boxes) if left.x0 < right.x0):
        for label in labels[1::2]:
            label.set_visible(False)
