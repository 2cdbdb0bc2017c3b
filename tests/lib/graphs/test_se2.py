"""What is particular to SE(2): angles, and motions that one can draw."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from robust_slam.graphs import se2

from tests.lib.worlds import assert_same_poses


def test_turning_left_by_hand():
    ahead_and_left = [1.0, 0.0, np.pi / 2]
    assert_same_poses(
        se2, se2.compose(ahead_and_left, ahead_and_left), np.array([1.0, 1.0, np.pi]), 1e-15
    )


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
