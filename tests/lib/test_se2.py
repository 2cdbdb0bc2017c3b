"""The laws of the group SE(2) and of its derivatives."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from robust_slam import se2

coordinate = st.floats(-50.0, 50.0, allow_subnormal=False)
angle = st.floats(-3.1, 3.1, allow_subnormal=False)
poses = st.builds(lambda x, y, theta: np.array([x, y, theta]), coordinate, coordinate, angle)
ORIGIN = np.zeros(3)


def assert_same_pose(a, b, atol=1e-9):
    np.testing.assert_allclose(a[..., :2], b[..., :2], atol=atol)
    np.testing.assert_allclose(se2.wrap(a[..., 2] - b[..., 2]), 0.0, atol=atol)


def numerical_derivative(function, h=1e-6):
    """Central differences of ``function`` of a tangent vector, at 0, one column each."""
    columns = [(function(h * e) - function(-h * e)) / (2.0 * h) for e in np.eye(3)]
    return np.stack(columns, axis=-1)


def matrix(p):
    cosine, sine = np.cos(p[2]), np.sin(p[2])
    return np.array([[cosine, -sine, p[0]], [sine, cosine, p[1]], [0.0, 0.0, 1.0]])


@given(poses, poses)
def test_composition_is_the_product_of_matrices(a, b):
    np.testing.assert_allclose(matrix(se2.compose(a, b)), matrix(a) @ matrix(b), atol=1e-11)


@given(poses)
def test_the_origin_is_the_identity(p):
    assert_same_pose(se2.compose(p, ORIGIN), p)
    assert_same_pose(se2.compose(ORIGIN, p), p)


@given(poses)
def test_a_pose_and_its_inverse_cancel_on_both_sides(p):
    assert_same_pose(se2.compose(p, se2.inverse(p)), ORIGIN)
    assert_same_pose(se2.compose(se2.inverse(p), p), ORIGIN)


@given(poses, poses, poses)
def test_composition_is_associative(a, b, c):
    assert_same_pose(se2.compose(se2.compose(a, b), c), se2.compose(a, se2.compose(b, c)))


@given(poses, poses)
def test_between_is_inverse_then_compose(a, b):
    assert_same_pose(se2.between(a, b), se2.compose(se2.inverse(a), b))
    assert_same_pose(se2.compose(a, se2.between(a, b)), b)


def test_turning_left_by_hand():
    ahead_and_left = [1.0, 0.0, np.pi / 2]
    assert_same_pose(se2.compose(ahead_and_left, ahead_and_left), np.array([1.0, 1.0, np.pi]))


@given(poses)
@settings(max_examples=300)
def test_log_undoes_exp_and_exp_undoes_log(p):
    np.testing.assert_allclose(se2.log(se2.exp(p)), p, atol=1e-10)
    assert_same_pose(se2.exp(se2.log(p)), p)


def test_exp_of_a_half_turn_is_a_half_circle():
    assert_same_pose(se2.exp([np.pi, 0.0, np.pi]), np.array([0.0, 2.0, np.pi]))


@given(poses, st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_exp_of_a_longer_time_is_the_exps_one_after_the_other(xi, s, t):
    assert_same_pose(se2.compose(se2.exp(s * xi), se2.exp(t * xi)), se2.exp((s + t) * xi))


@pytest.mark.parametrize("theta", [0.0, 1e-300, -1e-17, 1e-9, -1e-4, 0.049, 0.051, 3.14, np.pi])
def test_log_undoes_exp_at_angles_where_formulas_break(theta):
    xi = np.array([3.0, -2.0, theta])
    np.testing.assert_allclose(se2.log(se2.exp(xi)), xi, rtol=1e-12, atol=1e-15)


@given(poses, poses)
def test_the_adjoint_carries_a_perturbation_to_the_other_side(p, xi):
    moved = se2.compose(se2.exp(se2.adjoint(p) @ xi), p)
    assert_same_pose(se2.compose(p, se2.exp(xi)), moved, atol=1e-7)


@given(poses)
@settings(max_examples=300)
def test_the_inverse_right_jacobian_is_the_derivative_of_log(xi):
    at = se2.exp(xi)
    slope = numerical_derivative(lambda delta: se2.log(se2.compose(at, se2.exp(delta))))
    np.testing.assert_allclose(se2.inverse_right_jacobian(xi), slope, rtol=1e-5, atol=1e-5)


def test_the_series_of_the_jacobian_joins_its_closed_form():
    inner, outer = (se2.inverse_right_jacobian([40.0, 30.0, 0.05 + e]) for e in (-1e-12, 1e-12))
    np.testing.assert_allclose(inner, outer, rtol=0.0, atol=1e-10)


@given(st.floats(-1e4, 1e4, allow_subnormal=False))
def test_wrap_changes_by_whole_turns_and_ends_in_the_half_open_interval(raw):
    wrapped = float(se2.wrap(raw))
    turns = (raw - wrapped) / (2.0 * np.pi)
    assert turns == pytest.approx(round(turns), abs=1e-9)
    assert -np.pi < wrapped <= np.pi + 1e-11


def test_wrap_leaves_an_angle_inside_to_the_last_bit():
    inside = np.array([np.pi, -3.0, -1e-17, 0.0, 1e-300, 3.0])
    np.testing.assert_array_equal(se2.wrap(inside), inside)
    assert se2.wrap(-np.pi) == np.pi


@pytest.mark.parametrize("shape", [(), (1,), (4,), (2, 5), (0,)])
def test_every_function_works_over_leading_axes(shape):
    rng = np.random.default_rng(5)
    a, b = rng.normal(size=(*shape, 3)), rng.normal(size=(*shape, 3))
    flat_a, flat_b = a.reshape(-1, 3), b.reshape(-1, 3)
    for function in (se2.compose, se2.between):
        one_by_one = [function(p, q) for p, q in zip(flat_a, flat_b, strict=True)]
        np.testing.assert_array_equal(
            function(a, b).reshape(-1, 3), np.reshape(one_by_one, (-1, 3))
        )
        assert function(a, b).shape == a.shape
    for function in (se2.inverse, se2.exp, se2.log, se2.adjoint, se2.inverse_right_jacobian):
        result = function(a)
        assert result.shape[: len(shape)] == shape
        one_by_one = np.array([function(p) for p in flat_a]).reshape(result.shape)
        np.testing.assert_array_equal(result, one_by_one)


def test_one_pose_goes_with_many():
    many = np.random.default_rng(6).normal(size=(4, 3))
    np.testing.assert_array_equal(
        se2.compose([1.0, 2.0, 0.3], many), se2.compose(np.tile([1.0, 2.0, 0.3], (4, 1)), many)
    )


@pytest.mark.parametrize("function", [se2.inverse, se2.exp, se2.log, se2.adjoint])
@pytest.mark.parametrize("value", [1.0, [1.0, 2.0], np.zeros((3, 2))])
def test_a_last_axis_that_is_not_3_is_refused(function, value):
    with pytest.raises(ValueError, match=r"the shape is .* give \(…, 3\)"):
        function(value)
