"""Gauss–Newton and Levenberg–Marquardt: steps, where they end, and errors that say what to fix."""

import numpy as np
import pytest
from robust_slam.descent.minimise import gauss_newton, levenberg_marquardt, undamped
from robust_slam.descent.normal_equations import NormalEquations
from robust_slam.descent.start import chordal
from robust_slam.errors import NotConverged, Underdetermined
from robust_slam.graphs import Noise, circle, dead_reckoning, manhattan, pose_graph, sphere
from robust_slam.graphs.pose_graph import PoseGraph
from robust_slam.groups import se2

from .. import worlds
from ..worlds import assert_same_poses, gradient, random_graph, refused, with_outliers

both_descents = pytest.mark.parametrize("solve", [gauss_newton, levenberg_marquardt])


def noisy(seed, n=30, outliers=0):
    graph, is_outlier, truth, _ = with_outliers(circle, n, seed, outliers, laps=2, closures=6)
    return graph, is_outlier, truth


@pytest.mark.parametrize("damping", [0.0, 0.3])
def test_the_sparse_step_is_the_dense_one(group, seed, damping):
    poses, graph = random_graph(seed, group, n=12, m=20)
    weights = np.random.default_rng(seed).uniform(0.1, 1.0, len(graph.edges))
    rows = worlds.dense_jacobian(graph, poses)[:, :, 1:].reshape(20, group.DOF, -1)
    weighted = np.swapaxes(rows, 1, 2) @ (weights[:, None, None] * graph.information)
    dense = np.sum(weighted @ rows, axis=0)
    right = np.einsum("kab,kb->a", weighted, -pose_graph.residuals(graph, poses))
    expected = np.linalg.solve(dense + damping * np.diag(np.diag(dense)), right)
    step, _ = NormalEquations(graph).at(poses, weights).step(damping)
    np.testing.assert_allclose(step[1:].ravel(), expected, rtol=1e-7, atol=1e-10)
    np.testing.assert_array_equal(step[0], np.zeros(group.DOF))


def test_pose_0_stays_and_takes_the_map_along():
    graph, _, _ = noisy(4)
    start, motion = dead_reckoning(graph), np.array([3.0, -1.0, 2.0])
    there = gauss_newton(graph, se2.compose(motion, start))
    np.testing.assert_allclose(there[0], motion)
    here = se2.compose(motion, gauss_newton(graph, start))
    np.testing.assert_allclose(there[:, :2], here[:, :2], atol=1e-7)


@pytest.mark.parametrize("seed", range(4))
def test_no_step_raises_the_cost_however_far_the_start(group, seed):
    poses, graph = random_graph(seed, group, n=20, m=40, residual=0.5)
    rng = np.random.default_rng(seed)
    poses = group.compose(poses, group.exp(worlds.random_twists(group, graph.n, rng, reach=8.0)))
    here = NormalEquations(graph).at(poses, np.ones(len(graph.edges)))
    for _ in range(30):
        cost = here.cost
        here = undamped(here, 1e-9, 1).here
        assert here.cost <= cost * (1.0 + 1e-9)


def test_information_that_spans_a_million_between_edges_is_solved(group, seed):
    truth, graph = random_graph(seed, group, n=20, m=40, residual=0.02)
    scaled = worlds.reweighted(graph, 10.0 ** np.linspace(-3.0, 3.0, 40))
    one, other = (gauss_newton(scaled, start) for start in (truth, chordal(scaled)))
    np.testing.assert_allclose(gradient(scaled, one), 0.0, atol=1e-6)
    least = pose_graph.cost(scaled, one)
    assert pose_graph.cost(scaled, other) == pytest.approx(least, rel=1e-9)


@pytest.fixture
def line():
    """Three poses, two steps of odometry and two closures."""
    z = np.outer([1.0, 1.0, 2.0, 0.0], [1.0, 0.0, 0.0])
    edges, is_odometry = [[0, 1], [1, 2], [0, 2], [0, 2]], [True, True, False, False]
    return PoseGraph(3, edges, z, np.tile(100.0 * np.eye(3), (4, 1, 1)), is_odometry)


