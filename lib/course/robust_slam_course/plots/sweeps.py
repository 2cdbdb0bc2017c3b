"""Draw what becomes of errors, of shares of good maps and of costs as something grows."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap, to_rgba
from numpy.typing import ArrayLike
from robust_slam._arrays import Array, finite
from robust_slam.palette import PALETTE

from robust_slam_course.style import LOOKS

_APART = 0.1  # of a place's width: methods with equal numbers still stand side by side
_HUE = PALETTE["estimate"]
_MOST = 0.5
"""The opacity of a share of 1: the digits stay legible on it, on a dark page too."""
_SHADES = LinearSegmentedColormap.from_list("shares", [to_rgba(_HUE, 0.0), to_rgba(_HUE, _MOST)])


def draw_sweep(ax: Axes, levels: Sequence[str], scores: Mapping[str, ArrayLike]) -> Axes:
    """Draw each method's scores (runs, levels): a line of medians, a bar from best to worst.

    Every level has a place of its own, named by its text in `levels`. Scores are above 0, on a
    logarithmic axis. A method keeps its colour, line and marker by its position.

    Raises:
        ValueError: a method's scores do not have one column for each level, or there are more
            methods than looks.
    """
    if len(scores) > len(LOOKS):
        raise ValueError(f"scores: {len(scores)} methods; at most {len(LOOKS)} can be told apart")
    place = np.arange(len(levels))
    for number, (name, value) in enumerate(scores.items()):
        runs = finite(name, value, (-1, len(levels)))
        look, middle = LOOKS[number], np.median(runs, axis=0)
        at = place + _APART * (number - 0.5 * (len(scores) - 1))
        ax.vlines(at, runs.min(axis=0), runs.max(axis=0), color=look.color, linewidth=1.4)
        ax.plot(at, middle, **look.line, marker=look.marker, linewidth=1.4, label=name)
    ax.set_xticks(place, levels)
    ax.set_yscale("log")
    return ax


def draw_shares(ax: Axes, columns: Sequence[str], shares: Mapping[str, ArrayLike]) -> Axes:
    """Draw a row of cells for each name in ``shares``, each cell with its share in percent.

    The more runs succeed, the less the ground shows through one hue: this can be read without
    seeing colours, on paper, and on a dark page.

    ``shares`` are ``(columns,)``, from 0 to 1; a cell of NaN, where nothing was run, is empty.

    Raises:
        ValueError: a row does not have one share for each column, or one is not from 0 to 1.
    """
    table = np.array([_checked(name, row, len(columns)) for name, row in shares.items()])
    # Each cell is a shape of its own, so the figure stays sharp at any size.
    ax.pcolormesh(np.ma.masked_invalid(table), cmap=_SHADES, vmin=0.0, vmax=1.0, edgecolor="white")
    for (row, column), share in np.ndenumerate(table):
        if np.isfinite(share):
            place = column + 0.5, row + 0.5
            ax.text(*place, f"{100 * share:.0f}", size=10, ha="center", va="center")
    ax.set_xticks(np.arange(len(columns)) + 0.5, list(columns))
    ax.set_yticks(np.arange(len(table)) + 0.5, list(shares))
    ax.set(xlim=(0, len(columns)), ylim=(len(table), 0))
    ax.tick_params(length=0)
    ax.spines[:].set_visible(False)
    ax.grid(False)
    return ax


def fitted_exponent(sizes: ArrayLike, costs: ArrayLike) -> float:
    """Return the b of the power law a·size^b that fits ``costs`` (k,) best, as logarithms.

    Raises:
        ValueError: there are fewer than two sizes, the lengths differ, or a number is not above 0.
    """
    return float(_power_law(sizes, costs)[0])


def draw_growth(ax: Axes, sizes: ArrayLike, costs: ArrayLike) -> Axes:
    """Draw costs (k,) over sizes (k,), both logarithmic, and the power law that fits best.

    The legend gives its exponent.

    Raises:
        ValueError: as ``fitted_exponent``.
    """
    exponent, factor = _power_law(sizes, costs)
    ends = np.array([np.min(sizes), np.max(sizes)], dtype=np.float64)
    law = np.exp(factor) * ends**exponent
    ax.plot(ends, law, color=PALETTE["muted"], linestyle="--", label=f"∝ $n^{{{exponent:.2f}}}$")
    ax.plot(sizes, costs, "o", color=PALETTE["estimate"], label="measured")
    ax.set(xscale="log", yscale="log", xlabel="poses n")
    return ax


def _checked(name: str, value: ArrayLike, columns: int) -> Array:
    row = np.asarray(value, dtype=np.float64)
    if row.shape != (columns,):
        raise ValueError(f"shares: those of {name} have shape {row.shape}; give {(columns,)}")
    if np.any((row < 0.0) | (row > 1.0)):
        raise ValueError(f"shares: one of {name} is not from 0 to 1")
    return row


def _power_law(sizes: ArrayLike, costs: ArrayLike) -> Array:
    """Return b and log a."""
    across = finite("sizes", sizes, (-1,))
    up = finite("costs", costs, across.shape)
    if across.size < 2:
        raise ValueError(f"sizes: there is {across.size}; a slope needs at least 2")
    if np.any(across <= 0.0) or np.any(up <= 0.0):
        raise ValueError("sizes and costs must be above 0: they are drawn as logarithms")
    return np.asarray(np.polyfit(np.log(across), np.log(up), 1))
