"""Draw which closures agree with which, as a ring and as a table, and ranges that miss a point."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle
from numpy.typing import ArrayLike
from robust_slam._arrays import finite, mask
from robust_slam.palette import MARKERS, PALETTE

from robust_slam_course.plots import ring, with_gaps

_NAMED = 1.19
"""How far from the middle the names stand; the vertices stand at 1."""


def draw_consistency(
    ax: Axes,
    adjacency: ArrayLike,
    members: ArrayLike = (),
    *,
    is_outlier: ArrayLike | None = None,
    names: Sequence[str] | None = None,
) -> Axes:
    """Draw m closures in a ring, clockwise from the top, and a line for each consistent pair.

    A circle is an inlier, a cross an outlier; a member of the clique is filled, and joined to the
    others by thick lines.

    `adjacency` (m, m) is boolean and symmetric, its diagonal does not matter; `members` (k,) are
    the indices of the clique; the mask `is_outlier` (m,) marks the outliers.
    """
    joined = np.triu(np.asarray(adjacency, dtype=np.bool_), 1)
    m = len(joined)
    outlying = mask("is_outlier", is_outlier, m)
    labels = [f"{k}" for k in range(m)] if names is None else list(names)
    if joined.shape != (m, m) or len(labels) != m:
        raise ValueError(f"adjacency: the shape is {joined.shape} with {len(labels)} names")
    inside = np.isin(np.arange(m), np.asarray(members))
    place, among = ring(m), joined & inside & inside[:, None]
    for pairs, colour, width in ((joined & ~among, "muted", 0.9), (among, "estimate", 2.0)):
        lines = with_gaps(place[np.argwhere(pairs)])
        ax.plot(*lines, "-", color=PALETTE[colour], linewidth=width)
    for kind, chosen in (("inlier", ~outlying), ("outlier", outlying)):
        look: dict[str, Any] = {"color": PALETTE[kind], "markersize": 11.0, "zorder": 5}
        for shown, face in ((chosen & inside, PALETTE[kind]), (chosen & ~inside, "white")):
            ax.plot(*place[shown].T, MARKERS[kind], markerfacecolor=face, **look)
    for label, (x, y) in zip(labels, _NAMED * place, strict=True):
        ax.text(x, y, label, ha="center", va="center")
    ax.set(xlim=(-1.3, 1.3), ylim=(-1.3, 1.3), aspect="equal")
    ax.set_axis_off()
    return ax


def draw_ranges(ax: Axes, places: ArrayLike, ranges: ArrayLike, best: ArrayLike) -> Axes:
    """Draw a circle of each range (m,) around its place (m, 2), and the point `best` (2,).

    Where the circles of two places cross, the two ranges agree; units are m.
    """
    at = finite("places", places, (-1, 2))
    for (x, y), size in zip(at, finite("ranges", ranges, (len(at),)), strict=True):
        ax.add_patch(Circle((x, y), size, fill=False, color=PALETTE["estimate"]))
    ax.plot(*at.T, "s", color=PALETTE["truth"], label="robot")
    point = finite("best", best, (2,))
    ax.plot(*point, MARKERS["accent"], color=PALETTE["outlier"], label="best point for all")
    ax.set_aspect("equal")
    ax.autoscale_view()
    ax.set_axis_off()
    return ax


def draw_agreement(
    ax: Axes, adjacency: ArrayLike, is_outlier: ArrayLike, members: ArrayLike
) -> Axes:
    """Draw a filled square where two closures are consistent, the inliers first.

    `adjacency` (m, m) and the mask `is_outlier` (m,) are over the closures, `members` (k,) are
    those of the clique, which get a ring on the diagonal. A line separates inliers from outliers.
    """
    m = np.size(is_outlier)
    wrong = mask("is_outlier", is_outlier, m)
    order = np.argsort(wrong, kind="stable")
    agrees = finite("adjacency", adjacency, (m, m))[np.ix_(order, order)] > 0.0
    row, column = np.nonzero(agrees & ~np.eye(m, dtype=bool))
    size = (190.0 / m) ** 2
    ax.scatter(column, row, s=size, marker="s", color=PALETTE["muted"], label="agree")
    chosen = np.flatnonzero(np.isin(order, members))
    rings = ax.scatter(chosen, chosen, s=size, facecolors="none", label="in the largest set")
    rings.set(edgecolors=PALETTE["estimate"], linewidths=1.4)
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
