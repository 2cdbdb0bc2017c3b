"""Precision, recall and the error of a trajectory."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from robust_slam import se2
from robust_slam.metrics import align, ate, precision_recall

masks = st.integers(1, 12).flatmap(
    lambda n: st.tuples(*[st.lists(st.booleans(), min_size=n, max_size=n)] * 2)
)


def trajectory(seed, n=15):
    return np.random.default_rng(seed).uniform(-5.0, 5.0, size=(n, 3)) * [1.0, 1.0, 0.6]


def test_three_kept_of_which_two_are_true_out_of_four_true():
    kept = [True, True, True, False, False, False]
    true = [True, True, False, True, True, False]
    assert precision_recall(kept, true) == (2 / 3, 2 / 4)


@given(masks)
def test_precision_one_way_is_recall_the_other_way(pair):
    a, b = pair
    assert precision_recall(a, b) == precision_recall(b, a)[::-1]


@given(masks)
def test_both_are_1_only_when_the_choice_is_right(pair):
    kept, true = pair
    if any(kept) or any(true):
        assert (precision_recall(kept, true) == (1.0, 1.0)) == (kept == true)


def test_keeping_nothing_makes_no_wrong_choice_and_finding_nothing_misses_nothing():
    assert precision_recall([False, False], [True, False]) == (1.0, 0.0)
    assert precision_recall([True, False], [False, False]) == (0.0, 1.0)
    assert precision_recall(np.array([], dtype=bool), np.array([], dtype=bool)) == (1.0, 1.0)


@pytest.mark.parametrize(
    ("kept", "true", "told"),
    [
        ([True], [True, False], "true: the shape"),
        ([1, 0], [True, False], "kept: the entries"),
        ([True, False], [0.0, 1.0], "true: the entries"),
    ],
)
def test_masks_that_are_no_masks_are_refused(kept, true, told):
    with pytest.raises(ValueError, match=told):
        precision_recall(kept, true)


def test_stretched_to_double_length_by_hand():
    truth = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]]
    assert ate([[0.0, 0.0, 0.0], [4.0, 0.0, 0.0]], truth) == pytest.approx(1.0)


@pytest.mark.parametrize("seed", range(4))
def test_a_rigid_motion_of_the_whole_map_is_no_error(seed):
    truth = trajectory(seed)
    moved = se2.compose([4.0, -30.0, 2.9 - seed], truth)
    assert ate(moved, truth) == pytest.approx(0.0, abs=1e-12)
    back = align(moved, truth)
    np.testing.assert_allclose(back[:, :2], truth[:, :2], atol=1e-12)
    np.testing.assert_allclose(se2.wrap(back[:, 2] - truth[:, 2]), 0.0, atol=1e-12)


def test_a_change_of_scale_is_an_error():
    truth = trajectory(5)
    spread = np.sqrt(np.mean(np.sum((truth[:, :2] - truth[:, :2].mean(axis=0)) ** 2, axis=1)))
    assert ate(truth * [3.0, 3.0, 1.0], truth) == pytest.approx(2.0 * spread, rel=1e-12)


def test_a_mirror_image_is_an_error():
    truth = trajectory(6)
    assert ate(truth * [1.0, -1.0, -1.0], truth) > 0.5


def test_the_error_does_not_change_when_either_map_is_moved():
    estimate, truth = trajectory(7), trajectory(8)
    expected = ate(estimate, truth)
    assert ate(se2.compose([1.0, 2.0, 3.0], estimate), truth) == pytest.approx(expected)
    assert ate(estimate, se2.compose([1.0, 2.0, 3.0], truth)) == pytest.approx(expected)


def test_headings_are_not_judged():
    truth = trajectory(9)
    turned = truth + np.array([0.0, 0.0, 1.0])
    assert ate(turned, truth) == pytest.approx(0.0, abs=1e-12)


def test_no_other_rigid_motion_fits_better():
    estimate, truth = trajectory(10), trajectory(11)
    best = align(estimate, truth)
    rng = np.random.default_rng(12)

    def error(poses):
        return np.sum((poses[:, :2] - truth[:, :2]) ** 2)

    for size in (1e-3, 1e-1, 1.0):
        for motion in size * rng.normal(size=(20, 3)):
            assert error(best) < error(se2.compose(motion, best))


@pytest.mark.parametrize(
    ("estimate", "truth", "told"),
    [
        (np.zeros((3, 3)), np.zeros((4, 3)), "estimate: the shape"),
        (np.zeros((3, 2)), np.zeros((3, 2)), "truth: the shape"),
        (np.full((3, 3), np.nan), np.zeros((3, 3)), "estimate: the entry"),
        (np.zeros((0, 3)), np.zeros((0, 3)), "there are no poses"),
    ],
)
def test_bad_input_is_refused_by_name(estimate, truth, told):
    with pytest.raises(ValueError, match=told):
        ate(estimate, truth)
