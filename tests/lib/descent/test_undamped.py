"""Gauss–Newton and Levenberg–Marquardt: hand numbers, laws, errors that say what to fix."""

from __future__ import annotations

import numpy as np
import pytest
from robust_slam.descent.damped import levenberg_marquardt
from robust_slam.descent.normal_equations import NormalEquations, weighted_edges
from robust_slam.descent.step import Linearisation
from robust_slam.descent.undamped import descend, gauss_newton
from robust_slam.errors import NotConverged, Underdetermined
from robust_slam.estimators.kernels import KERNELS, cauchy, tls
from robust_slam.estimators.result import StopReason
from robust_slam.estimators.reweighting import irls
from robust_slam.graphs import pose_graph, se2
from robust_slam.graphs.generate import Noise, circle, manhattan
from robust_slam.graphs.metrics import ate
from robust_slam.graphs.odometry import dead_reckoning
from robust_slam.graphs.outliers import add_random_closures
from robust_slam.graphs.pose_graph import PoseGraph
from robust_slam.problems import PoseGraphProblem

from tests.lib.worlds import assert_same_poses, random_graph, random_twists, refused


def line(z, sigma, edges=((0, 1), (1, 2), (0, 2), (0, 2))):
    """Poses on the x axis that all look ahead: there the residuals are linear."""
    measurement = np.zeros((len(z), 3))
    measurement[:, 0] = z
    information = np.eye(3) / np.square(sigma)[:, None, None]
    is_odometry = [j == i + 1 for i, j in edges]
    return PoseGraph(1 + np.max(edges), edges, measurement, information, is_odometry)


LIE = line([1.0, 1.0, 2.0, 0.0], [0.1, 0.1, 0.05, 0.05])


def noisy(seed, n=30, lies=0):
    rng = np.random.default_rng(seed)
    graph, truth = circle(n, rng, laps=2, closures=6)
    return *add_random_closures(graph, lies, rng, poses=truth), truth


def gradient(graph, poses, weights=None):
    weights = np.ones(len(graph.edges)) if weights is None else weights
    edges = weighted_edges(graph, Linearisation.at(graph, poses, weights), weights)
    return NormalEquations(graph).assemble(*edges)[1][1:]


def test_on_a_line_it_is_the_lesson_with_one_lie():
    poses = gauss_newton(LIE, dead_reckoning(LIE))
    expected = [[0.0, 0.0, 0.0], [9 / 17, 0.0, 0.0], [18 / 17, 0.0, 0.0]]
    np.testing.assert_allclose(poses, expected, atol=1e-12)
    assert 2.0 * pose_graph.cost(poses, LIE) == pytest.approx(14400 / 17, rel=1e-12)


def test_on_a_line_cauchy_and_the_pose_graph_agree_with_the_linear_problem():
    result = irls(PoseGraphProblem(LIE), cauchy(1))
    np.testing.assert_allclose(result.x[:, 0], [0.0, 0.99944424, 1.99888848], atol=5e-9)
    assert result.weights[3] == pytest.approx(6.25304e-4, rel=1e-5)


@pytest.mark.parametrize("make", [circle, manhattan])
def test_without_noise_it_finds_the_truth(make, seed):
    rng = np.random.default_rng(seed)
    graph, truth = make(40, rng, noise=Noise(scale=0.0))
    start = truth + 0.1 * rng.normal(size=truth.shape) * (np.arange(40) > 0)[:, None]
    poses = gauss_newton(graph, start)
    np.testing.assert_allclose(poses[:, :2], truth[:, :2], atol=1e-9)
    np.testing.assert_allclose(se2.wrap(poses[:, 2] - truth[:, 2]), 0.0, atol=1e-9)


@pytest.mark.parametrize("lies", [0, 3])
def test_at_the_end_the_gradient_is_zero_and_the_numbers_say_minimum(lies):
    graph, _, _ = noisy(1, lies=lies)
    start = dead_reckoning(graph)
    poses = gauss_newton(graph, start)
    assert np.abs(gradient(graph, poses)).max() < 1e-5 * np.abs(gradient(graph, start)).max()
    rng = np.random.default_rng(2)
    for _ in range(20):
        shake = 1e-3 * rng.normal(size=poses.shape) * (np.arange(graph.n) > 0)[:, None]
        assert pose_graph.cost(poses, graph) < pose_graph.cost(poses + shake, graph)


