"""What several pictures share: pose graphs as data, tables, and the still picture of a map."""

import json
from collections.abc import Sequence
from importlib.resources import files
from typing import Any

import numpy as np
from matplotlib import pyplot as plt
from matplotlib.figure import Figure
from numpy.typing import ArrayLike, NDArray
from robust_slam._arrays import Mask
from robust_slam.drawing import decision_legend, draw_map, map_legend
from robust_slam.graphs.pose_graph import PoseGraph, with_closures
from robust_slam.groups import se2

from robust_slam_course.style import figure_style

Array = NDArray[np.float64]


def graph_data(graph: PoseGraph, truth: Array, digits: int = 6) -> dict[str, Any]:
    """Return ``graph`` in the plane and its true poses ``(n, 3)`` in m, m, rad for a script.

    A wrong closure of the reader's is as precise as the first correct one. Numbers keep
    ``digits`` decimals: a picture shows no more, and a page is smaller for it.

    Raises:
        ValueError: the graph is not in the plane.
    """
    if graph.group.DOF != 3:
        raise ValueError("graph: it is not in the plane; a live picture draws poses (x, y, θ).")
    return {
        "truth": numbers(truth, digits),
        "edges": graph.edges.tolist(),
        "measurements": numbers(graph.measurement, digits),
        "information": numbers(graph.information, digits),
        "trusted": graph.is_odometry.astype(int).tolist(),
        "wrongInformation": graph.information[~graph.is_odometry][0].ravel().tolist(),
    }


def numbers(values: Array, digits: int) -> list[float]:
    """Return all values as plain numbers of so many decimals."""
    return [round(float(value), digits) for value in np.ravel(values)]


def map_steps(poses: Array, unit: float) -> list[int]:
    """Return x and y of the first of ``poses``, then of each step to the next, in ``unit`` m."""
    places = np.round(poses[:, :2] / unit).astype(int)
    return np.diff(places, axis=0, prepend=0).ravel().tolist()


def with_wrong(
    graph: PoseGraph, ends: ArrayLike, measured: ArrayLike | None = None
) -> tuple[PoseGraph, Mask]:
    """Return ``graph`` with wrong closures ``ends`` ``(k, 2)``, and the mask ``(m,)`` of them.

    By default they measure "one place". They are as precise as the first correct closure, so
    that nothing but the other edges contradicts them.
    """
    z = np.zeros((len(np.asarray(ends)), 3)) if measured is None else measured
    spoiled = with_closures(graph, ends, z, graph.information[~graph.is_odometry][0])
    return spoiled, np.arange(len(spoiled.edges)) >= len(graph.edges)


def agreeing(truth: Array, ends: Sequence[int], size: int) -> tuple[ArrayLike, Array]:
    """Return wrong closures (i, j), (i + 1, j + 1), … that take pose j of ``truth`` for pose i.

    They are ``size`` pairs of ends ``(size, 2)`` and what they measure ``(size, 3)``.
    """
    i, j = edges = np.array(ends)[:, None] + np.arange(size)
    moved = se2.compose(truth[i[0]], se2.inverse(truth[j[0]]))
    return edges.T, se2.between(truth[i], se2.compose(moved, truth[j]))


def stored(name: str) -> dict[str, Any]:
    """Return a table that `tools/data` has computed."""
    found: dict[str, Any] = json.loads((files(__package__) / name).read_text(encoding="utf-8"))
    return found


@figure_style()
def map_still(
    graph: PoseGraph, poses: Array, truth: Array, is_outlier: Mask, kept: Mask | None = None
) -> Figure:
    """Return a map above its legend, which tells decisions where there is a mask ``kept``."""
    figure, ax = plt.subplots(figsize=(5.0, 3.6 if kept is None else 4.4))
    draw_map(graph, poses, ax, kept=kept, is_outlier=is_outlier, truth=truth)
    handles = map_legend() if kept is None else decision_legend()
    figure.legend(handles=handles, loc="outside lower center", ncols=2)
    return figure
