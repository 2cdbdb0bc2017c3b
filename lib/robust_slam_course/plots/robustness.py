"""Draw in what share of the runs methods succeed: a table of shaded cells with their numbers.

The more runs the less the ground shows through one hue: this can be read without seeing colours,
on paper, and on a dark page.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap, to_rgba
from numpy.typing import ArrayLike
from robust_slam._arrays import Array
from robust_slam.palette import PALETTE

_HUE = PALETTE["estimate"]
_MOST = 0.5
"""The opacity of a share of 1: the digits stay legible on it, on a dark page too."""
_SHADES = LinearSegmentedColormap.from_list("shares", [to_rgba(_HUE, 0.0), to_rgba(_HUE, _MOST)])


def draw_shares(
    ax: Axes, columns: Sequence[str], shares: Mapping[str, ArrayLike], size: float = 10.0
) -> Axes:
    """Draw a row of cells for each name in ``shares``, each cell with its share in percent.

    ``shares`` are ``(columns,)``, from 0 to 1; a cell of NaN, where nothing was run, is empty.
    ``size`` is that of the digits, in points.

    Raises:
        ValueError: a row does not have one share for each column, or one is not from 0 to 1.
    """
    table = np.array([_checked(name, row, len(columns)) for name, row in shares.items()])
    # Each cell is a shape of its own, so the figure stays sharp at any size.
    ax.pcolormesh(np.ma.masked_invalid(table), cmap=_SHADES, vmin=0.0, vmax=1.0, edgecolor="white")
    for (row, column), share in np.ndenumerate(table):
        if np.isfinite(share):
            place = column + 0.5, row + 0.5
            ax.text(*place, f"{100 * share:.0f}", size=size, ha="center", va="center")
    ax.set_xticks(np.arange(len(columns)) + 0.5, list(columns))
    ax.set_yticks(np.arange(len(table)) + 0.5, list(shares))
    ax.set(xlim=(0, len(columns)), ylim=(len(table), 0))
    ax.tick_params(length=0)
    ax.spines[:].set_visible(False)
    ax.grid(False)
    return ax


def _checked(name: str, value: ArrayLike, columns: int) -> Array:
    row = np.asarray(value, dtype=np.float64)
    if row.shape != (columns,):
        raise ValueError(f"shares: those of {name} have shape {row.shape}; give {(columns,)}")
    if np.any((row < 0.0) | (row > 1.0)):
        raise ValueError(f"shares: one of {name} is not from 0 to 1")
    return row