def test_too_few_steps_are_an_error_with_a_fix():
    graph, _, _ = noisy(7, outliers=4)
    with pytest.raises(NotConverged, match=r"after 1 steps .* start from better poses"):
        gauss_newton(graph, dead_reckoning(graph), max_iterations=1)


def test_a_map_that_hangs_on_next_to_nothing_is_an_error(line):
    with pytest.raises(Underdetermined, match="singular to working precision"):
        gauss_newton(line, dead_reckoning(line), [1e-300, 1.0, 1e-300, 1e-300])


@refused(({"tol": -1.0}, "tol is -1.0"), ({"max_iterations": 0}, "max_iterations is 0"))
@both_descents
def test_a_limit_out_of_range_is_refused(line, solve, wrong, message):
    with pytest.raises(ValueError, match=message):
        solve(line, np.zeros((3, 3)), **wrong)


def test_edges_of_weight_zero_leave_the_step_and_make_a_pattern_that_stays_until_one_is_back():
    graph, is_outlier, truth = noisy(8, n=20, outliers=12)
    weights = np.where(is_outlier, 0.0, 1.0)
    equations = NormalEquations(graph)
    smaller, kept = equations.restricted(weights)
    assert smaller.pattern.row.size < equations.pattern.row.size
    np.testing.assert_array_equal(smaller.graph.edges, graph.edges[~is_outlier])
    asked = ((equations, weights), (smaller, kept))
    whole, part = (each.at(truth, w).step()[0] for each, w in asked)
    np.testing.assert_allclose(part, whole, rtol=1e-8, atol=1e-12)
    assert equations.restricted(np.ones(len(weights)))[0] is equations
    weights[0] = 0.5
    again, kept = equations.restricted(weights)
    assert again is smaller and kept[0] == 0.5
    weights[np.argmax(is_outlier)] = 0.1
    other, kept = equations.restricted(weights)
    assert other is not smaller and kept.size == np.count_nonzero(weights)


def test_residuals_are_kept_for_the_last_poses_also_when_these_changed_in_place(group):
    poses, graph = random_graph(0, group)
    equations, moved = NormalEquations(graph), poses.copy()
    kept = equations.residuals(moved).norms
    assert equations.residuals(poses).norms is kept
    moved[2:] = group.compose(poses[2:], group.exp(np.full(group.DOF, 0.1)))
    expected = pose_graph.residual_norms(graph, moved)
    np.testing.assert_allclose(equations.residuals(moved).norms, expected, rtol=1e-12)


def test_both_end_at_the_same_poses_with_weights(group):
    truth, graph = random_graph(5, group, n=15, m=40, residual=0.1)
    weights = np.random.default_rng(5).uniform(0.1, 1.0, 40)
    one, other = (solve(graph, truth, weights) for solve in (gauss_newton, levenberg_marquardt))
    assert_same_poses(group, one, other, 1e-7)


@pytest.mark.parametrize("damping", [0.0, 0.1, 10.0])
def test_where_residuals_are_small_the_cost_falls_as_predicted(group, damping):
    poses, graph = random_graph(6, group, n=15, m=40, residual=1e-5)
    here = NormalEquations(graph).at(poses, np.ones(40))
    step, predicted = here.step(damping)
    assert here.cost - here.moved(step).cost == pytest.approx(predicted, rel=1e-3)


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


@pytest.mark.long
@pytest.mark.parametrize("make", [manhattan, sphere])
@both_descents
@pytest.mark.parametrize("offset", [1e5, 1e9])
def test_the_cost_does_not_depend_on_where_the_map_is(make, solve, offset):
    graph, _ = make(60, 0)
    first = dead_reckoning(graph)
    group = graph.group
    away = group.from_parts(group.rotation(group.identity()), np.full(group.DIMENSION, offset))
    near = pose_graph.cost(graph, solve(graph, first))
    far = pose_graph.cost(graph, solve(graph, group.compose(away, first)))
    # Coordinates of 1e9 m are rounded to 1e-7 m.
    assert far == pytest.approx(near, rel=1e-12 * offset + 1e-9)
