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

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from robust_slam._arrays import Array
from robust_slam.graphs.pose_graph import PoseGraph, check_poses

if TYPE_CHECKING:
    import gtsam

_PRIOR_SIGMA = 1e-3
"""Standard deviation of the prior, in m and rad."""
_ROTATION_FIRST = np.array([3, 4, 5, 0, 1, 2])


def to_gtsam(
    graph: PoseGraph, poses: ArrayLike
) -> tuple[gtsam.NonlinearFactorGraph, gtsam.Values]:
    """Return GTSAM's factor graph of ``graph`` and its values at ``poses``.

    ``poses`` are ``(n, 3)`` or ``(n, 3, 4)``. The factors have the order of the edges, followed
    by the prior on pose 0.

    Raises:
        ImportError: gtsam is not installed.
        ValueError: ``poses`` do not fit the graph.
    """
    checked = check_poses("poses", poses, graph)
    try:
        import gtsam
    except ImportError:
        raise ImportError("gtsam is missing; install it with: pip install gtsam") from None
    plane = graph.group.DIMENSION == 2
    between = gtsam.BetweenFactorPose2 if plane else gtsam.BetweenFactorPose3
    prior = gtsam.PriorFactorPose2 if plane else gtsam.PriorFactorPose3
    order = slice(None) if plane else _ROTATION_FIRST
    information = graph.information[:, order][:, :, order]
    factors, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
    for (i, j), z, omega in zip(graph.edges.tolist(), graph.measurement, information, strict=True):
        factors.add(between(i, j, _theirs(z), gtsam.noiseModel.Gaussian.Information(omega)))
    noise = gtsam.noiseModel.Isotropic.Sigma(graph.group.DOF, _PRIOR_SIGMA)
    factors.add(prior(0, _theirs(checked[0]), noise))
    for key, pose in enumerate(checked):
        values.insert(key, _theirs(pose))
    return factors, values


def poses_from_gtsam(values: gtsam.Values, graph: PoseGraph) -> Array:
    """Return the poses ``(n, 3)`` or ``(n, 3, 4)`` of keys 0 to n − 1.

    Raises:
        ValueError: a key is missing, or holds something other than a pose of the group.
    """
    try:
        if graph.group.DIMENSION == 3:
            return np.array([values.atPose3(key).matrix()[:3] for key in range(graph.n)])
        plane = map(values.atPose2, range(graph.n))
        return np.array([[pose.x(), pose.y(), pose.theta()] for pose in plane])
    except RuntimeError as error:
        raise ValueError(
            f"values: {str(error).rstrip('.')}; give the values of this graph's factors"
        ) from None


def _theirs(pose: Array) -> Any:  # noqa: ANN401 (a Pose2 or a Pose3)
    import gtsam

    if pose.ndim == 1:
        return gtsam.Pose2(*pose.tolist())
    return gtsam.Pose3(gtsam.Rot3(pose[:, :3]), pose[:, 3])
