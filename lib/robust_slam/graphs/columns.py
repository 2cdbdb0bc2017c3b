"""The edges of a pose graph as plain columns and rows, for tables and for other graph libraries.

Source: derived here.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from robust_slam.graphs import quaternions, se3
from robust_slam.graphs.pose_graph import PoseGraph, check_graph, deviations

_NAMES = ("x", "y", "theta"), ("x", "y", "z", "qx", "qy", "qz", "qw")
"""The numbers of a pose in the plane and in space."""


def to_columns(graph: PoseGraph) -> dict[str, NDArray[Any]]:
    """Return the edges as columns ``(m,)`` by their names, as ``pandas.DataFrame`` takes them.

    These are ``i``, ``j``, the measurement, ``x`` and ``y`` (m) and ``theta`` (rad) or ``x`` to
    ``z`` and ``qx`` to ``qw``, the claimed deviations ``sigma_m`` (m) of a coordinate and
    ``sigma_rad`` (rad) of an axis, and ``is_odometry``.

    Raises:
        TypeError: ``graph`` is not a pose graph.

    >>> to_columns(PoseGraph(2, [[0, 1]], [[1, 0, 0.5]], 4 * np.eye(3)))["theta"].tolist()
    [0.5]
    """
    z, plane = check_graph(graph).measurement, graph.group.DIMENSION == 2
    numbers = z if plane else np.concatenate([se3.translation(z), quaternions.of(z)], axis=1)
    return {
        **dict(zip(("i", "j"), graph.edges.T, strict=True)),
        **dict(zip(_NAMES[not plane], numbers.T, strict=True)),
        **dict(zip(("sigma_m", "sigma_rad"), deviations(graph), strict=True)),
        "is_odometry": graph.is_odometry,
    }


def to_rows(graph: PoseGraph) -> list[tuple[int, int, dict[str, Any]]]:
    """Return (i, j, other columns) for each edge, as ``networkx.MultiDiGraph`` takes them.

    Raises:
        TypeError: as ``to_columns``.

    >>> to_rows(PoseGraph(2, [[0, 1]], [[1, 0, 0.5]], 4 * np.eye(3)))[0][2]["sigma_m"]
    0.5
    """
    columns = {name: column.tolist() for name, column in to_columns(graph).items()}
    i, j = columns.pop("i"), columns.pop("j")
    rows = (dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True))
    return list(zip(i, j, rows, strict=True))
