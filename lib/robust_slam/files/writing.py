"""A pose graph as a file, and its edges as columns and rows, for tables and graph libraries."""

import os
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robust_slam.files import g2o
from robust_slam.files.graph_file import GraphFile
from robust_slam.files.trajectories import write_kitti, write_tum
from robust_slam.graphs.pose_graph import PoseGraph, check_graph, check_poses, deviations

SUFFIXES = (".g2o", ".tum", ".kitti")
"""The formats that ``save`` writes."""

_NAMES = {3: ("x", "y", "theta"), 7: ("x", "y", "z", "qx", "qy", "qz", "qw")}
"""The numbers of a pose in the plane and in space."""


def save(
    path: str | os.PathLike[str],
    graph: PoseGraph | GraphFile,
    poses: ArrayLike | None = None,
    *,
    names: ArrayLike | None = None,
    times: ArrayLike | None = None,
) -> None:
    """Write a graph or its poses, in the format that the suffix of ``path`` names.

    ``.g2o`` takes the edges and, if they are given, the ``poses`` ``(n, 3)`` or ``(n, 3, 4)`` as
    vertices. ``.tum`` and ``.kitti`` take the poses alone, by ascending name. ``names`` ``(n,)``
    and ``times`` ``(n,)`` (s) are by default those of a ``GraphFile``, or 0, 1, 2, …: the graph in
    it does not know them, nor does ``answer.clean``, so give ``names=file.ids``. The file is
    written at once or not at all.

    Raises:
        TypeError: ``graph`` is not a pose graph, or there are no poses for a trajectory.
        ValueError, OSError: another suffix, an argument that does not fit, or no place to write.

    >>> import tempfile
    >>> path = Path(tempfile.mkdtemp()) / "two.g2o"
    >>> save(path, PoseGraph(2, [[0, 1]], [[1, 0, 0]], np.eye(3)), names=[7, 9])
    >>> path.read_text()
    'EDGE_SE2 7 9 1.0 0.0 0.0 1.0 0.0 0.0 1.0 0.0 1.0\\n'
    """
    if isinstance(graph, GraphFile):
        names = graph.ids if names is None else names
        times = graph.times if times is None else times
        graph = graph.graph
    suffix = Path(path).suffix
    if suffix not in SUFFIXES:
        raise ValueError(f"{os.fspath(path)}: end it with {', '.join(SUFFIXES)}")
    if suffix == ".g2o":
        g2o.write(path, graph, poses, names)
        return
    if poses is None:
        raise TypeError(f"poses: {suffix} holds poses alone; give them, such as answer.poses")
    order = np.argsort(g2o.checked_names(names, check_graph(graph).n))
    given = check_poses("poses", poses, graph)[order]
    if suffix == ".kitti":
        write_kitti(path, given)
    else:
        write_tum(path, given, None if times is None else np.asarray(times)[order])


def to_columns(graph: PoseGraph) -> dict[str, NDArray[Any]]:
    """Return the edges as columns ``(m,)`` by their names, as ``pandas.DataFrame`` takes them.

    These are ``i``, ``j``, the measurement, ``x`` and ``y`` (m) and ``theta`` (rad) or ``x`` to
    ``z`` and ``qx`` to ``qw``, the claimed deviations ``sigma_m`` (m) of a coordinate and
    ``sigma_rad`` (rad) of an axis, and ``is_odometry``.

    >>> to_columns(PoseGraph(2, [[0, 1]], [[1, 0, 0.5]], 4 * np.eye(3)))["theta"].tolist()
    [0.5]
    """
    numbers = g2o.pose_numbers(check_graph(graph).measurement)
    return {
        **dict(zip(("i", "j"), graph.edges.T, strict=True)),
        **dict(zip(_NAMES[numbers.shape[1]], numbers.T, strict=True)),
        **dict(zip(("sigma_m", "sigma_rad"), deviations(graph), strict=True)),
        "is_odometry": graph.is_odometry,
    }


def to_rows(graph: PoseGraph) -> list[tuple[int, int, dict[str, Any]]]:
    """Return (i, j, other ``to_columns``) of each edge, as ``networkx.MultiDiGraph`` takes them.

    >>> to_rows(PoseGraph(2, [[0, 1]], [[1, 0, 0.5]], 4 * np.eye(3)))[0][2]["sigma_m"]
    0.5
    """
    columns = {name: column.tolist() for name, column in to_columns(graph).items()}
    i, j = columns.pop("i"), columns.pop("j")
    rows = (dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True))
    return list(zip(i, j, rows, strict=True))
