"""Draw how a cost grows with the size of the problem, and the power law that fits it."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike
from robust_slam._arrays import Array, finite
from robust_slam.palette import PALETTE


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


def _power_law(sizes: ArrayLike, costs: ArrayLike) -> Array:
    """Return b and log a."""
    across = finite("sizes", sizes, (-1,))
    up = finite("costs", costs, across.shape)
    if across.size < 2:
        raise ValueError(f"sizes: there is {across.size}; a slope needs at least 2")
    if np.any(across <= 0.0) or np.any(up <= 0.0):
        raise ValueError("sizes and costs must be above 0: they are drawn as logarithms")
    return np.asarray(np.polyfit(np.log(across), np.log(up), 1))
