"""IRLS: its laws for every kernel, and where it ends."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from robust_slam.estimators import StopReason, chi_square_threshold, irls
from robust_slam.estimators.kernels import KERNELS, cauchy
from robust_slam.problems import LocationProblem
from scipy.optimize import least_squares

from ..worlds import cost_never_rises

LESSON = np.array([0.1, -0.2, 0.15, -0.1, 5.0])

numbers = st.floats(-50.0, 50.0, allow_subnormal=False)
kernels = st.builds(
    lambda name, scale: KERNELS[name](scale),
    st.sampled_from(sorted(KERNELS)),
    st.floats(0.1, 10.0),
)


def lesson():
    return LocationProblem(LESSON, 0.3)


@given(z=st.lists(numbers, min_size=1, max_size=12), kernel=kernels, x0=numbers)
@settings(max_examples=100, deadline=None)
def test_the_robust_cost_of_a_location_never_rises(z, kernel, x0):
    assert cost_never_rises(irls(LocationProblem(z, 0.7), kernel, x0))


def soft(z):
    """The loss soft_l1 of SciPy."""
    root = np.sqrt(1.0 + z)
    return np.stack([2.0 * (root - 1.0), 1.0 / root, -0.5 * root**-3])


@pytest.mark.parametrize("loss", ["linear", "huber", "cauchy", "soft_l1", "arctan", soft])
def test_a_loss_of_scipy_ends_where_scipy_ends(loss):
    def residuals(x):
        return (LESSON - x) / 0.3

    theirs = least_squares(residuals, 0.0, loss=loss, f_scale=0.8, ftol=None, gtol=1e-12)
    ours = irls(lesson(), loss=loss, c=0.8, x0=0.0, max_iterations=500)
    assert ours.x == pytest.approx(theirs.x[0], abs=1e-6)
    assert ours.cost == pytest.approx(theirs.cost, rel=1e-9)


def test_a_name_and_a_constructor_are_kernels_with_the_scale_of_the_probability():
    given = irls(lesson(), cauchy(chi_square_threshold(0.95, 1)))
    for kernel in ("cauchy", cauchy):
        assert irls(lesson(), kernel, probability=0.95).x == given.x


@pytest.mark.parametrize("name", KERNELS)
def test_at_the_end_the_pulls_balance_and_the_cost_is_the_sum_of_rho(name):
    kernel, z = KERNELS[name](2.0), np.array([0.0, 0.3, -0.4, 0.2, 9.0])
    result = irls(LocationProblem(z), kernel, max_iterations=500)
    assert result.stop is StopReason.CONVERGED
    assert np.sum(kernel.psi(z - result.x)) == pytest.approx(0.0, abs=1e-9)
    kernel = KERNELS[name](3.0)
    result = irls(lesson(), kernel)
    assert result.cost == pytest.approx(np.sum(kernel.rho((LESSON - result.x) / 0.3)), rel=1e-12)


def test_a_tiny_weight_is_not_a_rejection():
    result = irls(LocationProblem([1e9]), cauchy(1), 0.0)
    assert (result.stop, result.x) == (StopReason.CONVERGED, 1e9)
    assert result.history[1].weights == pytest.approx(1e-18, rel=1e-12)
