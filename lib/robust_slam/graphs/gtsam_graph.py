"""Pose graphs as GTSAM's factor graphs, where gtsam is installed.

Key k is pose k, each edge a between factor with Gaussian noise of its information matrix.
GTSAM puts the rotation first in a tangent vector of SE(3), so rows and columns are
permuted. The error of the factor graph is the cost of ``pose_graph.cost``.

The cost is invariant to a rigid motion of the map, so a prior on pose 0 fixes the frame. At
a minimum the prior has no cost, and its deviations, 1 mm and 1 mrad, do not move the map. They
are part of GTSAM's marginals: that of pose 0 is 1e-6 I, while ``covariance`` returns 0.

Source: Dellaert 2012, "Factor graphs and GTSAM", for the conventions of the factors.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from robust_slam._arrays import Array, finite
from robust_slam.graphs.odometry import spanning_tree
from robust_slam.graphs.pose_graph import PoseGraph, check_poses

if TYPE_CHECKING:
    import gtsam

_PRIOR_SIGMA = 1e-3
"""Standard deviation of the prior, in m and rad."""
_ROTATION_FIRST = np.array([3, 4, 5, 0, 1, 2])


def to_gtsam(
    graph: PoseGraph, poses: ArrayLike | None = None, weights: ArrayLike | None = None
) -> tuple[gtsam.NonlinearFactorGraph, gtsam.Values]:
    """Return GTSAM's factor graph of ``graph`` and its values at ``poses``.

    ``poses``, ``(n, 3)`` or ``(n, 3, 4)``, are by default those of ``odometry.spanning_tree``.
    ``weights`` ``(m,)`` multiply the information; an edge of weight 0 has no factor. The
    factors have the order of the edges, followed by the prior on pose 0.

    Raises:
        ImportError: gtsam is not installed.
        ValueError: ``poses`` or ``weights`` do not fit the graph, or a weight is negative.
    """
    _need_gtsam()
    w = finite(
        "weights", np.ones(len(graph.edges)) if weights is None else weights, (len(graph.edges),)
    )
    if np.any(w < 0.0):
        raise ValueError(f"weights: edge {int(np.argmax(w < 0.0))} weighs less than 0")
    first = spanning_tree(graph, w) if poses is None else check_poses("poses", poses, graph)
    return _factors(graph, first, w), _values(first)


def poses_from_gtsam(values: gtsam.Values, graph: PoseGraph) -> Array:
    """Return the poses ``(n, 3)`` or ``(n, 3, 4)`` of keys 0 to n − 1.

    Raises:
        ValueError: a key is missing, or holds something other than a pose of the group.
    """
    try:
        return np.array([_pose(values, key, graph) for key in range(graph.n)])
    except RuntimeError as error:
        raise ValueError(
            f"values: {str(error).rstrip('.')}; give the values of this graph's factors"
        ) from None


def _need_gtsam() -> None:
    try:
        import gtsam  # noqa: F401
    except ImportError:
        raise ImportError("gtsam is missing; install it with: pip install gtsam") from None


def _factors(graph: PoseGraph, first: Array, weights: Array) -> gtsam.NonlinearFactorGraph:
    import gtsam

    order = slice(None) if graph.group.DIMENSION == 2 else _ROTATION_FIRST
    information = (weights[:, None, None] * graph.information)[:, order][:, :, order]
    factors = gtsam.NonlinearFactorGraph()
    for k in np.flatnonzero(weights):
        noise = gtsam.noiseModel.Gaussian.Information(information[k])
        i, j = graph.edges[k].tolist()
        factors.add(_between(i, j, graph.measurement[k], noise))
    factors.add(_prior(first[0], gtsam.noiseModel.Isotropic.Sigma(graph.group.DOF, _PRIOR_SIGMA)))
    return factors


def _between(i: int, j: int, pose: Array, noise: gtsam.noiseModel.Base) -> gtsam.NonlinearFactor:
    import gtsam

    if pose.ndim == 1:
        return gtsam.BetweenFactorPose2(i, j, _plane(pose), noise)
    return gtsam.BetweenFactorPose3(i, j, _space(pose), noise)


def _prior(pose: Array, noise: gtsam.noiseModel.Base) -> gtsam.NonlinearFactor:
    import gtsam

    if pose.ndim == 1:
        return gtsam.PriorFactorPose2(0, _plane(pose), noise)
    return gtsam.PriorFactorPose3(0, _space(pose), noise)


def _values(poses: Array) -> gtsam.Values:
    import gtsam

    values = gtsam.Values()
    for key, pose in enumerate(poses):
        values.insert(key, _plane(pose) if pose.ndim == 1 else _space(pose))
    return values


def _plane(pose: Array) -> gtsam.Pose2:
    import gtsam

    return gtsam.Pose2(*pose.tolist())


def _space(pose: Array) -> gtsam.Pose3:
    import gtsam

    return gtsam.Pose3(gtsam.Rot3(pose[:, :3]), pose[:, 3])


def _pose(values: gtsam.Values, key: int, graph: PoseGraph) -> Array:
    if graph.group.DIMENSION == 2:
        pose = values.atPose2(key)
        return np.array([pose.x(), pose.y(), pose.theta()])
    return np.asarray(values.atPose3(key).matrix()[:3])
