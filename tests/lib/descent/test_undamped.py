"""Gauss–Newton: its steps, where it ends, and errors that say what to fix."""

from __future__ import annotations

import numpy as np
import pytest
from robust_slam.descent.normal_equations import NormalEquations, weighted_edges
from robust_slam.descent.start import chordal
from robust_slam.descent.step import Linearisation
from robust_slam.descent.undamped import descend, gauss_newton
from robust_slam.errors import NotConverged, Underdetermined
from robust_slam.estimators.kernels import KERNELS, cauchy, squared, tls
from robust_slam.estimators.result import StopReason
from robust_slam.estimators.reweighting import irls
from robust_slam.graphs import pose_graph, se2
from robust_slam.graphs.generate import Noise, circle, manhattan
from robust_slam.graphs.metrics import ate
from robust_slam.graphs.odometry import dead_reckoning
from robust_slam.graphs.pose_graph import PoseGraph, select
from robust_slam.problems import PoseGraphProblem

from tests.lib.worlds import (
    assert_same_poses,
    chapter_0,
    cost_never_rises,
    gradient,
    perturbed,
    random_graph,
    random_twists,
    refused,
    reweighted,
    shaken,
    slopes,
    with_outliers,
)


def noisy(seed, n=30, outliers=0):
    graph, is_outlier, truth, _ = with_outliers(circle, n, seed, outliers, laps=2, closures=6)
    return graph, is_outlier, truth


def line():
    """The graph of chapter 0, its poses on the x axis: there residuals are linear."""
    measurement = np.zeros((4, 3))
    measurement[:, 0] = [1.0, 1.0, 2.0, 0.0]
    information = np.eye(3) / np.square([0.1, 0.1, 0.05, 0.05])[:, None, None]
    edges = [[0, 1], [1, 2], [0, 2], [0, 2]]
    return PoseGraph(3, edges, measurement, information, [True, True, False, False])


def test_on_a_line_it_ends_where_the_linear_problem_does():
    for kernel in (squared(), cauchy(1)):
        found = irls(PoseGraphProblem(line()), kernel)
        expected = irls(chapter_0(), kernel)
        np.testing.assert_allclose(found.x[:, 0], expected.x, atol=1e-9)
        np.testing.assert_allclose(found.weights, expected.weights, rtol=1e-7)
        assert found.cost == pytest.approx(expected.cost, rel=1e-12)


@pytest.mark.parametrize("make", [circle, manhattan])
def test_without_noise_it_finds_the_truth(make, seed):
    rng = np.random.default_rng(seed)
    graph, truth = make(40, rng, noise=Noise(scale=0.0))
    assert_same_poses(se2, gauss_newton(graph, shaken(se2, truth, 0.1, rng)), truth)


def test_the_gradient_is_the_derivative_of_the_cost(group):
    poses, graph = random_graph(3, group)
    weights = np.linspace(0.2, 1.0, 9)
    for pose, expected in enumerate(gradient(graph, poses, weights), 1):

        def moved(delta, pose=pose):
            return pose_graph.cost(perturbed(group, poses, pose, delta), graph, weights)

        np.testing.assert_allclose(slopes(moved, group.DOF), expected, rtol=1e-5, atol=1e-4)


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


def test_pose_0_stays_and_takes_the_map_along():
    graph, _, _ = noisy(4)
    start, motion = dead_reckoning(graph), np.array([3.0, -1.0, 2.0])
    there = gauss_newton(graph, se2.compose(motion, start))
    np.testing.assert_allclose(there[0], motion)
    here = se2.compose(motion, gauss_newton(graph, start))
    np.testing.assert_allclose(there[:, :2], here[:, :2], atol=1e-7)


def test_a_weight_multiplies_the_information_and_0_takes_an_edge_out():
    graph, is_outlier, _ = noisy(6, outliers=2)
    w = np.where(is_outlier, 0.0, np.linspace(0.1, 1.0, len(graph.edges)))
    left = select(reweighted(graph, np.where(is_outlier, 1.0, w)), ~is_outlier)
    start = dead_reckoning(graph)
    expected = gauss_newton(left, start)
    np.testing.assert_allclose(gauss_newton(graph, start, w), expected, atol=1e-8)


@pytest.mark.parametrize("seed", range(4))
def test_no_step_raises_the_cost_however_far_the_start(group, seed):
    poses, graph = random_graph(seed, group, n=20, m=40, residual=0.5)
    rng = np.random.default_rng(seed)
    poses = group.compose(poses, group.exp(random_twists(group, graph.n, rng, reach=8.0)))
    equations, ones = NormalEquations(graph), np.ones(len(graph.edges))
    cost = pose_graph.cost(poses, graph)
    for _ in range(30):
        descent = descend(equations, poses, ones, 1e-9, 1)
        assert descent.cost <= cost * (1.0 + 1e-9)
        poses, cost = descent.poses, descent.cost


