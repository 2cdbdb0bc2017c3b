"""A map in one line: the course's drawing of a pose graph, on axes of its own."""

from __future__ import annotations

import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from numpy.typing import ArrayLike
from robust_slam_course.plots import maps

from robust_slam.graphs.pose_graph import PoseGraph, check_poses


def draw_map(
    graph: PoseGraph,
    poses: ArrayLike,
    ax: Axes | None = None,
    *,
    kept: ArrayLike | None = None,
    truth: ArrayLike | None = None,
    view: tuple[int, int] = (0, 1),
) -> Axes:
    """Draw the path and the closures of a map, and return the axes.

    ``poses`` and ``truth`` are ``(n, 3)`` or ``(n, 3, 4)``. The mask ``kept`` ``(m,)`` fades
    rejected closures. In space the map is seen along the coordinate that ``view`` leaves out.
    Without ``ax`` a new figure is made.

    Raises:
        TypeError: ``graph`` is not a pose graph.
        ValueError: an argument does not fit the graph.
    """
    # A figure that was made in vain would stay open.
    check_poses("poses", poses, graph)
    if ax is None:
        _, ax = plt.subplots()
    return maps.draw_map(ax, graph, poses, kept=kept, truth=truth, view=view)
