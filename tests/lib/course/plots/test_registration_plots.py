"""What the drawn scans and matches show, read back from the axes."""

from __future__ import annotations

import numpy as np
import pytest
from robust_slam_course.plots.registration import draw_matches, draw_scans, seen

FIRST = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 3.0]])
SECOND = FIRST + np.array([5.0, 0.0, 0.0])


def test_up_is_up_and_parallels_stay_parallel() -> None:
    ground, east, north, above = seen([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    np.testing.assert_array_equal(ground, [0, 0])
    assert above[0] == 0.0 and above[1] > 0.9
    assert east[0] > 0.8 and north[1] > 0.0
    np.testing.assert_allclose(seen(SECOND) - seen(FIRST), np.tile(5 * east, (3, 1)))


def test_the_scans_have_markers_of_their_own(ax) -> None:
    draw_scans(ax, FIRST, SECOND)
    one, two = ax.lines
    np.testing.assert_array_equal(one.get_xydata(), seen(FIRST))
    np.testing.assert_array_equal(two.get_xydata(), seen(SECOND))
    assert one.get_marker() != two.get_marker() and one.get_color() != two.get_color()


def test_matches_are_counted_and_right_ones_look_different(ax) -> None:
    draw_matches(ax, FIRST, SECOND, is_outlier=[True, False, True])
    lines = {line.get_label(): line for line in ax.lines}
    assert set(lines) == {"wrong (2)", "right (1)"}
    wrong, right = lines["wrong (2)"], lines["right (1)"]
    assert wrong.get_linestyle() != right.get_linestyle()
    assert wrong.get_color() != right.get_color()
    assert wrong.get_linewidth() < right.get_linewidth()
    ends = seen([FIRST[1], SECOND[1]])
    np.testing.assert_array_equal(np.asarray(right.get_xydata())[:2], ends)
    assert np.isnan(np.asarray(wrong.get_xydata())[[2, 5]]).all()


def test_many_wrong_matches_are_faint(ax) -> None:
    draw_matches(ax, np.zeros((99, 3)), np.ones((99, 3)), is_outlier=[True] * 99)
    draw_matches(ax, FIRST, SECOND, is_outlier=[True] * 3)
    many, few = ax.lines
    assert many.get_linewidth() < few.get_linewidth() and many.get_alpha() < few.get_alpha()


def test_a_kind_without_matches_has_no_line(ax) -> None:
    draw_matches(ax, FIRST, SECOND, is_outlier=[False] * 3)
    assert [line.get_label() for line in ax.lines] == ["right (3)"]


def test_shapes_that_do_not_agree_are_refused(ax) -> None:
    with pytest.raises(ValueError, match="second: the shape"):
        draw_matches(ax, FIRST, SECOND[:2], is_outlier=[False] * 3)
    with pytest.raises(ValueError, match="is_outlier: the shape"):
        draw_matches(ax, FIRST, SECOND, is_outlier=[False])
    with pytest.raises(ValueError, match="points: the shape"):
        draw_scans(ax, FIRST[:, :2], SECOND)
