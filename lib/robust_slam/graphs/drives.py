"""A trajectory in TUM's or KITTI's format as odometry, with loop closures from another file.

TUM: one line ``time x y z qx qy qz qw`` a pose. KITTI: the twelve entries of [R | t], row by
row, a line a pose. Metres. The id of a pose is the number of its line, from 0; blank lines
and comments do not count.

Source: Sturm et al. 2012, "A benchmark for the evaluation of RGB-D SLAM systems"; Geiger et
al. 2012, "Are we ready for autonomous driving?".
"""

from __future__ import annotations

import numpy as np

from robust_slam._arrays import Array, positive
from robust_slam.graphs import quaternions, se3
from robust_slam.graphs.graph_file import GraphFile
from robust_slam.graphs.group import group_of
from robust_slam.graphs.lines import Fault, Rows, Tag, check_near, lines_of, rows_of, whole
from robust_slam.graphs.pose_graph import PoseGraph, with_closures
from robust_slam.graphs.rotations import nearest_rotations
from robust_slam.graphs.symptoms import symptoms
from robust_slam.graphs.tagged import Edges

_TUM, _KITTI = 8, 12
_ROUNDED = 1e-3
"""Files round; a pose deviates by less (m or rad) from a rotation, or from the plane."""


def poses_of(text: str) -> tuple[Array, Array | None]:
    """Return the poses ``(n, 3, 4)`` of a trajectory, and their times ``(n,)`` (s) if it has some.

    Raises:
        Fault: a line has neither 8 nor 12 numbers, or another count than the first line; a
            number is wrong; a time does not ascend; the left part of a line is no rotation; or
            there are fewer than two poses.
    """
    lines = list(lines_of(text))
    columns = len(lines[0][1])
    if columns not in (_TUM, _KITTI):
        raise Fault(
            lines[0][0],
            f"{columns} numbers are no pose of a trajectory; give 8, as TUM does (time x y z qx "
            "qy qz qw), or 12, as KITTI does ([R | t] row by row)",
        )
    for line, fields in lines:
        if len(fields) != columns:
            raise Fault(line, f"the line has {len(fields)} numbers, the first one {columns}")
    if len(lines) < 2:
        raise Fault(0, "one pose is no trajectory; give at least two")
    # The rows of tagged lines begin with a tag.
    rows = rows_of(((n, ["", *fields]) for n, fields in lines), Tag(0, columns), whole, "")
    return (_tum(rows), rows.numbers[:, 0]) if columns == _TUM else (_kitti(rows), None)


def _tum(rows: Rows) -> Array:
    back = np.diff(rows.numbers[:, 0], prepend=-np.inf) <= 0.0
    if np.any(back):
        raise rows.fault(back, "the time does not ascend; sort the lines and drop copies")
    rows = Rows(rows.line, rows.ids, rows.numbers[:, 1:])
    check_near(rows, rows.numbers[:, :3])
    return quaternions.poses_of(rows)


def _kitti(rows: Rows) -> Array:
    check_near(rows, rows.numbers[:, 3::4])
    given = rows.numbers.reshape(-1, 3, 4)
    rotation = nearest_rotations(given[:, :, :3])
    off = np.abs(rotation - given[:, :, :3]).max(axis=(1, 2)) > _ROUNDED
    if np.any(off):
        raise rows.fault(
            off, "the left part of [R | t] is not a rotation; give orthonormal columns"
        )
    return se3.from_parts(rotation, given[:, :, 3])


def check_ends(closures: Edges, n: int) -> None:
    """Refuse closures that refer to a pose that a trajectory of ``n`` poses does not have.

    Raises:
        Fault: there is one.
    """
    lost = np.any(closures.rows.ids >= n, axis=1)
    if np.any(lost):
        name = closures.rows.ids[np.argmax(lost)].max()
        raise closures.rows.fault(
            lost, f"pose {name} is missing: the trajectory has 0 to {n - 1}; drop the edge"
        )


def graph_of(
    poses: Array,
    times: Array | None,
    odometry: tuple[float, float],
    closures: Edges | None,
) -> GraphFile:
    """Return the graph of a drive ``(n, 3, 4)``: a step between consecutive poses, and closures.

    ``odometry`` are the standard deviations (m, rad) of each coordinate of a step, and ``times``
    ``(n,)`` (s) are kept. The graph is in SE(2) if the closures are, and the drive stays within
    1 mm and 1 mrad of its plane.

    Raises:
        ValueError: a deviation is not above 0, or the drive leaves the plane of the closures.
    """
    position, angle = (positive("odometry", value) for value in odometry)
    if closures is not None and closures.measurement.ndim == 2:
        poses = _in_plane(poses)
    group = group_of(poses)
    first = np.arange(len(poses) - 1)
    sigma = np.repeat([position, angle], [group.DIMENSION, group.DOF - group.DIMENSION])
    graph = PoseGraph(
        n=len(poses),
        edges=np.stack([first, first + 1], axis=1),
        measurement=group.between(poses[:-1], poses[1:]),
        information=np.broadcast_to(np.diag(sigma**-2.0), (first.size, group.DOF, group.DOF)),
        is_odometry=np.ones(first.size, dtype=np.bool_),
    )
    ids = np.arange(graph.n)
    if closures is None:
        return GraphFile(graph, poses, ids, ids, times=times, doubts=_doubts(graph, poses))
    graph = with_closures(graph, closures.rows.ids, closures.measurement, closures.information)
    repaired = closures.repaired + len(first)
    notes = (*closures.notes, *_steps_again(closures))
    doubts = _doubts(graph, poses)
    return GraphFile(graph, poses, ids, ids, repaired, closures.skipped, notes, times, doubts)


def _doubts(graph: PoseGraph, poses: Array) -> tuple[str, ...]:
    """Return what the drive was hardly meant to hold."""
    # No rotation, with w first, is half a circle about x with w last.
    half = group_of(poses).DOF == 6 and np.trace(poses[0, :, :3]) < _ROUNDED - 1.0
    upside_down = (
        "the first pose is turned by half a circle; if its quaternion begins with w, write "
        "qx qy qz qw",
    )
    return (*(upside_down if half else ()), *symptoms(graph, np.arange(graph.n)))


def _steps_again(closures: Edges) -> tuple[str, ...]:
    """Return a sentence about closures between consecutive poses, if there are any."""
    near = np.flatnonzero(np.abs(np.diff(closures.rows.ids, axis=1)[:, 0]) == 1)
    if not near.size:
        return ()
    return (
        f"{near.size:,} of the closures join consecutive poses (first line "
        f"{closures.rows.line[near[0]]}), as the odometry does; drop those that are its steps",
    )


def _in_plane(poses: Array) -> Array:
    """Return the poses ``(n, 3)`` of a drive that stays in the plane z = constant."""
    tilted = np.abs(poses[:, 2, :2]).max(axis=1) > _ROUNDED
    high = np.abs(poses[:, 2, 3] - poses[0, 2, 3]) > _ROUNDED
    if np.any(tilted | high):
        raise ValueError(
            f"closures: they are in the plane, and pose {int(np.argmax(tilted | high))} of the "
            "trajectory is not; give closures in space, EDGE_SE3:QUAT"
        )
    heading = np.arctan2(poses[:, 1, 0], poses[:, 0, 0])
    return np.column_stack([poses[:, :2, 3], heading])
