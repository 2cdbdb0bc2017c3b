"""Linear least squares and the pose graph on a line."""

from __future__ import annotations

import numpy as np
import pytest
from robust_slam.errors import Underdetermined
from robust_slam.problems import LinearProblem, chain

from tests.lib.worlds import chapter_0, refused


def test_one_outlier_shortens_the_map_to_18_17():
    problem = chapter_0()
    x = problem.initial()
    np.testing.assert_allclose(x, [0.0, 9 / 17, 18 / 17], rtol=1e-13)
    expected = [-4.705882, -4.705882, -18.823529, 21.176471]
    np.testing.assert_allclose(problem.residuals(x), expected, atol=5e-7)
    assert np.sum(problem.residual_norms(x) ** 2) == pytest.approx(14400 / 17, rel=1e-13)


def test_a_weight_of_0_takes_a_measurement_out():
    x = chapter_0().solve(np.array([1.0, 1.0, 1.0, 0.0]), np.zeros(3))
    np.testing.assert_allclose(x, [0.0, 1.0, 2.0], atol=1e-14)


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


def test_small_weights_do_not_lose_an_unknown():
    x = chain(3, [0, 1], [1, 2], [1.0, 1.0]).solve(np.array([1.0, 1e-20]), np.zeros(3))
    np.testing.assert_allclose(x, [0.0, 1.0, 2.0], rtol=1e-5)


def test_a_pose_that_nothing_holds_is_an_error():
    with pytest.raises(Underdetermined, match="1 of 2 unknowns"):
        chain(3, [0, 1], [1, 2], [1.0, 1.0]).solve(np.array([1.0, 0.0]), np.zeros(3))


def test_without_an_anchor_the_line_is_underdetermined():
    free = chapter_0()
    with pytest.raises(Underdetermined, match="2 of 3 unknowns"):
        LinearProblem(free.jacobian, free.measurement, free.sigma).initial()


@refused(
    ({"i": [0, 3], "j": [1, 2]}, "i: edge 1 names pose 3"),
    ({"i": [0, 1], "j": [1, -1]}, "j: edge 1 names pose -1"),
    ({"i": [0, 1], "j": [1, 1]}, "edge 1 joins a pose to itself"),
    ({"i": [0], "j": [1, 2]}, "i: give 2 whole numbers"),
    ({"i": [0.0, 1.0], "j": [1, 2]}, "i: give 2 whole numbers"),
    ({"i": [0, 1], "j": [1, 2], "anchor": 3}, "anchor is 3"),
    ({"i": [0, 1], "j": [1, 2], "sigma": 0.0}, "sigma: entry 0"),
)
def test_bad_input_is_refused_by_name(wrong, message):
    with pytest.raises(ValueError, match=message):
        chain(3, z=[1.0, 1.0], **wrong)


@refused(
    ({"measurement": [1.0, 2.0, 3.0]}, "measurement: the shape"),
    ({"jacobian": [1.0, 2.0]}, "jacobian: the shape"),
    ({"fixed": [True]}, "fixed: the shape"),
)
def test_shapes_that_do_not_agree_are_refused(wrong, message):
    with pytest.raises(ValueError, match=message):
        LinearProblem(**({"jacobian": np.eye(2), "measurement": [1.0, 2.0]} | wrong))
