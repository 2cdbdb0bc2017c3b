"""IRLS: its laws for every kernel, and where it ends."""

from __future__ import annotations

from math import sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from robust_slam.estimators import StopReason, irls
from robust_slam.estimators.kernels import KERNELS, cauchy, huber, squared, tls
from robust_slam.problems import LinearProblem, LocationProblem

from tests.lib.worlds import cost_never_rises

LESSON = np.array([0.1, -0.2, 0.15, -0.1, 5.0])

numbers = st.floats(-50.0, 50.0, allow_subnormal=False)
kernels = st.builds(
    lambda name, scale: KERNELS[name](scale),
    st.sampled_from(sorted(KERNELS)),
    st.floats(0.1, 10.0),
)


def lesson(sigma=0.3):
    return LocationProblem(LESSON, sigma)


@given(z=st.lists(numbers, min_size=1, max_size=12), kernel=kernels, x0=numbers)
@settings(max_examples=300, deadline=None)
def test_the_robust_cost_of_a_location_never_rises(z, kernel, x0):
    assert cost_never_rises(irls(LocationProblem(z, 0.7), kernel, x0))


@given(seed=st.integers(0, 10**6), kernel=kernels)
@settings(max_examples=100, deadline=None)
def test_the_robust_cost_of_a_linear_problem_never_rises(seed, kernel):
    rng = np.random.default_rng(seed)
    trusted = np.arange(12) < 4
    problem = LinearProblem(rng.normal(size=(12, 3)), 5.0 * rng.normal(size=12), 0.5, trusted)
    assert cost_never_rises(irls(problem, kernel))


@pytest.mark.parametrize("name", KERNELS)
def test_at_the_end_the_pulls_balance(name):
    kernel, z = KERNELS[name](2.0), np.array([0.0, 0.3, -0.4, 0.2, 9.0])
    result = irls(LocationProblem(z), kernel, max_iterations=500)
    assert result.stop is StopReason.CONVERGED
    assert np.sum(kernel.psi(z - result.x)) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("name", KERNELS)
def test_the_cost_of_the_result_is_the_sum_of_rho(name):
    kernel = KERNELS[name](3.0)
    result = irls(lesson(), kernel)
    assert result.cost == pytest.approx(np.sum(kernel.rho((LESSON - result.x) / 0.3)), rel=1e-12)


def test_the_square_stays_at_least_squares():
    result = irls(lesson(), squared())
    assert result.x == pytest.approx(0.99, rel=1e-12)
    assert len(result.history) == 2


def test_the_fixed_point_of_the_lesson():
    result = irls(lesson(), cauchy(1))
    assert result.x == pytest.approx(-0.000241045593, abs=1e-11)
    assert result.cost == pytest.approx(3.216001, abs=5e-7)
    np.testing.assert_allclose(
        result.weights, [0.899566, 0.692821, 0.799486, 0.900434, 0.003587], atol=5e-7
    )


def test_truncated_least_squares_that_rejects_all_keeps_its_start():
    result = irls(lesson(), tls(1.0))
    assert (result.stop, result.x) == (StopReason.ALL_REJECTED, lesson().initial())
    np.testing.assert_array_equal(result.weights, np.zeros(5))


@pytest.mark.parametrize(
    ("sigma", "k", "expected"), [(0.3, 1, 0.0625), (1, 1, 0.2375), (0.3, 1.345, 0.088375)]
)
def test_huber_keeps_a_bias_of_k_sigma_per_inlier(sigma, k, expected):
    assert irls(lesson(sigma), huber(k)).x == pytest.approx(expected, abs=1e-10)


def test_one_step_by_hand():
    step = irls(LocationProblem([0, 0, 0, 10]), cauchy(1)).history[1]
    assert step.x == pytest.approx(145 / 358, rel=1e-14)
    assert irls(LocationProblem([0, 10]), cauchy(1), 4.0).history[1].x == pytest.approx(170 / 54)


@pytest.mark.parametrize("c", [1.0, 2.0])
def test_one_against_one_has_two_minima_and_a_maximum_between(c):
    pair = LocationProblem([0.0, 10.0])
    ends = [irls(pair, cauchy(c), x0, max_iterations=500).x for x0 in (4.0, 5.0, 6.0)]
    half = sqrt(25 - c**2)
    assert ends == pytest.approx([5 - half, 5.0, 5 + half], abs=1e-8)


@pytest.mark.parametrize(
    ("c", "end", "stop"),
    [
        (1.0, 8.0, StopReason.ALL_REJECTED),
        (3.0, 10.0, StopReason.CONVERGED),
        (9.0, 0.0, StopReason.CONVERGED),
        (12.0, 10 / 21, StopReason.CONVERGED),
    ],
)
def test_where_truncated_least_squares_ends_depends_on_c(c, end, stop):
    result = irls(LocationProblem([0.0] * 20 + [10.0]), tls(c), 8.0)
    assert (result.x, result.stop) == (pytest.approx(end, abs=1e-12), stop)


def test_a_tiny_weight_is_not_a_rejection():
    result = irls(LocationProblem([1e9]), cauchy(1), 0.0)
    assert (result.stop, result.x) == (StopReason.CONVERGED, 1e9)
    assert result.history[1].weights == pytest.approx(1e-18, rel=1e-12)