def test_the_gradient_is_the_derivative_of_the_cost():
    graph, _, truth = noisy(3)
    weights = np.linspace(0.2, 1.0, len(graph.edges))
    h = 1e-6
    for pose, slope in enumerate(gradient(graph, truth, weights), 1):
        for axis, e in enumerate(np.eye(3)):
            ahead, behind = truth.copy(), truth.copy()
            ahead[pose] = se2.compose(truth[pose], se2.exp(h * e))
            behind[pose] = se2.compose(truth[pose], se2.exp(-h * e))
            rise = pose_graph.cost(ahead, graph, weights) - pose_graph.cost(behind, graph, weights)
            assert slope[axis] == pytest.approx(rise / (2.0 * h), rel=1e-5, abs=1e-4)


@pytest.mark.parametrize("damping", [0.0, 0.3])
def test_the_sparse_step_is_the_dense_one(group, seed, damping):
    poses, graph = random_graph(seed, group, n=12, m=20)
    weights = np.random.default_rng(seed).uniform(0.1, 1.0, len(graph.edges))
    dof = group.DOF
    dense, right = np.zeros((12 * dof, 12 * dof)), np.zeros(12 * dof)
    r = pose_graph.residuals(poses, graph)
    by_i, by_j = pose_graph.jacobians(poses, graph)
    for k, (i, j) in enumerate(graph.edges):
        row = np.zeros((dof, 12 * dof))
        row[:, dof * i : dof * (i + 1)] = by_i[k]
        row[:, dof * j : dof * (j + 1)] = by_j[k]
        dense += weights[k] * row.T @ graph.information[k] @ row
        right -= weights[k] * row.T @ graph.information[k] @ r[k]
    free = (dense + damping * np.diag(np.diag(dense)))[dof:, dof:]
    expected = np.linalg.solve(free, right[dof:]).reshape(-1, dof)
    edges = weighted_edges(graph, Linearisation.at(graph, poses, weights), weights)
    step = NormalEquations(graph).solve(*edges, damping)
    np.testing.assert_allclose(step[1:], expected, rtol=1e-7, atol=1e-10)
    np.testing.assert_array_equal(step[0], np.zeros(dof))


def test_edges_in_both_directions_and_twice_over_add_up():
    z = [[1.0, 0.2, 0.3], [1.1, 0.2, 0.3], [-1.0, 0.1, -0.2], [0.9, 0.0, 0.1]]
    graph = PoseGraph(
        3, [[0, 1], [0, 1], [1, 0], [2, 1]], z, [np.eye(3)] * 4, [True, False, False, True]
    )
    poses = gauss_newton(graph, np.zeros((3, 3)))
    np.testing.assert_allclose(gradient(graph, poses), 0.0, atol=1e-8)
    assert pose_graph.residual_norms(poses, graph)[3] == pytest.approx(0.0, abs=1e-12)


def test_pose_0_stays_and_takes_the_map_along():
    graph, _, _ = noisy(4)
    start, motion = dead_reckoning(graph), np.array([3.0, -1.0, 2.0])
    there = gauss_newton(graph, se2.compose(motion, start))
    np.testing.assert_allclose(there[0], motion)
    here = se2.compose(motion, gauss_newton(graph, start))
    np.testing.assert_allclose(there[:, :2], here[:, :2], atol=1e-7)


def test_a_weight_of_0_takes_an_edge_out():
    graph, lies, _ = noisy(5, lies=4)
    keep = ~lies
    clean = PoseGraph(
        graph.n,
        graph.edges[keep],
        graph.measurement[keep],
        graph.information[keep],
        graph.is_odometry[keep],
    )
    start = dead_reckoning(graph)
    np.testing.assert_allclose(
        gauss_newton(graph, start, keep.astype(float)), gauss_newton(clean, start), atol=1e-8
    )


def test_a_weight_multiplies_the_information():
    graph, _, _ = noisy(6, lies=2)
    w = np.linspace(0.1, 1.0, len(graph.edges))
    scaled = PoseGraph(
        graph.n,
        graph.edges,
        graph.measurement,
        w[:, None, None] * graph.information,
        graph.is_odometry,
    )
    start = dead_reckoning(graph)
    np.testing.assert_allclose(
        gauss_newton(graph, start, w), gauss_newton(scaled, start), atol=1e-8
    )


