"""Draw which closures agree with which, as a table of squares, and the set that was kept."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike
from robust_slam._arrays import finite, mask
from robust_slam.palette import PALETTE


def draw_agreement(
    ax: Axes, adjacency: ArrayLike, is_outlier: ArrayLike, members: ArrayLike
) -> Axes:
    """Draw a filled square where two closures are consistent, the inliers first.

    `adjacency` (m, m) and the mask `is_outlier` (m,) are over the closures, `members` (k,) are
    those of the clique, which get a ring on the diagonal. A line separates inliers from outliers.

    Raises:
        ValueError: the arrays do not fit each other.
    """
    m = np.size(is_outlier)
    wrong = mask("is_outlier", is_outlier, m)
    order = np.argsort(wrong, kind="stable")
    agrees = finite("adjacency", adjacency, (m, m))[np.ix_(order, order)] > 0.0
    row, column = np.nonzero(agrees & ~np.eye(m, dtype=bool))
    size = (190.0 / m) ** 2
    ax.scatter(column, row, s=size, marker="s", color=PALETTE["muted"], label="agree")
    chosen = np.flatnonzero(np.isin(order, members))
    ring: dict[str, Any] = {"facecolors": "none", "edgecolors": PALETTE["estimate"]}
    ax.scatter(chosen, chosen, s=size, marker="o", label="in the largest set", lw=1.4, **ring)
    border = m - np.count_nonzero(wrong) - 0.5
    for line in (ax.axhline, ax.axvline):
        line(border, color=PALETTE["outlier"], linestyle="--", linewidth=1.4)
    ax.set(xlim=(-0.7, m - 0.3), ylim=(m - 0.3, -0.7), aspect="equal")
    ax.grid(visible=False)
    middles = [0.5 * (border - 0.5), 0.5 * (border + m - 0.5)]
    ax.set_xticks(middles, ["inliers", "outliers"])
    ax.set_yticks(middles, ["inliers", "outliers"], rotation=90, va="center")
    ax.tick_params(length=0)
    return ax
