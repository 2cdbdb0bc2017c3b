"""Draw the 1-D chain of poses: odometry along a line, closures as arcs."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike
from robust_slam._arrays import Array
from robust_slam.drawing import PATH, WRONG, Look, edge_looks
from robust_slam.palette import PALETTE


def draw_chain(
    ax: Axes,
    x: ArrayLike,
    edges: ArrayLike,
    *,
    is_odometry: ArrayLike,
    is_outlier: ArrayLike,
    labels: Sequence[str] | None = None,
    named: bool = True,
) -> Axes:
    """Draw poses x (n,) on a line: odometry along it, closures as arcs above it.

    `edges` is (m, 2), poses from 0; the wrong closures of the mask `is_outlier` (m,) are arcs
    below the line; `labels` (m,) are written at the middle of the edges. Poses are named x₁,
    x₂ …, unless `named` is False.
    """
    at, ends = np.asarray(x, dtype=np.float64), np.asarray(edges)
    looks = edge_looks(len(ends), is_odometry, is_outlier)
    texts = [""] * len(ends) if labels is None else labels
    for look, (i, j), text in zip(looks, ends, texts, strict=True):
        _draw_arc(ax, at[i], at[j], look, text)
    ax.plot(at, np.zeros_like(at), "o", color=PALETTE["truth"], zorder=6)
    for k, position in enumerate(at if named else []):
        _name_pose(ax, f"$x_{k + 1}$", position, at)
    ax.margins(x=0.1, y=0.3)
    ax.spines["left"].set_visible(False)
    ax.set(yticks=[])
    return ax


def _draw_arc(ax: Axes, start: float, end: float, look: Look, text: str) -> None:
    """Draw half an ellipse from start to end: flat for odometry, below for the outlier."""
    rise = 0.0 if look is PATH else -0.5 if look is WRONG else 0.5
    turn = np.linspace(0.0, np.pi, 41)
    across = 0.5 * (start + end) - 0.5 * (end - start) * np.cos(turn)
    ax.plot(across, rise * np.sin(turn), **look.style())
    if text:
        anchor = (0.5 * (start + end), rise)
        offset = (0, -5 if look is WRONG or look is PATH else 5)
        align = "top" if offset[1] < 0 else "bottom"
        ax.annotate(text, anchor, offset, textcoords="offset points", ha="center", va=align)


def _name_pose(ax: Axes, name: str, where: float, everyone: Array) -> None:
    """Write the name above the pose, or outside the chain at its two ends, clear of the arcs."""
    offset, align, base = (0, 6), "center", "bottom"
    if where == everyone.min():
        offset, align, base = (-8, 0), "right", "center"
    elif where == everyone.max():
        offset, align, base = (8, 0), "left", "center"
    ax.annotate(name, (where, 0.0), offset, textcoords="offset points", ha=align, va=base)
