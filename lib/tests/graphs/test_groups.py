"""The laws that SE(2) and SE(3) obey alike, and that one protocol promises."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from robust_slam.groups import group as groups
from robust_slam.groups import se2, se3

from ..worlds import assert_same_poses, random_poses, random_twists, slopes

FUNCTIONS_OF_POSES = ("inverse", "log", "adjoint", "rotation", "translation")


@pytest.fixture
def poses(group):
    return random_poses(group, 200, np.random.default_rng(1), reach=50.0)


@pytest.fixture
def others(group):
    return random_poses(group, 200, np.random.default_rng(2), reach=50.0)


def matrix(group, p):
    """The homogeneous matrix of each pose, which multiplies as poses compose."""
    d = group.DIMENSION
    full = np.zeros((*p.shape[: p.ndim - len(group.POSE_SHAPE)], d + 1, d + 1))
    full[..., :d, :d], full[..., :d, d] = group.rotation(p), group.translation(p)
    full[..., d, d] = 1.0
    return full


def apply(matrices, vectors):
    return (matrices @ vectors[..., None])[..., 0]


def twists_by(group, count, turn, seed, reach):
    """Tangent vectors that all turn by the same angle."""
    xi = random_twists(group, count, np.random.default_rng(seed), reach, 1.0)
    d = group.DIMENSION
    xi[:, d:] *= turn / np.linalg.norm(xi[:, d:], axis=1, keepdims=True)
    return xi


def test_composition_inverse_and_identity_are_those_of_matrices(group, poses, others):
    a, b = matrix(group, poses), matrix(group, others)
    for found, expected in (
        (group.identity(), np.eye(group.DIMENSION + 1)),
        (group.inverse(poses), np.linalg.inv(a)),
        (group.compose(poses, others), a @ b),
        (group.between(poses, others), np.linalg.solve(a, b)),
    ):
        np.testing.assert_allclose(matrix(group, found), expected, atol=1e-10)


@pytest.mark.parametrize("turn", [0.0, 1e-300, 1e-12, 1e-5, 0.04, 0.06, 0.29, 0.31, 1.0, 3.0])
def test_log_undoes_exp_at_every_angle(group, turn):
    xi = twists_by(group, 100, turn, 3, reach=20.0)
    np.testing.assert_allclose(group.log(group.exp(xi)), xi, rtol=1e-11, atol=1e-13)


def test_half_a_turn_has_a_logarithm(group):
    xi = np.zeros(group.DOF)
    xi[0], xi[-1] = 2.0, np.pi
    assert_same_poses(group, group.exp(group.log(group.exp(xi))), group.exp(xi), 1e-12)


def test_exp_of_a_longer_time_is_the_exps_one_after_the_other(group):
    xi = random_twists(group, 100, np.random.default_rng(4))
    found = group.compose(group.exp(0.3 * xi), group.exp(0.7 * xi))
    assert_same_poses(group, found, group.exp(xi), 1e-13)


def test_the_adjoint_carries_a_perturbation_to_the_other_side(group, poses):
    xi = random_twists(group, 200, np.random.default_rng(5), reach=1.0, turn=1.0)
    moved = group.compose(group.exp(apply(group.adjoint(poses), xi)), poses)
    assert_same_poses(group, group.compose(poses, group.exp(xi)), moved, 1e-10)


@pytest.mark.parametrize("turn", [0.0, 1e-7, 1e-3, 0.049, 0.051, 0.29, 0.31, 1.0, 2.0, 3.0])
def test_the_inverse_right_jacobian_is_the_derivative_of_log(group, turn):
    xi = twists_by(group, 40, turn, 6, reach=5.0)

    def moved(delta):
        return group.log(group.compose(group.exp(xi), group.exp(delta)))

    expected = slopes(moved, group.DOF, 1e-5)
    np.testing.assert_allclose(group.inverse_right_jacobian(xi), expected, rtol=1e-6, atol=1e-7)


@pytest.mark.parametrize("lead", [(), (1,), (4,), (2, 5), (0,)])
def test_every_function_works_over_leading_axes(group, lead):
    rng, count = np.random.default_rng(8), int(np.prod(lead))
    a, b = (random_poses(group, count, rng).reshape(*lead, *group.POSE_SHAPE) for _ in "ab")
    flat_a, flat_b = (x.reshape(-1, *group.POSE_SHAPE) for x in (a, b))
    for name in ("compose", "between"):
        together = getattr(group, name)(a, b)
        assert together.shape == a.shape
        one_by_one = [getattr(group, name)(p, q) for p, q in zip(flat_a, flat_b, strict=True)]
        np.testing.assert_allclose(together, np.reshape(one_by_one, a.shape), atol=1e-14)
    for name in FUNCTIONS_OF_POSES:
        together = getattr(group, name)(a)
        assert together.shape[: len(lead)] == lead
        one_by_one = np.array([getattr(group, name)(p) for p in flat_a]).reshape(together.shape)
        np.testing.assert_allclose(together, one_by_one, atol=1e-14)
    for name in ("exp", "inverse_right_jacobian"):
        xi = random_twists(group, count, rng).reshape(*lead, group.DOF)
        together = getattr(group, name)(xi)
        flat = [getattr(group, name)(v) for v in xi.reshape(-1, group.DOF)]
        np.testing.assert_allclose(together, np.reshape(flat, together.shape), atol=1e-13)


@pytest.mark.parametrize("name", [*FUNCTIONS_OF_POSES, "exp", "inverse_right_jacobian"])
@pytest.mark.parametrize("value", [1.0, np.zeros((3, 2)), np.zeros((2, 5))])
def test_arrays_that_hold_neither_poses_nor_tangent_vectors_are_refused(group, name, value):
    with pytest.raises(ValueError, match=r"the shape is .* give \(…, "):
        getattr(group, name)(value)


def test_the_group_is_told_by_the_shape():
    assert groups.group_of(np.zeros((5, 3))) is se2
    assert groups.group_of(np.zeros((5, 3, 4))) is se3
    assert groups.group_of(se3.identity()) is se3
    for shape in [(), (5,), (5, 4), (5, 4, 4), (5, 7)]:
        with pytest.raises(ValueError, match=r"poses: the shape is"):
            groups.group_of(np.zeros(shape))


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


def test_the_exponential_is_the_series_of_the_matrix():
    for xi in random_twists(se3, 20, np.random.default_rng(1)):
        generator = np.zeros((4, 4))
        x, y, z = xi[3:]
        generator[:3, :3] = [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]
        generator[:3, 3] = xi[:3]
        term, total = np.eye(4), np.eye(4)
        for k in range(1, 40):
            term = term @ generator / k
            total = total + term
        np.testing.assert_allclose(se3.exp(xi), total[:3], atol=1e-12)