def test_information_that_spans_a_million_between_edges_is_solved(group, seed):
    truth, graph = random_graph(seed, group, n=20, m=40, residual=0.02)
    scaled = reweighted(graph, 10.0 ** np.linspace(-3.0, 3.0, 40))
    one, other = (gauss_newton(scaled, start) for start in (truth, chordal(scaled)))
    np.testing.assert_allclose(gradient(scaled, one), 0.0, atol=1e-6)
    least = pose_graph.cost(one, scaled)
    assert pose_graph.cost(other, scaled) == pytest.approx(least, rel=1e-9)


def test_too_few_steps_are_an_error_with_a_fix():
    graph, _, _ = noisy(7, outliers=4)
    with pytest.raises(NotConverged, match=r"after 1 steps .* start from better poses"):
        gauss_newton(graph, dead_reckoning(graph), max_iterations=1)


def test_a_pose_that_weights_cut_off_is_named():
    weights = [1.0, 0.0, 0.0, 0.0]
    with pytest.raises(Underdetermined, match=r"joins pose 2 to pose 0 \(1 poses are loose\)"):
        gauss_newton(line(), dead_reckoning(line()), weights)


def test_a_map_that_hangs_on_next_to_nothing_is_an_error():
    with pytest.raises(Underdetermined, match="singular to working precision"):
        gauss_newton(line(), dead_reckoning(line()), [1e-300, 1.0, 1e-300, 1e-300])


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
        gauss_newton(line(), **({"poses": np.zeros((3, 3))} | wrong))


def test_edges_of_weight_zero_leave_the_step_as_it_is_and_the_pattern_smaller():
    graph, is_outlier, truth = noisy(8, n=20, outliers=12)
    weights = np.where(is_outlier, 0.0, 1.0)
    equations = NormalEquations(graph)
    smaller, kept = equations.restricted(weights)
    assert smaller.pattern.row.size < equations.pattern.row.size
    np.testing.assert_array_equal(smaller.graph.edges, graph.edges[~is_outlier])
    whole, part = (
        each.step(each.at(truth, w), w) for each, w in ((equations, weights), (smaller, kept))
    )
    np.testing.assert_allclose(part, whole, rtol=1e-8, atol=1e-12)


def test_a_smaller_pattern_is_kept_until_an_edge_comes_back():
    graph, is_outlier, _ = noisy(8, n=20, outliers=12)
    equations, weights = NormalEquations(graph), np.where(is_outlier, 0.0, 1.0)
    assert equations.restricted(np.ones(len(weights)))[0] is equations
    smaller, _ = equations.restricted(weights)
    weights[0] = 0.5
    again, kept = equations.restricted(weights)
    assert again is smaller and kept[0] == 0.5
    weights[np.argmax(is_outlier)] = 0.1
    other, kept = equations.restricted(weights)
    assert other is not smaller and kept.size == np.count_nonzero(weights)


def test_the_problem_starts_from_dead_reckoning_and_trusts_the_odometry():
    graph, _, _ = noisy(9, outliers=2)
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
    graph, _, _ = noisy(10, outliers=4)
    problem = PoseGraphProblem(graph, steps=steps)
    result = irls(problem, KERNELS[name](3.0), problem.guess, max_iterations=40)
    assert cost_never_rises(result, 1e-9)
    assert all(np.all(step.weights[graph.is_odometry] == 1.0) for step in result.history)


def test_cauchy_sees_through_outliers_that_fold_the_least_squares_map():
    graph, is_outlier, truth = noisy(11, outliers=5)
    problem = PoseGraphProblem(graph)
    result = irls(problem, cauchy(1.0))
    assert result.stop is StopReason.CONVERGED
    assert ate(problem.initial(), truth) > 1.0
    assert ate(result.x, truth) < 0.2
    inliers = ~is_outlier & ~graph.is_odometry
    assert result.weights[is_outlier].max() < 0.01 < result.weights[inliers].min()


def test_without_trust_a_graph_may_be_rejected_whole():
    graph, _ = circle(30, np.random.default_rng(12))
    problem = PoseGraphProblem(graph, trusted=np.zeros(len(graph.edges), dtype=bool))
    result = irls(problem, tls(1e-6))
    assert result.stop is StopReason.ALL_REJECTED
    np.testing.assert_array_equal(result.x, problem.initial())
    np.testing.assert_array_equal(result.weights, np.zeros(len(graph.edges)))


def test_a_piece_that_is_cut_off_without_trust_is_an_error_that_names_it():
    graph, _, _ = noisy(12, outliers=5)
    problem = PoseGraphProblem(graph, trusted=np.zeros(len(graph.edges), dtype=bool))
    with pytest.raises(Underdetermined, match="trust the odometry"):
        irls(problem, tls(1e-6))
