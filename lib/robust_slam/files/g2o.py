"""Pose graphs in g2o's text format: what its lines mean, and writing them.

Tags: ``VERTEX_SE2 id x y θ``, ``EDGE_SE2 i j x y θ`` and 6 numbers of information;
``VERTEX_SE3:QUAT id x y z qx qy qz qw``, ``EDGE_SE3:QUAT i j x y z qx qy qz qw`` and 21
numbers; ``FIX id``. Metres and radians. A file has vertices for all of its poses or for none
of them. A FIX line may name several ids. Lines ``PARAMS_…``, calibrations of sensors, are skipped.
Vertigo's ``EDGE_SE2_SWITCHABLE i j s …`` are edges without their switches s: the solver decides.
Lines with other tags are refused or, on demand, skipped.

An edge ``i j`` measures pose j in the frame of pose i, whichever id is larger; it is never
inverted. The information is the upper triangle, row by row, in the order (x, y, θ) or
(translation, rotation). The program g2o itself applies the last three rows in SE(3) to the
vector part of a quaternion, half the rotation vector of a small rotation; like GTSAM, this
library applies the matrix to (translation, rotation vector) unchanged.

Source: Kümmerle et al. 2011, "g2o: a general framework for graph optimization".
"""

import os
from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike

from robust_slam._arrays import Array, Ids
from robust_slam.files.lines import LARGEST_ID, write_lines
from robust_slam.files.tagged import Format, Layout, poses_of
from robust_slam.graphs.pose_graph import PoseGraph, check_graph, check_poses
from robust_slam.groups.rotations import quaternions_of

_PLANE_TOO = "EDGE_SE2_SWITCHABLE", "EDGE_SE2_MAXMIX"
_SPACE_TOO = "EDGE_SE3_SWITCHABLE", "EDGE_SE3_MAXMIX"
PLANE = Layout("VERTEX_SE2", "EDGE_SE2", 3, 3, angles=(2,), as_edge=_PLANE_TOO)
SPACE = Layout("VERTEX_SE3:QUAT", "EDGE_SE3:QUAT", 7, 6, poses_of, as_edge=_SPACE_TOO)
G2O = Format(
    PLANE,
    SPACE,
    fix="FIX",
    passed=("PARAMS_", "VERTEX_SWITCH", "EDGE_SWITCH_PRIOR"),
    elsewhere="; the command and rs.factors.read_factors use landmarks, priors and GPS",
)
"""What the lines of a g2o file mean."""


def write(
    path: str | os.PathLike[str],
    graph: PoseGraph,
    poses: ArrayLike | None = None,
    names: ArrayLike | None = None,
) -> None:
    """Write a graph as a g2o file from which ``read`` returns the same numbers.

    ``poses``, ``(n, 3)`` or ``(n, 3, 4)``, become vertices. ``names`` ``(n,)`` are ids for poses 0
    to n − 1, by default these numbers. A FIX line is written only if the id of pose 0 is not the
    smallest. Rotation matrices are recovered within 3e-15 the first time and exactly from then on.
    The format has no field for ``is_odometry``. It is written at once or not at all.

    Raises:
        TypeError: ``graph`` is not a pose graph.
        ValueError: ``poses`` do not fit the graph; ``names`` have the wrong length, repeat,
            are negative or not whole numbers, or do not ascend from the second one on.
        OSError: the file cannot be written.
    """
    layout = PLANE if check_graph(graph).group.DIMENSION == 2 else SPACE
    given = None if poses is None else check_poses("poses", poses, graph)
    write_lines(path, _lines(graph, given, checked_names(names, graph.n), layout))


def checked_names(value: ArrayLike | None, n: int) -> Ids:
    """Return ``value`` as ids ``(n,)`` of poses 0 to n - 1, which they are by default.

    Raises:
        ValueError: as ``write``.
    """
    names = np.arange(n, dtype=np.int64) if value is None else np.asarray(value)
    if names.shape != (n,):
        raise ValueError(f"names: the shape is {names.shape}; give ({n},)")
    if not np.issubdtype(names.dtype, np.integer):
        raise ValueError(f"names: the entries are {names.dtype}; give whole numbers")
    if names.min() < 0 or names.max() > LARGEST_ID:
        raise ValueError("names: an id is out of range; give 0 to 2^63 - 1")
    if np.any(names[2:] <= names[1:-1]) or np.any(names[1:] == names[0]):
        raise ValueError(
            "names: ids must differ, and ascend from entry 1 on, as they do when they are read"
        )
    return names.astype(np.int64)


def _lines(graph: PoseGraph, poses: Array | None, names: Ids, layout: Layout) -> Iterator[str]:
    if poses is not None:
        yield from _tagged(layout.vertex, names[:, None], pose_numbers(poses))
    if names[0] > names[1]:
        yield f"{G2O.fix} {names[0]}\n"
    triangle = graph.information[:, *np.triu_indices(layout.dof)]
    numbers = np.concatenate([pose_numbers(graph.measurement), triangle], axis=1)
    yield from _tagged(layout.edge, names[graph.edges], numbers)


def _tagged(tag: str, ids: Ids, numbers: Array) -> Iterator[str]:
    for names, values in zip(ids.tolist(), numbers.tolist(), strict=True):
        yield f"{tag} {' '.join(map(repr, names + values))}\n"


def pose_numbers(poses: Array) -> Array:
    """Return the numbers ``(k, 3)`` or ``(k, 7)`` of poses: x y θ, or x y z and a quaternion."""
    if poses.ndim == 2:
        return poses
    return np.concatenate([poses[:, :, 3], quaternions_of(poses[:, :, :3])], axis=1)
