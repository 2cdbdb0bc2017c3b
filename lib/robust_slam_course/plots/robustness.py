"""Draw in what share of the runs methods succeed: a table of shaded cells with their numbers.

One hue from light to dark can be read without seeing colours, and on paper.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from numpy.typing import ArrayLike
from robust_slam._arrays import Array

_DARK = 0.71  # from this share on white digits have more contrast than black ones


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
    ax.pcolormesh(
        np.ma.masked_invalid(table), cmap=colormaps["Blues"], vmin=0.0, vmax=1.0, edgecolor="white"
    )
    for (row, column), share in np.ndenumerate(table):
        if np.isfinite(share):
            colour = "white" if share >= _DARK else "black"
            place = column + 0.5, row + 0.5
            ax.text(
                *place, f"{100 * share:.0f}", color=colour, size=size, ha="center", va="center"
            )
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