@pytest.mark.parametrize("seed", range(4))
def test_no_step_raises_the_cost_however_far_the_start(group, seed):
    poses, graph = random_graph(seed, group, n=20, m=40, residual=0.5)
    rng = np.random.default_rng(seed)
    far = random_twists(group, graph.n, rng, reach=8.0, turn=2.0)
    poses = group.compose(poses, group.exp(far))
    equations, ones = NormalEquations(graph), np.ones(len(graph.edges))
    cost = pose_graph.cost(poses, graph)
    for _ in range(30):
        descent = descend(equations, poses, ones, 1e-9, 1)
        assert descent.cost <= cost * (1.0 + 1e-9)
        poses, cost = descent.poses, descent.cost


@pytest.mark.parametrize("solve", [gauss_newton, levenberg_marquardt])
def test_both_descents_end_where_the_gradient_is_zero(solve, group, seed):
    truth, graph = random_graph(seed, group, n=15, m=40, residual=0.1)
    poses = solve(graph, truth)
    scale = np.abs(gradient(graph, truth)).max()
    assert np.abs(gradient(graph, poses)).max() < 1e-6 * scale
    np.testing.assert_array_equal(poses[0], truth[0])


def test_both_descents_end_at_the_same_poses_with_weights(group):
    truth, graph = random_graph(5, group, n=15, m=40, residual=0.1)
    weights = np.random.default_rng(5).uniform(0.1, 1.0, 40)
    assert_same_poses(
        group,
        gauss_newton(graph, truth, weights),
        levenberg_marquardt(graph, truth, weights),
        1e-7,
    )


@pytest.mark.parametrize("seed", range(4))
def test_levenberg_marquardt_comes_to_rest_below_a_far_start(seed):
    graph, _, truth = noisy(seed, lies=6)
    rng = np.random.default_rng(seed)
    far = truth + rng.normal(size=truth.shape) * [5.0, 5.0, 2.0]
    poses = levenberg_marquardt(graph, far)
    assert pose_graph.cost(poses, graph) < pose_graph.cost(far, graph)
    assert np.abs(gradient(graph, poses)).max() < 1e-6 * np.abs(gradient(graph, far)).max()


def test_too_few_steps_are_told_with_what_to_do():
    graph, _, _ = noisy(7, lies=4)
    with pytest.raises(NotConverged, match=r"after 1 steps .* start from better poses"):
        gauss_newton(graph, dead_reckoning(graph), max_iterations=1)


def test_a_pose_that_weights_cut_off_is_named():
    weights = [1.0, 0.0, 0.0, 0.0]
    with pytest.raises(Underdetermined, match=r"joins pose 2 to pose 0 \(1 poses are loose\)"):
        gauss_newton(LIE, dead_reckoning(LIE), weights)


def test_a_map_that_hangs_on_next_to_nothing_is_told():
    with pytest.raises(Underdetermined, match="singular to working precision"):
        gauss_newton(LIE, dead_reckoning(LIE), [1e-300, 1.0, 1e-300, 1e-300])


@refused(
    ({"poses": np.zeros((2, 3))}, "poses: the shape"),
    ({"poses": np.full((3, 3), np.nan)}, "poses: the entry"),
    ({"weights": [1.0, 1.0]}, "weights: the shape"),
    ({"weights": [1.0, 1.0, -0.5, 1.0]}, "weights: edge 2 weighs less than 0"),
    ({"tol": -1.0}, "tol is -1.0"),
    ({"max_iterations": 0}, "max_iterations is 0"),
)
def test_bad_input_is_refused_by_name(wrong, message):
    with pytest.raises(ValueError, match=message):
        gauss_newton(LIE, **({"poses": np.zeros((3, 3))} | wrong))


