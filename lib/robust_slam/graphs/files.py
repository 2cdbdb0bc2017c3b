"""A pose graph from a file or from the public graphs, and back into a file, in one call."""

from __future__ import annotations

import logging
import os
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from robust_slam.graphs import datasets, g2o
from robust_slam.graphs.graph_file import GraphFile
from robust_slam.graphs.lines import Unknown
from robust_slam.graphs.matrices import Indefinite
from robust_slam.graphs.pose_graph import PoseGraph, check_poses
from robust_slam.graphs.reading import read
from robust_slam.graphs.trajectories import write_kitti, write_tum

SUFFIXES = (".g2o", ".tum", ".kitti")
"""The formats that ``save`` writes."""
_LOG = logging.getLogger(__name__)


def load(
    source: str | os.PathLike[str],
    *,
    indefinite: Indefinite = "raise",
    unknown: Unknown = "raise",
    odometry: tuple[float, float] | None = None,
    closures: str | os.PathLike[str] | None = None,
) -> PoseGraph:
    """Return the graph of a file in any format that ``read`` knows, or a public graph.

    ``source`` is a path, or one of ``datasets.NAMES`` where no such file exists. The other
    arguments are those of ``read``, which also returns the file's poses and ids. What was
    replaced, skipped, assumed or looks wrong is logged as a warning.

    Raises:
        FileNotFoundError: there is neither such a file nor a public graph of that name.
        DatasetMissing: the public graph is not on this machine.
        DatasetChanged: its checksum is wrong.
        GraphFileError, ValueError: as ``read``.
        OSError: the file cannot be read.
    """
    path = find(source)
    content = read(
        path, indefinite=indefinite, unknown=unknown, odometry=odometry, closures=closures
    )
    for words in content.remarks():
        _LOG.warning("%s: %s", path, words)
    return content.graph


def find(source: str | os.PathLike[str]) -> Path:
    """Return the path of a file, or of a public graph by its name.

    Raises:
        FileNotFoundError: there is neither such a file nor a public graph of that name.
        DatasetMissing: the public graph is not on this machine.
        DatasetChanged: its checksum is wrong.
    """
    path, name = Path(source), os.fspath(source)
    if path.exists():
        return path
    try:
        return datasets.find(name)
    except (datasets.DatasetMissing, datasets.DatasetChanged):
        raise
    except ValueError as error:
        raise FileNotFoundError(
            f"{name}: there is no such file, nor a public graph of that name; give the path of "
            f"a file or one of {', '.join(datasets.NAMES)}"
        ) from error


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
    and ``times`` ``(n,)`` (s) are by default those of a file that was read, or 0, 1, 2, …. The
    file is written at once or not at all.

    Raises:
        TypeError: ``graph`` is not a pose graph, or there are no poses for a trajectory.
        ValueError: the suffix is another one, or an argument does not fit the graph.
        OSError: the file cannot be written.

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
    given, order = check_poses("poses", poses, graph), np.arange(graph.n)
    if names is not None:
        order = np.argsort(g2o.checked_names(names, graph.n))
    if suffix == ".kitti":
        write_kitti(path, given[order])
    else:
        write_tum(path, given[order], None if times is None else np.asarray(times)[order])
