"""Marginal covariances: against GTSAM, by hand, and by their limits."""

from __future__ import annotations

import gtsam
import numpy as np
import pytest
from robust_slam.descent.marginals import covariance
from robust_slam.descent.undamped import gauss_newton
from robust_slam.errors import Underdetermined
from robust_slam.graphs.generate import Noise, manhattan, sphere
from robust_slam.graphs.gtsam_graph import to_gtsam
from robust_slam.graphs.odometry import dead_reckoning

# Coarse noise, so that GTSAM's prior on pose 0, 1 mm and 1 mrad, does not matter.
COARSE = Noise(odometry=(0.3, 0.1), closure=(0.3, 0.1))


@pytest.mark.parametrize("make", [manhattan, sphere])
def test_it_is_gtsams(make):
    graph, _ = make(40, 3, noise=COARSE)
    poses = gauss_newton(graph, dead_reckoning(graph))
    marginals = gtsam.Marginals(*to_gtsam(graph, poses))
    order = [0, 1, 2] if graph.group.DIMENSION == 2 else [3, 4, 5, 0, 1, 2]
    for k, ours in zip([5, 20, 39], covariance(graph, poses, [5, 20, 39]), strict=True):
        theirs = np.empty_like(ours)
        theirs[np.ix_(order, order)] = marginals.marginalCovariance(k)
        np.testing.assert_allclose(ours, theirs, atol=2e-3 * np.abs(theirs).max())


def test_it_is_the_block_of_the_dense_inverse():
    graph, truth = manhattan(12, 0, closures=4)
    from robust_slam.graphs.pose_graph import jacobians

    by_i, by_j = jacobians(graph, truth)
    dense = np.zeros((36, 36))
    for (i, j), a, b, omega in zip(graph.edges, by_i, by_j, graph.information, strict=True):
        row = np.zeros((3, 36))
        row[:, 3 * i : 3 * i + 3] += a
        row[:, 3 * j : 3 * j + 3] += b
        dense += row.T @ omega @ row
    inverse = np.linalg.inv(dense[3:, 3:]).reshape(11, 3, 11, 3)
    every = covariance(graph, truth, np.arange(12))
    np.testing.assert_allclose(every[1:], [inverse[k, :, k] for k in range(11)], rtol=1e-6)
    np.testing.assert_array_equal(every[0], 0.0)


def test_shapes_follow_k_and_many_poses_are_as_few():
    graph, truth = manhattan(60, 1)
    several = covariance(graph, truth, [[1, 2], [3, 59]])
    assert several.shape == (2, 2, 3, 3)
    assert covariance(graph, truth, []).shape == (0, 3, 3)
    np.testing.assert_array_equal(covariance(graph, truth, 59), several[1, 1])
    np.testing.assert_allclose(covariance(graph, truth, np.arange(60))[59], several[1, 1])


def test_wrong_arguments_are_refused():
    graph, truth = manhattan(10, 3, closures=0)
    with pytest.raises(ValueError, match="k is 10; poses are 0 to 9"):
        covariance(graph, truth, 10)
    with pytest.raises(ValueError, match="k: the entries are float64"):
        covariance(graph, truth, 1.0)
    with pytest.raises(Underdetermined):
        covariance(graph, truth, 1, np.zeros(9))
