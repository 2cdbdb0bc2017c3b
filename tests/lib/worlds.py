"""Random poses and pose graphs in both groups, for the laws that hold everywhere."""

from __future__ import annotations

import numpy as np
from robust_slam.graphs import se2, se3
from robust_slam.graphs.pose_graph import PoseGraph

GROUPS = {"SE(2)": se2, "SE(3)": se3}


def random_twists(group, count, rng, reach=3.0, turn=2.0):
    """Tangent vectors with positions up to ``reach`` and turns up to ``turn`` an axis."""
    size = [reach] * group.DIMENSION + [turn] * (group.DOF - group.DIMENSION)
    return rng.uniform(-1.0, 1.0, size=(count, group.DOF)) * size


def random_poses(group, count, rng, reach=3.0, turn=1.5):
    return group.exp(random_twists(group, count, rng, reach, turn))


def random_information(group, count, rng):
    root = rng.normal(size=(count, group.DOF, group.DOF))
    return root @ np.swapaxes(root, 1, 2) + np.eye(group.DOF)


def random_graph(seed, group=se2, n=6, m=9, residual=1.0):
    """Poses and a connected graph whose residuals have about the given size."""
    rng = np.random.default_rng(seed)
    poses = random_poses(group, n, rng)
    tree = [(int(rng.integers(k)), k) for k in range(1, n)]
    loops = [tuple(rng.permutation(n)[:2]) for _ in range(m - n + 1)]
    edges = np.array(tree + loops)
    true = group.between(poses[edges[:, 0]], poses[edges[:, 1]])
    error = residual * rng.uniform(-1.0, 1.0, size=(m, group.DOF))
    return poses, PoseGraph(
        n,
        edges,
        group.compose(true, group.exp(error)),
        random_information(group, m, rng),
        np.arange(m) < n - 1,
    )


def perturbed(group, poses, k, delta):
    """Poses with number ``k`` moved on the right by Exp(delta)."""
    moved = poses.copy()
    moved[k] = group.compose(poses[k], group.exp(delta))
    return moved


def assert_same_poses(group, a, b, atol=1e-9):
    np.testing.assert_allclose(group.translation(a), group.translation(b), atol=atol)
    np.testing.assert_allclose(group.rotation(a), group.rotation(b), atol=atol)
