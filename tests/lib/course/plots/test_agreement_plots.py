"""What a drawn table of agreement shows, read back from the axes."""

from __future__ import annotations

import numpy as np
import pytest
from robust_slam_course.plots.agreement import draw_agreement

# Closures 0 and 2 are inliers and agree, 1 and 3 are outliers; 2 agrees with 3 as well.
AGREES = np.eye(4, dtype=bool)
AGREES[[0, 2, 2, 3], [2, 0, 3, 2]] = True
LIES = [False, True, False, True]


def test_pairs_are_filled_with_the_inliers_first(ax) -> None:
    draw_agreement(ax, AGREES, LIES, [0, 2])
    pairs, rings = (set(map(tuple, each.get_offsets().tolist())) for each in ax.collections)
    assert pairs == {(0, 1), (1, 0), (1, 3), (3, 1)}
    assert rings == {(0, 0), (1, 1)}


def test_a_line_parts_inliers_from_outliers_both_ways(ax) -> None:
    draw_agreement(ax, AGREES, LIES, [0, 2])
    across, down = ax.lines
    assert set(across.get_ydata()) == {1.5}
    assert set(down.get_xdata()) == {1.5}
    assert ax.yaxis_inverted()


def test_arrays_that_do_not_fit_are_refused(ax) -> None:
    with pytest.raises(ValueError, match="adjacency"):
        draw_agreement(ax, AGREES[:3, :3], LIES, [0])
