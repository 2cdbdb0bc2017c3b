"""IRLS: its law for every kernel, and the numbers of chapters 0, 1, 3 and 4."""

from __future__ import annotations

from math import log, sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from robust_slam.estimators.kernels import KERNELS, cauchy, huber, squared, tls
from robust_slam.estimators.result import StopReason
from robust_slam.estimators.reweighting import irls
from robust_slam.problems import LinearProblem, LocationProblem, chain

LESSON = np.array([0.1, -0.2, 0.15, -0.1, 5.0])

numbers = st.floats(-50.0, 50.0, allow_subnormal=False)
kernels = st.builds(
    lambda name, scale: KERNELS[name](scale),
    st.sampled_from(sorted(KERNELS)),
    st.floats(0.1, 10.0),
)


def lesson(sigma=0.3):
    return LocationProblem(LESSON, sigma)


def costs_never_rise(result):
    costs = np.array([step.cost for step in result.history])
    return np.all(np.diff(costs) <= 1e-10 * (1.0 + costs[:-1]))


@given(z=st.lists(numbers, min_size=1, max_size=12), kernel=kernels, x0=numbers)
@settings(max_examples=300, deadline=None)
def test_the_robust_cost_of_a_location_never_rises(z, kernel, x0):
    assert costs_never_rise(irls(LocationProblem(z, 0.7), kernel, x0))


@given(seed=st.integers(0, 10**6), kernel=kernels)
@settings(max_examples=100, deadline=None)
def test_the_robust_cost_of_a_linear_problem_never_rises(seed, kernel):
    rng = np.random.default_rng(seed)
    trusted = np.arange(12) < 4
    problem = LinearProblem(rng.normal(size=(12, 3)), 5.0 * rng.normal(size=12), 0.5, trusted)
    assert costs_never_rise(irls(problem, kernel))


@pytest.mark.parametrize("name", KERNELS)
def test_at_the_end_the_pulls_balance(name):
    kernel = KERNELS[name](2.0)
    result = irls(LocationProblem([0.0, 0.3, -0.4, 0.2, 9.0]), kernel, max_iterations=500)
    assert result.stop is StopReason.CONVERGED
    assert np.sum(kernel.psi(np.array([0.0, 0.3, -0.4, 0.2, 9.0]) - result.x)) == pytest.approx(
        0.0, abs=1e-9
    )


@pytest.mark.parametrize("name", KERNELS)
def test_the_cost_of_the_result_is_the_sum_of_rho(name):
    kernel = KERNELS[name](3.0)
    result = irls(lesson(), kernel)
    assert result.cost == pytest.approx(np.sum(kernel.rho((LESSON - result.x) / 0.3)), rel=1e-12)


def test_the_square_stays_at_least_squares():
    result = irls(lesson(), squared())
    assert result.x == pytest.approx(0.99, rel=1e-12)
    assert len(result.history) == 2


def test_the_first_step_of_the_lesson():
    step = irls(lesson(), cauchy(1)).history[1]
    assert step.x == pytest.approx(0.1026166673, abs=1e-10)
    np.testing.assert_allclose(
        step.weights, [0.102029, 0.059757, 0.113122, 0.070417, 0.00556583], atol=5e-7
    )


def test_the_first_ten_iterates_of_the_lesson():
    iterates = [step.x for step in irls(lesson(), cauchy(1)).history[:11]]
    expected = [0.99, 0.1026166673, 0.0307515102, 0.0100258694, 0.0032101379, 0.0009230766]
    expected += [0.0001520225, -0.0001082824, -0.0001961985, -0.0002258958, -0.0002359278]
    np.testing.assert_allclose(iterates, expected, atol=6e-11)


def test_the_fixed_point_of_the_lesson():
    result = irls(lesson(), cauchy(1))
    assert result.x == pytest.approx(-0.000241045593, abs=1e-11)
    assert result.cost == pytest.approx(3.216001, abs=5e-7)
    np.testing.assert_allclose(
        result.weights, [0.899566, 0.692821, 0.799486, 0.900434, 0.003587], atol=5e-7
    )


def test_another_start_ends_in_another_minimum():
    result = irls(lesson(), cauchy(1), 4.9)
    assert result.x == pytest.approx(4.922390691, abs=1e-9)
    assert result.cost == pytest.approx(11.239322, abs=5e-7)


