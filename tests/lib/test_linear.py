"""Linear least squares and the pose graph on a line."""

from __future__ import annotations

import numpy as np
import pytest
from robust_slam.errors import Underdetermined
from robust_slam.problems import LinearProblem, chain

from tests.lib.worlds import refused

LIE = {"i": [0, 1, 0, 0], "j": [1, 2, 2, 2], "z": [1.0, 1.0, 2.0, 0.0]}
SIGMA = [0.1, 0.1, 0.05, 0.05]


def test_one_lie_shortens_the_map_to_18_17():
    problem = chain(3, **LIE, sigma=SIGMA)
    x = problem.initial()
    np.testing.assert_allclose(x, [0.0, 9 / 17, 18 / 17], rtol=1e-13)
    assert np.sum(problem.residual_norms(x) ** 2) == pytest.approx(14400 / 17, rel=1e-13)


def test_the_whitened_residuals_keep_their_sign():
    problem = chain(3, **LIE, sigma=SIGMA)
    expected = [-4.705882, -4.705882, -18.823529, 21.176471]
    np.testing.assert_allclose(problem.residuals(problem.initial()), expected, atol=5e-7)


def test_at_the_truth_the_lie_alone_costs_1600():
    problem = chain(3, **LIE, sigma=SIGMA)
    np.testing.assert_allclose(
        problem.residual_norms([0.0, 1.0, 2.0]) ** 2, [0, 0, 0, 1600], rtol=1e-13
    )


def test_without_the_good_closure_the_lie_wins():
    x = chain(3, [0, 1, 0], [1, 2, 2], [1.0, 1.0, 0.0], [0.1, 0.1, 0.05]).initial()
    assert x[2] == pytest.approx(2 / 9, rel=1e-13)


def test_a_weight_of_0_takes_a_measurement_out():
    x = chain(3, **LIE, sigma=SIGMA).solve(np.array([1.0, 1.0, 1.0, 0.0]), np.zeros(3))
    np.testing.assert_allclose(x, [0.0, 1.0, 2.0], atol=1e-14)


def test_edges_off_the_cycle_of_the_lie_are_not_strained():
    sigma = [0.1, 0.1, 0.1, 0.1, 0.05]
    problem = chain(5, [0, 1, 2, 3, 1], [1, 2, 3, 4, 3], [1, 1, 1, 1, 0], sigma)
    x = problem.initial()
    np.testing.assert_allclose(x, [0, 1, 10 / 9, 11 / 9, 20 / 9], atol=1e-13)
    np.testing.assert_allclose(problem.residuals(x)[:4] * 0.1, [0, -8 / 9, -8 / 9, 0], atol=1e-13)


@pytest.mark.parametrize("anchor", [0, 1, 2])
def test_the_anchor_moves_the_map_and_changes_no_residual(anchor):
    problem = chain(3, **LIE, sigma=SIGMA, anchor=anchor)
    x = problem.initial()
    assert x[anchor] == 0.0
    reference = chain(3, **LIE, sigma=SIGMA)
    np.testing.assert_allclose(
        problem.residuals(x), reference.residuals(reference.initial()), rtol=1e-11
    )


def test_the_hessian_has_the_common_shift_as_its_kernel():
    problem = chain(3, **LIE, sigma=SIGMA)
    rows = problem.jacobian / problem.sigma[:, None]
    np.testing.assert_allclose(np.linalg.eigvalsh(rows.T @ rows), [0, 300, 1700], atol=1e-10)
    np.testing.assert_allclose(rows @ np.ones(3), np.zeros(4), atol=1e-14)


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
    free = chain(3, **LIE, sigma=SIGMA)
    with pytest.raises(Underdetermined, match="2 of 3 unknowns"):
        LinearProblem(free.jacobian, free.measurement, SIGMA).initial()


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


def test_shapes_that_do_not_agree_are_refused():
    with pytest.raises(ValueError, match="measurement: the shape"):
        LinearProblem(np.eye(2), [1.0, 2.0, 3.0])
    with pytest.raises(ValueError, match="jacobian: the shape"):
        LinearProblem([1.0, 2.0], [1.0, 2.0])
    with pytest.raises(ValueError, match="fixed: the shape"):
        LinearProblem(np.eye(2), [1.0, 2.0], fixed=[True])
