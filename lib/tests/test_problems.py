"""Locations, linear problems, rotations, pose graphs: what is solved, and what is refused."""

from functools import partial

import numpy as np
import pytest
from robust_slam import problems
from robust_slam.descent.minimise import gauss_newton
from robust_slam.errors import Underdetermined
from robust_slam.estimators import chi_square_threshold, gnc, irls
from robust_slam.estimators.kernels import KERNELS
from robust_slam.estimators.thresholds import dimension_of, threshold_of
from robust_slam.graphs import circle, dead_reckoning
from robust_slam.groups.se3 import exp
from robust_slam.problems import LinearProblem, LocationProblem, RotationProblem, chain

from .worlds import chapter_0, cost_never_rises, refused, with_outliers


def test_a_location_is_a_mean_in_which_precise_measurements_count_more_and_some_have_to():
    assert LocationProblem([1, 2, 6]).initial() == 3.0
    assert LocationProblem([0.0, 10.0], [1.0, 2.0]).initial() == pytest.approx(2.0)
    assert not LocationProblem([1.0, 2.0]).trusted.any()
    problem = LocationProblem([0.1, -0.2, 0.15, -0.1, 5.0], 0.3)
    expected = [2.966667, 3.966667, 2.8, 3.633333, 13.366667]
    np.testing.assert_allclose(problem.residual_norms(0.99), expected, atol=5e-7)
    with pytest.raises(Underdetermined, match="all are 0"):
        LocationProblem([1.0, 3.0]).solve(np.zeros(2), 0.0)


def test_one_outlier_shortens_the_map_to_18_17():
    problem = chapter_0()
    x = problem.initial()
    np.testing.assert_allclose(x, [0.0, 9 / 17, 18 / 17], rtol=1e-13)
    expected = [-4.705882, -4.705882, -18.823529, 21.176471]
    np.testing.assert_allclose(problem.residuals(x), expected, atol=5e-7)
    assert np.sum(problem.residual_norms(x) ** 2) == pytest.approx(14400 / 17, rel=1e-13)


def turned(count, rng, noise=0.0):
    """A rotation, and vectors before and after it."""
    rotation = exp(np.concatenate([np.zeros(3), rng.normal(size=3)]))[:, :3]
    a = rng.normal(size=(count, 3))
    return rotation, a, a @ rotation.T + noise * rng.normal(size=(count, 3))


def test_the_rotation_is_the_best_one_nearby():
    rng = np.random.default_rng(1)
    _, a, b = turned(12, rng, noise=0.5)
    weights, sigma = rng.uniform(size=12), rng.uniform(0.5, 2.0, 12)
    problem = RotationProblem(a, b, sigma)
    x = problem.solve(weights, np.eye(3))

    def cost(rotation):
        return weights @ problem.residual_norms(rotation) ** 2

    nearby = exp(np.column_stack([np.zeros((50, 3)), 1e-3 * rng.normal(size=(50, 3))]))
    assert all(cost(x) < cost(x @ step[:, :3]) for step in nearby)
    assert np.linalg.det(x) == pytest.approx(1.0)


def test_a_mirror_image_gets_a_rotation_too():
    a = np.random.default_rng(2).normal(size=(9, 3))
    x = RotationProblem(a, -a).initial()
    assert np.linalg.det(x) == pytest.approx(1.0)
    np.testing.assert_allclose(x @ x.T, np.eye(3), atol=1e-12)


def test_vectors_of_one_direction_leave_a_turn_around_it():
    a = np.outer([1.0, 2.0, -3.0], [0.0, 0.6, 0.8])
    with pytest.raises(Underdetermined, match="one direction"):
        RotationProblem(a, a).initial()
    with pytest.raises(Underdetermined, match="one direction"):
        RotationProblem(np.eye(3), np.eye(3)).solve(np.array([1.0, 0.0, 0.0]), np.eye(3))


def test_gnc_finds_a_rotation_among_outliers():
    rng = np.random.default_rng(3)
    rotation, a, b = turned(30, rng, noise=0.01)
    b[20:] = rng.normal(size=(10, 3))
    problem = RotationProblem(a, b, 0.01)
    result = gnc(problem)
    np.testing.assert_array_equal(result.kept, np.arange(30) < 20)
    np.testing.assert_allclose(result.x, rotation, atol=0.02)
    assert dimension_of(problem) == 3 and dimension_of(LocationProblem([1.0])) == 1
    assert threshold_of(problem, 0.99) == chi_square_threshold(0.99, 3)


