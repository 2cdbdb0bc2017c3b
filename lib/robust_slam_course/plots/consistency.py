"""Draw the consistency graph with a clique, and ranges that miss a point.

Every function takes matplotlib axes and returns them. A circle is an inlier, a cross an outlier; a
member of the clique is filled, and joined to the others by thick lines.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle
from numpy.typing import ArrayLike
from robust_slam._arrays import Array, Mask, finite, mask
from robust_slam.palette import MARKERS, PALETTE

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

    `adjacency` (m, m) is boolean and symmetric, its diagonal does not matter; `members` (k,) are
    the indices of the clique; the mask `is_outlier` (m,) marks the outliers.

    Raises:
        ValueError: `adjacency` is not square, or a mask or the names do not have m entries.
    """
    joined = np.triu(np.asarray(adjacency, dtype=np.bool_), 1)
    m = len(joined)
    outlying = mask("is_outlier", is_outlier, m)
    labels = [f"{k}" for k in range(m)] if names is None else list(names)
    if joined.shape != (m, m) or len(labels) != m:
        raise ValueError(f"adjacency: the shape is {joined.shape} with {len(labels)} names")
    inside = np.isin(np.arange(m), np.asarray(members))
    turn = np.pi / 2.0 - 2.0 * np.pi * np.arange(m) / max(m, 1)
    place = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    among = joined & inside & inside[:, None]
    _draw_pairs(ax, place, joined & ~among, PALETTE["muted"], 0.9)
    _draw_pairs(ax, place, among, PALETTE["estimate"], 2.0)
    for kind, chosen in (("inlier", ~outlying), ("outlier", outlying)):
        _draw_vertices(ax, place[chosen & inside], kind, PALETTE[kind])
        _draw_vertices(ax, place[chosen & ~inside], kind, "white")
    for label, (x, y) in zip(labels, _NAMED * place, strict=True):
        ax.text(x, y, label, ha="center", va="center")
    ax.set(xlim=(-1.3, 1.3), ylim=(-1.3, 1.3), aspect="equal")
    ax.set_axis_off()
    return ax


def draw_ranges(ax: Axes, places: ArrayLike, ranges: ArrayLike, best: ArrayLike) -> Axes:
    """Draw a circle of each range (m,) around its place (m, 2), and the point `best` (2,).

    Where the circles of two places cross, the two ranges agree; units are m.

    Raises:
        ValueError: an array has the wrong shape.
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


def _draw_pairs(ax: Axes, place: Array, joined: Mask, color: str, linewidth: float) -> None:
    """Draw all pairs as one line with gaps."""
    ends = place[np.argwhere(joined)]
    gaps = np.full((len(ends), 1, 2), np.nan)
    x, y = np.concatenate([ends, gaps], axis=1).reshape(-1, 2).T
    ax.plot(x, y, "-", color=color, linewidth=linewidth)


def _draw_vertices(ax: Axes, place: Array, kind: str, face: str) -> None:
    ax.plot(
        *place.T,
        MARKERS[kind],
        color=PALETTE[kind],
        markerfacecolor=face,
        markersize=11.0,
        zorder=5,
    )
