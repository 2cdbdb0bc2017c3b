"""One number measured m times."""

from __future__ import annotations

import numpy as np
import pytest
from robust_slam.errors import Underdetermined
from robust_slam.problems import LocationProblem

from tests.lib.worlds import refused


def test_least_squares_is_the_mean():
    assert LocationProblem([1, 2, 6]).initial() == 3.0


def test_precise_measurements_count_more():
    assert LocationProblem([0.0, 10.0], [1.0, 2.0]).initial() == pytest.approx(2.0)


def test_residuals_are_whitened_and_have_no_sign():
    problem = LocationProblem([0.1, -0.2, 0.15, -0.1, 5.0], 0.3)
    expected = [2.966667, 3.966667, 2.8, 3.633333, 13.366667]
    np.testing.assert_allclose(problem.residual_norms(0.99), expected, atol=5e-7)


def test_the_solution_is_where_the_weighted_pull_is_zero():
    rng = np.random.default_rng(3)
    z, sigma, weights = rng.normal(size=9), rng.uniform(0.1, 2.0, 9), rng.uniform(0.0, 1.0, 9)
    x = LocationProblem(z, sigma).solve(weights, 0.0)
    assert np.sum(weights * (z - x) / sigma**2) == pytest.approx(0.0, abs=1e-11)


def test_tiny_weights_still_determine_x():
    assert LocationProblem([1.0, 3.0]).solve(np.array([1e-200, 1e-200]), 0.0) == 2.0


def test_no_weight_left_is_an_error_that_says_so():
    with pytest.raises(Underdetermined, match="all are 0"):
        LocationProblem([1.0, 3.0]).solve(np.zeros(2), 0.0)


def test_nothing_is_trusted_unless_it_is_said():
    assert not LocationProblem([1.0, 2.0]).trusted.any()


@refused(
    (([],), "z is empty"),
    (([1.0, float("nan")],), r"z: the entry at \(1,\)"),
    (([[1.0]],), "z: the shape"),
    (([1.0, 2.0], [1.0, 0.0]), "sigma: entry 1"),
    (([1.0, 2.0], -1.0), "sigma: entry 0"),
    (([1.0, 2.0], [1.0, 1.0, 1.0]), "sigma: the shape"),
    (([1.0, 2.0], 1.0, [True]), "trusted: the shape"),
    (([1.0, 2.0], 1.0, [0, 1]), "trusted: the entries"),
)
def test_bad_input_is_refused_by_name(wrong, message):
    with pytest.raises(ValueError, match=message):
        LocationProblem(*wrong)


def test_the_problem_keeps_its_own_copy():
    z = np.array([1.0, 3.0])
    problem = LocationProblem(z)
    z[0] = 100.0
    assert problem.initial() == 2.0
    with pytest.raises(ValueError, match="read-only"):
        problem.z[0] = 100.0
