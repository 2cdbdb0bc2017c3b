"""Levenberg–Marquardt and Gauss–Newton end at the same poses, and at rest."""

from __future__ import annotations

import numpy as np
import pytest
from robust_slam.descent import gauss_newton, levenberg_marquardt
from robust_slam.descent.normal_equations import NormalEquations
from robust_slam.graphs import Noise, circle, dead_reckoning, pose_graph

from tests.lib.worlds import assert_same_poses, gradient, random_graph, with_outliers

both_descents = pytest.mark.parametrize("solve", [gauss_newton, levenberg_marquardt])


def test_both_end_at_the_same_poses_with_weights(group):
    truth, graph = random_graph(5, group, n=15, m=40, residual=0.1)
    weights = np.random.default_rng(5).uniform(0.1, 1.0, 40)
    one, other = (solve(graph, truth, weights) for solve in (gauss_newton, levenberg_marquardt))
    assert_same_poses(group, one, other, 1e-7)


@pytest.mark.parametrize("damping", [0.0, 0.1, 10.0])
def test_where_residuals_are_small_the_cost_falls_as_predicted(group, damping):
    poses, graph = random_graph(6, group, n=15, m=40, residual=1e-5)
    equations, ones = NormalEquations(graph), np.ones(40)
    current = equations.at(poses, ones)
    step, predicted = equations.damped_step(*equations.system(current), damping)
    assert current.cost - equations.moved(current, step).cost == pytest.approx(predicted, rel=1e-3)


@pytest.mark.parametrize("seed", range(4))
def test_it_comes_to_rest_below_a_far_start(seed):
    graph, _, truth, _ = with_outliers(circle, 30, seed, 6, laps=2, closures=6)
    far = truth + np.random.default_rng(seed).normal(size=truth.shape) * [5.0, 5.0, 2.0]
    poses = levenberg_marquardt(graph, far)
    assert pose_graph.cost(graph, poses) < pose_graph.cost(graph, far)
    assert np.abs(gradient(graph, poses)).max() < 1e-6 * np.abs(gradient(graph, far)).max()


@both_descents
def test_a_map_that_fits_exactly_is_at_rest(solve):
    graph, truth = circle(20, np.random.default_rng(3), laps=2, closures=5, noise=Noise(scale=0.0))
    poses = solve(graph, dead_reckoning(graph))
    np.testing.assert_allclose(poses[:, :2], truth[:, :2], atol=1e-9)