@pytest.mark.parametrize("anchor", [0, 1, 2])
def test_the_anchor_moves_the_map_and_changes_no_residual(anchor):
    problem, reference = chapter_0(anchor=anchor), chapter_0()
    x = problem.initial()
    assert x[anchor] == 0.0
    expected = reference.residuals(reference.initial())
    np.testing.assert_allclose(problem.residuals(x), expected, rtol=1e-11)


def test_the_solution_satisfies_the_weighted_normal_equations():
    rng = np.random.default_rng(4)
    jacobian, z = rng.normal(size=(8, 3)), rng.normal(size=8)
    sigma, weights = rng.uniform(0.1, 2.0, 8), rng.uniform(0.0, 1.0, 8)
    x = LinearProblem(jacobian, z, sigma).solve(weights, np.zeros(3))
    information = weights / sigma**2
    np.testing.assert_allclose(jacobian.T @ (information * (jacobian @ x - z)), 0.0, atol=1e-9)


def test_small_weights_do_not_lose_an_unknown_and_without_an_anchor_the_line_does():
    x = chain(3, [0, 1], [1, 2], [1.0, 1.0]).solve(np.array([1.0, 1e-20]), np.zeros(3))
    np.testing.assert_allclose(x, [0.0, 1.0, 2.0], rtol=1e-5)
    free = chapter_0()
    with pytest.raises(Underdetermined, match="2 of 3 unknowns"):
        LinearProblem(free.jacobian, free.measurement, free.sigma).initial()


@refused(
    ((LocationProblem, []), "z is empty"),
    ((LocationProblem, [1.0, float("nan")]), r"z: the entry at \(1,\)"),
    ((LocationProblem, [[1.0]]), "z: the shape"),
    ((LocationProblem, [1.0, 2.0], [1.0, 0.0]), "sigma: entry 1"),
    ((LocationProblem, [1.0, 2.0], -1.0), "sigma: entry 0"),
    ((LocationProblem, [1.0, 2.0], [1.0, 1.0, 1.0]), "sigma: the shape"),
    ((LocationProblem, [1.0, 2.0], 1.0, [True]), "trusted: the shape"),
    ((LocationProblem, [1.0, 2.0], 1.0, [0, 1]), "trusted: the entries"),
    ((RotationProblem, np.eye(2), np.eye(3)), "a: the shape"),
    ((RotationProblem, np.eye(3), np.eye(3)[:2]), "b: the shape"),
    ((chain, 3, [0, 3], [1, 2], [1.0, 1.0]), "i: edge 1 names pose 3"),
    ((chain, 3, [0, 1], [1, -1], [1.0, 1.0]), "j: edge 1 names pose -1"),
    ((chain, 3, [0, 1], [1, 1], [1.0, 1.0]), "edge 1 joins a pose to itself"),
    ((chain, 3, [0], [1, 2], [1.0, 1.0]), "i: give 2 whole numbers"),
    ((chain, 3, [0.0, 1.0], [1, 2], [1.0, 1.0]), "i: give 2 whole numbers"),
    ((partial(chain, anchor=3), 3, [0, 1], [1, 2], [1.0, 1.0]), "anchor is 3"),
    ((LinearProblem, np.eye(2), [1.0, 2.0, 3.0]), "measurement: the shape"),
    ((LinearProblem, [1.0, 2.0], [1.0, 2.0]), "jacobian: the shape"),
    ((partial(LinearProblem, fixed=[True]), np.eye(2), [1.0, 2.0]), "fixed: the shape"),
)
def test_a_bad_problem_is_refused_by_name(wrong, message):
    make, *given = wrong
    with pytest.raises(ValueError, match=message):
        make(*given)


def noisy(seed, count):
    return with_outliers(circle, 30, seed, count, laps=2, closures=6)


def test_a_pose_graph_starts_from_dead_reckoning_and_trusts_the_odometry():
    graph, *_ = noisy(9, 2)
    problem, start = problems.PoseGraphProblem(graph), dead_reckoning(graph)
    np.testing.assert_allclose(problem.guess, start, atol=1e-12)
    np.testing.assert_array_equal(problem.trusted, graph.is_odometry)
    np.testing.assert_allclose(problem.initial(), gauss_newton(graph, start), atol=1e-8)


@pytest.mark.parametrize("name", KERNELS)
@pytest.mark.parametrize("steps", [1, 100])
def test_irls_never_raises_the_robust_cost_of_a_pose_graph(name, steps):
    graph, *_ = noisy(10, 4)
    problem = problems.PoseGraphProblem(graph, steps=steps)
    result = irls(problem, KERNELS[name](3.0), problem.guess, max_iterations=40)
    assert cost_never_rises(result, 1e-9)
    assert all(np.all(step.weights[graph.is_odometry] == 1.0) for step in result.history)