def test_the_lessons_listing_with_sigma_1():
    result = irls(lesson(sigma=1.0), cauchy(1), 0.0)
    rows = [(step.x, step.weights[-1]) for step in result.history[1:6]]
    expected = [
        (0.037062180063, 0.038461538462),
        (0.039303174304, 0.039015632769),
        (0.039442595522, 0.039049514516),
        (0.039451284008, 0.039051623874),
        (0.039451825515, 0.039051755331),
    ]
    np.testing.assert_allclose(rows, expected, atol=1e-12)
    assert result.x == pytest.approx(0.0394518615, abs=1e-10)


@pytest.mark.parametrize(
    ("sigma", "c", "expected"),
    [
        (0.3, 3.0, [0.99, 0.125, -0.0125]),
        (0.3, 4.0, [0.99, -0.0125]),
        (1.0, 1.0, [0.99, 0.125, -0.0125]),
    ],
)
def test_truncated_least_squares_on_the_lesson(sigma, c, expected):
    result = irls(lesson(sigma), tls(c))
    iterates = [step.x for step in result.history]
    assert iterates == pytest.approx([*expected, expected[-1]], abs=1e-12)
    assert result.stop is StopReason.CONVERGED


def test_truncated_least_squares_that_rejects_all_keeps_its_start():
    result = irls(lesson(), tls(1.0))
    assert (result.stop, result.x) == (StopReason.ALL_REJECTED, lesson().initial())
    np.testing.assert_array_equal(result.weights, np.zeros(5))


@pytest.mark.parametrize(
    ("sigma", "k", "expected"), [(0.3, 1, 0.0625), (1, 1, 0.2375), (0.3, 1.345, 0.088375)]
)
def test_huber_keeps_a_bias_of_k_sigma_per_inlier(sigma, k, expected):
    assert irls(lesson(sigma), huber(k)).x == pytest.approx(expected, abs=1e-10)


@pytest.mark.parametrize(
    ("kernel", "expected"),
    [(squared(), 100 / 1001), (huber(1), 0.001), (cauchy(1), 9.99900110e-06)],
    ids=lambda value: getattr(value, "name", ""),
)
def test_one_outlier_among_a_thousand_inliers(kernel, expected):
    x = irls(LocationProblem([0.0] * 1000 + [100.0]), kernel).x
    assert x == pytest.approx(expected, rel=1e-8)


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


@pytest.mark.parametrize(("c", "end"), [(0.5, 0.001247045), (1, 0.004953021), (2, 0.019266817)])
def test_cauchy_escapes_where_truncated_least_squares_stays(c, end):
    assert irls(LocationProblem([0.0] * 20 + [10.0]), cauchy(c), 8.0).x == pytest.approx(
        end, abs=5e-10
    )


def test_two_closures_of_chapter_0_under_cauchy():
    problem = chain(
        3,
        [0, 1, 0, 0],
        [1, 2, 2, 2],
        [1.0, 1.0, 2.0, 0.0],
        [0.1, 0.1, 0.05, 0.05],
        trusted=[True, True, False, False],
    )
    result = irls(problem, cauchy(1))
    np.testing.assert_allclose(result.x, [0.0, 0.99944424, 1.99888848], atol=5e-9)
    assert result.weights[3] == pytest.approx(6.25304e-4, rel=1e-5)
    closures = np.array([2.0 - result.x[2], result.x[2]]) / 0.05
    odometry = (result.x[1] - 1.0) / 0.1
    expected = np.sum(np.log1p(closures**2)) / 2 + odometry**2
    assert result.cost == pytest.approx(expected, rel=1e-9)


def test_a_tiny_weight_is_not_a_rejection():
    result = irls(LocationProblem([1e9]), cauchy(1), 0.0)
    assert (result.stop, result.x) == (StopReason.CONVERGED, 1e9)
    assert result.history[1].weights == pytest.approx(1e-18, rel=1e-12)


def test_the_cauchy_cost_at_least_squares_of_the_lesson():
    start = irls(lesson(), cauchy(1)).history[0]
    u = [abs(z - 0.99) / 0.3 for z in LESSON]
    assert start.cost == pytest.approx(sum(log(1 + v * v) for v in u) / 2, rel=1e-12)
