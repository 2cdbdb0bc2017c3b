"""Pose graphs as data for a live picture."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from robust_slam.graphs.pose_graph import PoseGraph

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
        "truth": _numbers(truth, digits),
        "edges": graph.edges.tolist(),
        "measurements": _numbers(graph.measurement, digits),
        "information": _numbers(graph.information, digits),
        "trusted": graph.is_odometry.astype(int).tolist(),
        "wrongInformation": graph.information[~graph.is_odometry][0].ravel().tolist(),
    }


def _numbers(values: Array, digits: int) -> list[float]:
    return [round(float(value), digits) for value in np.ravel(values)]
