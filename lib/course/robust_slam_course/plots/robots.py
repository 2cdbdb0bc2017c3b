"""Draw the maps of several robots, the boundary between them, and the closures they share."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike
from robust_slam._arrays import Mask, mask
from robust_slam.graphs.pose_graph import PoseGraph
from robust_slam.palette import PALETTE, LineStyle

from robust_slam_course.plots import with_gaps
from robust_slam_course.style import LOOKS

_ROBOTS = (*LOOKS[1:3], *LOOKS[4:6])  # olive is too near a trusted closure's green


def draw_robots(
    ax: Axes,
    graph: PoseGraph,
    poses: ArrayLike,
    labels: ArrayLike,
    weights: ArrayLike,
    *,
    is_outlier: ArrayLike,
) -> Axes:
    """Draw `poses` (n, 3), each in the look of its robot in `labels` (n,), and what they share.

    A pose on the boundary has a ring. A shared closure is trusted where its weight of
    `weights` (m,) is 1, rejected where it is 0, and otherwise undecided; those of the mask
    `is_outlier` (m,) have a cross at their middle. What a robot has closed alone is not drawn.

    Raises:
        ValueError: there are more robots than looks, or `is_outlier` does not fit.
    """
    xy, robot = np.asarray(poses, dtype=np.float64)[:, :2], np.asarray(labels)
    if robot.max() >= len(_ROBOTS):
        raise ValueError(f"labels: {robot.max() + 1} robots, but there are {len(_ROBOTS)} looks")
    for name in np.unique(robot):
        look, own = _ROBOTS[name], xy[robot == name]
        (way,) = ax.plot(*own.T, "-", color=look.color, label=f"robot {chr(65 + name)}")
        way.set(marker=look.marker, markersize=4.5, linewidth=1.6)
    shared = robot[graph.edges[:, 0]] != robot[graph.edges[:, 1]]
    border = xy[np.unique(graph.edges[shared])]
    ring: dict[str, Any] = {"mfc": "none", "mec": PALETTE["truth"], "markersize": 9, "mew": 0.9}
    ax.plot(*border.T, "o", **ring, label="boundary pose")
    ends, w = xy[graph.edges[shared]], np.asarray(weights)[shared]
    lines: tuple[tuple[str, Mask, str, LineStyle], ...] = (
        ("trusted", w == 1.0, "inlier", "-"),
        ("in doubt", (w > 0.0) & (w < 1.0), "inlier", (0.0, (4.0, 2.0))),
        ("rejected", w == 0.0, "muted", (0.0, (1.0, 2.0))),
    )
    for label, chosen, colour, line in lines:
        (edges,) = ax.plot(*with_gaps(ends[chosen]), color=PALETTE[colour], linestyle=line)
        edges.set(linewidth=1.1, zorder=1.5, label=f"{label} ({np.count_nonzero(chosen)})")
    wrong = ends[mask("is_outlier", is_outlier, len(graph.edges))[shared]].mean(axis=1)
    ax.plot(*wrong.T, "X", color=PALETTE["outlier"], label=f"wrong ({len(wrong)})")
    ax.set_aspect("equal", adjustable="box")
    ax.set_axis_off()
    return ax