def test_edges_of_weight_zero_leave_the_step_as_it_is_and_the_pattern_smaller():
    graph, is_lie, truth = noisy(8, n=20, lies=12)
    weights = np.where(is_lie, 0.0, 1.0)
    equations = NormalEquations(graph)
    smaller, kept = equations.restricted(weights)
    assert smaller.pattern.row.size < equations.pattern.row.size
    np.testing.assert_array_equal(smaller.graph.edges, graph.edges[~is_lie])
    whole, part = (
        each.step(each.at(truth, w), w) for each, w in ((equations, weights), (smaller, kept))
    )
    np.testing.assert_allclose(part, whole, rtol=1e-8, atol=1e-12)


def test_a_smaller_pattern_is_kept_until_an_edge_comes_back():
    graph, is_lie, _ = noisy(8, n=20, lies=12)
    equations, weights = NormalEquations(graph), np.where(is_lie, 0.0, 1.0)
    assert equations.restricted(np.ones(len(weights)))[0] is equations
    smaller, _ = equations.restricted(weights)
    weights[0] = 0.5
    again, kept = equations.restricted(weights)
    assert again is smaller and kept[0] == 0.5
    weights[np.argmax(is_lie)] = 0.1
    other, kept = equations.restricted(weights)
    assert other is not smaller and kept.size == np.count_nonzero(weights)


def test_the_problem_starts_from_dead_reckoning_and_trusts_the_odometry():
    graph, _, _ = noisy(9, lies=2)
    problem = PoseGraphProblem(graph)
    np.testing.assert_allclose(problem.guess, dead_reckoning(graph), atol=1e-12)
    np.testing.assert_array_equal(problem.trusted, graph.is_odometry)
    np.testing.assert_allclose(
        problem.initial(), gauss_newton(graph, dead_reckoning(graph)), atol=1e-8
    )


def test_a_graph_without_odometry_starts_along_its_closures():
    graph = PoseGraph(2, [[0, 1]], [[1.0, 0.0, 0.0]], [np.eye(3)], [False])
    problem = PoseGraphProblem(graph)
    np.testing.assert_array_equal(problem.guess, [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    assert not np.any(problem.trusted)


@pytest.mark.parametrize("name", KERNELS)
@pytest.mark.parametrize("steps", [1, 100])
def test_irls_never_raises_the_robust_cost_of_a_pose_graph(name, steps):
    graph, _, _ = noisy(10, lies=4)
    problem = PoseGraphProblem(graph, steps=steps)
    result = irls(problem, KERNELS[name](3.0), problem.guess, max_iterations=40)
    costs = np.array([step.cost for step in result.history])
    assert np.all(np.diff(costs) <= 1e-9 * costs[0])
    assert all(np.all(step.weights[graph.is_odometry] == 1.0) for step in result.history)


def test_cauchy_sees_through_lies_that_fold_the_least_squares_map():
    graph, lies, truth = noisy(11, lies=5)
    problem = PoseGraphProblem(graph)
    result = irls(problem, cauchy(1.0))
    assert result.stop is StopReason.CONVERGED
    assert ate(problem.initial(), truth) > 1.0
    assert ate(result.x, truth) < 0.2
    honest = ~lies & ~graph.is_odometry
    assert result.weights[lies].max() < 0.01 < result.weights[honest].min()


def test_without_trust_a_graph_may_be_rejected_whole():
    graph, _ = circle(30, np.random.default_rng(12))
    problem = PoseGraphProblem(graph, trusted=np.zeros(len(graph.edges), dtype=bool))
    result = irls(problem, tls(1e-6))
    assert result.stop is StopReason.ALL_REJECTED
    np.testing.assert_array_equal(result.x, problem.initial())
    np.testing.assert_array_equal(result.weights, np.zeros(len(graph.edges)))


def test_a_piece_that_is_cut_off_without_trust_is_an_error_that_names_it():
    graph, _, _ = noisy(12, lies=5)
    problem = PoseGraphProblem(graph, trusted=np.zeros(len(graph.edges), dtype=bool))
    with pytest.raises(Underdetermined, match="trust the odometry"):
        irls(problem, tls(1e-6))


@pytest.mark.parametrize("solve", [gauss_newton, levenberg_marquardt])
def test_a_map_that_fits_exactly_is_at_rest(solve):
    graph, truth = circle(20, np.random.default_rng(3), laps=2, closures=5, noise=Noise(scale=0.0))
    poses = solve(graph, dead_reckoning(graph))
    np.testing.assert_allclose(poses[:, :2], truth[:, :2], atol=1e-9)
