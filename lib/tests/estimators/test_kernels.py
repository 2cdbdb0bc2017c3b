"""The laws that every kernel obeys, and numbers by hand."""

from math import inf

import numpy as np
import pytest
from robust_slam.estimators.kernels import KERNELS, huber, tls

SCALES = (0.3, 1.0, 3.368)


@pytest.fixture(params=[(name, scale) for name in KERNELS for scale in SCALES], ids=str)
def kernel(request):
    name, scale = request.param
    return KERNELS[name](scale)


@pytest.fixture
def u(kernel):
    """Residuals on both sides of zero and of the scale, with the kink at |u| = scale left out."""
    sizes = np.concatenate([np.linspace(0.01, 0.99, 30), np.linspace(1.01, 40.0, 60)])
    return kernel.scale * np.concatenate([-sizes, sizes])


def test_cost_and_weight_are_even_influence_is_odd_and_a_zero_residual_is_free(kernel, u):
    assert (kernel.rho(0.0), kernel.psi(0.0), kernel.weight(0.0)) == (0.0, 0.0, 1.0)
    tiny = kernel.scale * np.array([1e-5, 1e-7, 1e-9])
    np.testing.assert_allclose(kernel.rho(tiny), tiny**2 / 2, rtol=1e-6)
    np.testing.assert_array_equal(kernel.rho(-u), kernel.rho(u))
    np.testing.assert_array_equal(kernel.weight(-u), kernel.weight(u))
    np.testing.assert_array_equal(kernel.psi(-u), -kernel.psi(u))


def test_the_cost_has_no_jump_at_the_scale(kernel):
    inside, outside = kernel.rho(kernel.scale * np.array([1.0 - 1e-12, 1.0 + 1e-12]))
    assert outside == pytest.approx(inside, rel=1e-9)


def test_influence_is_the_derivative_of_cost(kernel, u):
    h = 1e-6 * kernel.scale
    slope = (kernel.rho(u + h) - kernel.rho(u - h)) / (2.0 * h)
    np.testing.assert_allclose(kernel.psi(u), slope, rtol=1e-5, atol=1e-6)


def test_weight_is_influence_over_residual(kernel, u):
    at_the_kink = np.array([-kernel.scale, kernel.scale])
    u = np.concatenate([u, at_the_kink])
    np.testing.assert_allclose(kernel.weight(u), kernel.psi(u) / u, rtol=1e-14)


def test_weight_stays_in_the_unit_interval_and_never_grows_with_the_residual(kernel):
    weight = kernel.weight(kernel.scale * np.linspace(0.0, 50.0, 2001))
    assert np.all((weight >= 0.0) & (weight <= 1.0))
    assert np.all(np.diff(weight) <= 0.0)


def test_cost_is_convex_up_to_where_influence_turns(kernel):
    end = min(kernel.convex_until, 1e6 * kernel.scale)
    rises = np.diff(kernel.psi(np.linspace(0.0, end, 2001)))
    assert np.all(rises >= -1e-12 * end)
    if kernel.convex_until == inf:
        rises = np.diff(kernel.psi(np.logspace(0, 8, 200)))
        assert rises.min() >= -1e-12 * kernel.scale, "it falls: convex_until is finite"
    else:
        assert kernel.psi(end * 1.001) < kernel.psi(end)
        assert kernel.psi(end * 0.999) < kernel.psi(end)


def test_influence_ends_as_its_class_says(kernel):
    far, farther = kernel.psi(np.array([1e7, 1e8]))
    verdict = {
        "unbounded": farther > 9.0 * far,
        "bounded": 0.0 < far <= farther < far * (1.0 + 1e-6),
        "redescending": farther < 1e-6 * kernel.scale,
    }
    assert [name for name, holds in verdict.items() if holds] == [kernel.influence]


@pytest.mark.parametrize("shape", [(), (3,), (2, 2), (0,)])
def test_the_shape_is_kept_and_integers_are_accepted(kernel, shape):
    u = np.full(shape, 2)
    for function in (kernel.rho, kernel.psi, kernel.weight):
        assert np.shape(function(u)) == shape
        np.testing.assert_array_equal(function(u.tolist()), function(u.astype(float)))


@pytest.mark.parametrize("constructor", KERNELS.values(), ids=KERNELS)
@pytest.mark.parametrize("scale", [0.0, -1.0, inf, float("nan")])
def test_a_scale_that_is_not_above_zero_is_refused(constructor, scale):
    with pytest.raises(ValueError, match="above 0"):
        constructor(scale)


def test_at_the_threshold_the_inner_piece_holds():
    assert (tls(2).weight(-2), tls(2).psi(2), huber(2).psi(2), huber(2).weight(2)) == (1, 2, 2, 1)
