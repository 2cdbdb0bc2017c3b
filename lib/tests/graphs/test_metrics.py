"""Precision, recall and the error of a trajectory."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from robust_slam.graphs.metrics import align, ate, nees, precision_recall
from robust_slam.groups import se2, se3

from ..worlds import assert_same_poses, leave_out, random_poses, refused

seeds = pytest.mark.parametrize("seed", range(4))

masks = st.integers(1, 12).flatmap(
    lambda n: st.tuples(*[st.lists(st.booleans(), min_size=n, max_size=n)] * 2)
)


def trajectory(seed, group, n=15):
    return random_poses(group, n, np.random.default_rng(seed), reach=5.0)


def motion(group, seed):
    return random_poses(group, 1, np.random.default_rng(100 + seed), reach=30.0, turn=1.7)[0]


def noisy(truth, group, seed, size=0.3):
    """The way of ``truth``, moved and shaken a little at every pose."""
    shake = size * np.random.default_rng(seed).normal(size=(len(truth), group.DOF))
    return group.compose(motion(group, seed), group.compose(truth, group.exp(shake)))


def placed(group, *places):
    """Poses without a turn at places on the x axis."""
    axis = np.eye(group.DIMENSION)
    return group.from_parts(np.tile(axis, (len(places), 1, 1)), np.outer(places, axis[0]))


@given(masks)
def test_precision_one_way_is_recall_the_other_way(pair):
    a, b = pair
    assert precision_recall(a, b) == precision_recall(b, a)[::-1]


def test_keeping_nothing_makes_no_wrong_choice_and_finding_nothing_misses_nothing():
    assert precision_recall([False, False], [True, False]) == (1.0, 0.0)
    assert precision_recall([True, False], [False, False]) == (0.0, 1.0)
    assert precision_recall(np.array([], dtype=bool), np.array([], dtype=bool)) == (1.0, 1.0)


@seeds
def test_a_rigid_motion_of_the_whole_map_is_no_error_and_a_mirror_image_is_one(group, seed):
    truth = trajectory(seed, group)
    moved = group.compose(motion(group, seed), truth)
    assert ate(moved, truth) == pytest.approx(0.0, abs=1e-12)
    assert_same_poses(group, align(moved, truth), truth, atol=1e-12)
    mirror = np.ones(group.DIMENSION)
    mirror[0] = -1.0
    image = group.from_parts(group.rotation(truth), mirror * group.translation(truth))
    assert ate(image, truth) > 0.5
    np.testing.assert_allclose(np.linalg.det(group.rotation(align(image, truth))), 1.0)


def test_one_pose_and_poses_on_a_line_are_aligned(group):
    truth = placed(group, 0.0, 1.0, 3.0)
    move = motion(group, 3)
    assert ate(group.compose(move, truth), truth) == pytest.approx(0.0, abs=1e-12)
    assert ate(group.compose(move, truth[:1]), truth[:1]) == pytest.approx(0.0, abs=1e-12)


def path_of(poses, group):
    """The same way as a trajectory of evo, the plane lying in space."""
    from evo.core.trajectory import PosePath3D

    full = np.tile(np.eye(4), (len(poses), 1, 1))
    d = group.DIMENSION
    full[:, :d, :d], full[:, :d, 3] = group.rotation(poses), group.translation(poses)
    return PosePath3D(poses_se3=list(full))


def score(metric, estimate, truth):
    metric.process_data((truth, estimate))
    return float(np.sqrt(np.mean(np.square(metric.error))))


@pytest.fixture(scope="module")
def evo():
    try:
        from evo.core import metrics
    except ImportError:
        leave_out("evo is not installed: the errors are not compared with its own")
    return metrics


@seeds
def test_the_absolute_error_is_that_of_evo(evo, group, seed):
    truth = trajectory(seed, group, n=40)
    estimate = noisy(truth, group, seed)
    ours, theirs = path_of(estimate, group), path_of(truth, group)
    ours.align(theirs, correct_scale=False)
    expected = score(evo.APE(evo.PoseRelation.translation_part), ours, theirs)
    assert ate(estimate, truth) == pytest.approx(expected, rel=1e-9)


TRUTH = trajectory(1, se2)


@refused(
    ((precision_recall, [True], [True, False]), "true: the shape"),
    ((precision_recall, [1, 0], [True, False]), "kept: the entries"),
    ((precision_recall, [True, False], [0.0, 1.0]), "true: the entries"),
    ((ate, np.zeros((3, 3)), np.zeros((4, 3))), "estimate: the shape"),
    ((ate, np.zeros((3, 2)), np.zeros((3, 2))), "truth: the shape"),
    ((ate, np.zeros((3, 3, 3)), np.zeros((3, 3, 3))), "truth: the shape"),
    ((ate, np.zeros((3, 3)), np.tile(se3.identity(), (3, 1, 1))), "estimate: the shape"),
    ((ate, np.full((3, 3), np.nan), np.zeros((3, 3))), "estimate: the entry"),
    ((ate, np.zeros((0, 3)), np.zeros((0, 3))), "there are no poses"),
    (
        (nees, TRUTH, TRUTH, [4, 0], [np.eye(3), np.zeros((3, 3))]),
        "covariance: that of pose 0 is not posi",
    ),
    ((nees, TRUTH, TRUTH, 15, np.eye(3)), "k is 15; poses are 0 to 14"),
    (
        (nees, TRUTH, TRUTH, [1, 2], np.eye(3)),
        r"covariance: the shape is \(3, 3\); give \(2, 3, 3\)",
    ),
)
def test_bad_input_is_refused_by_name(wrong, message):
    score, *given = wrong
    with pytest.raises(ValueError, match=message):
        score(*given)


@pytest.mark.parametrize("group", [se2, se3])
def test_nees_is_the_whitened_error_in_the_frame_of_pose_0(group):
    rng = np.random.default_rng(0)
    estimate, error = trajectory(1, group), rng.normal(size=(15, group.DOF))
    error[0] = 0.0
    root = np.eye(group.DOF) + 0.2 * rng.normal(size=(15, group.DOF, group.DOF))
    shaken = group.compose(estimate, group.exp(0.3 * (root @ error[..., None])[..., 0]))
    truth = group.compose(motion(group, 2), shaken)
    k = np.array([[3, 14], [7, 1]])
    covariance = 0.09 * root[k] @ np.swapaxes(root[k], -1, -2)
    expected = np.sum(error[k] ** 2, axis=-1)
    np.testing.assert_allclose(nees(estimate, truth, k, covariance), expected, rtol=1e-8)
