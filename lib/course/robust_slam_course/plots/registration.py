"""Draw two scans of points in space, dots and plus signs, and the matches between them."""

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike
from robust_slam._arrays import Array, finite, mask
from robust_slam.palette import LINESTYLES, PALETTE

from robust_slam_course.plots import with_gaps

_TURN, _TILT = np.radians(-28.0), np.radians(24.0)
"""From where the scans are seen: around the vertical axis, and from above the horizon."""
_VIEW = np.array(
    [
        [np.cos(_TURN), -np.sin(_TURN), 0.0],
        [np.sin(_TILT) * np.sin(_TURN), np.sin(_TILT) * np.cos(_TURN), np.cos(_TILT)],
    ]
)

_MANY = 50
"""Wrong matches above this number are drawn faint."""


def seen(points: ArrayLike) -> Array:
    """Return where points (m, 3) appear in the drawing, (m, 2), without perspective."""
    return np.asarray(finite("points", points, (-1, 3)) @ _VIEW.T)


def draw_scans(ax: Axes, first: ArrayLike, second: ArrayLike) -> Axes:
    """Draw the points of two scans, (k, 3) and (l, 3), in one unit and one frame."""
    ax.plot(*seen(first).T, ".", color=PALETTE["estimate"], markersize=3.5, label="first scan")
    (plus,) = ax.plot(*seen(second).T, "+", color=PALETTE["truth"], label="second scan")
    plus.set(markersize=4.5, markeredgewidth=0.8)
    ax.set_aspect("equal")
    ax.set_axis_off()
    return ax


def draw_matches(ax: Axes, first: ArrayLike, second: ArrayLike, *, is_outlier: ArrayLike) -> Axes:
    """Draw a line for each match, `first` (m, 3) to `second` (m, 3); the legend counts them."""
    ends = seen(first)
    ends = np.stack([ends, seen(finite("second", second, (len(ends), 3)))], axis=1)
    wrong = mask("is_outlier", is_outlier, len(ends))
    # So many lines would hide the scans.
    faint = np.count_nonzero(wrong) > _MANY
    for chosen, kind, name, width, opacity in (
        (wrong, "outlier", "wrong", *((0.6, 0.5) if faint else (1.6, 1.0))),
        (~wrong, "inlier", "right", 2.0, 1.0),
    ):
        if not np.any(chosen):
            continue
        (line,) = ax.plot(*with_gaps(ends[chosen]), color=PALETTE[kind], linewidth=width)
        line.set(linestyle=LINESTYLES[kind], alpha=opacity)
        line.set(label=f"{name} ({np.count_nonzero(chosen)})")
    return ax
