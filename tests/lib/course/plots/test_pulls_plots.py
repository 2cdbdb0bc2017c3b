"""What drawn fits and pulls show, read back from the axes."""

from __future__ import annotations

import numpy as np
import pytest
from robust_slam.estimators import kernels
from robust_slam_course.plots.kernels import kernel_look
from robust_slam_course.plots.pulls import draw_line_fit, draw_pull_ends, draw_pulls

P, Y = np.array([0.0, 1.0, 4.0]), np.array([1.0, 2.0, 9.0])
IS_LIE = np.array([False, False, True])


def test_the_fit_and_the_truth_are_lines_over_all_places(ax) -> None:
    draw_line_fit(ax, P, Y, (1.0, 0.5), (2.0, 0.25), IS_LIE)
    lines = {line.get_label(): line for line in ax.lines}
    np.testing.assert_allclose(lines["fit"].get_xydata(), [[0, 1], [4, 3]])
    np.testing.assert_allclose(lines["truth"].get_xydata(), [[0, 2], [4, 3]])
    assert lines["fit"].get_linestyle() != lines["truth"].get_linestyle()


def test_an_outlier_differs_from_the_inliers_in_marker_and_colour(ax) -> None:
    draw_line_fit(ax, P, Y, (1.0, 0.5), (2.0, 0.25), IS_LIE)
    lines = {line.get_label(): line for line in ax.lines}
    np.testing.assert_allclose(lines["inlier"].get_xydata(), [[0, 1], [1, 2]])
    np.testing.assert_allclose(lines["outlier"].get_xydata(), [[4, 9]])
    assert lines["inlier"].get_marker() != lines["outlier"].get_marker()
    assert lines["inlier"].get_color() != lines["outlier"].get_color()


def test_a_residual_leads_from_the_fit_to_its_reading(ax) -> None:
    draw_line_fit(ax, P, Y, (1.0, 0.5), (2.0, 0.25), IS_LIE)
    segments = [s for group in ax.collections for s in group.get_segments()]
    want = [[[0, 1], [0, 1]], [[1, 1.5], [1, 2]], [[4, 3], [4, 9]]]
    np.testing.assert_allclose(segments, want)


def test_a_bar_is_as_high_as_its_pull_and_a_lie_is_hatched(ax) -> None:
    draw_pulls(ax, P, [0.5, -2.0, 1.345], IS_LIE)
    bars = {bar.get_x() + bar.get_width() / 2: bar for bar in ax.patches}
    assert {at: bar.get_height() for at, bar in bars.items()} == {0.0: 0.5, 1.0: -2.0, 4.0: 1.345}
    assert [bool(bars[at].get_hatch()) for at in (0.0, 1.0, 4.0)] == [False, False, True]


@pytest.mark.parametrize(("pull", "printed", "height"), [(1.5, "1.500", 1.5), (-2.0, "−2.000", 0)])
def test_a_lie_s_pull_is_printed_above_its_bar(
    pull: float, printed: str, height: float, ax
) -> None:
    draw_pulls(ax, P, [0.5, -2.0, pull], IS_LIE)
    (text,) = ax.texts
    assert text.get_text() == printed
    assert text.get_position() == (4.0, height)


def test_pulls_need_one_number_for_each_place(ax) -> None:
    with pytest.raises(ValueError, match="pulls"):
        draw_pulls(ax, P, [1.0, 2.0], IS_LIE)


@pytest.mark.parametrize(("name", "slope"), [("squared", 1), ("huber", 0), ("cauchy", -1)])
def test_far_out_a_pull_is_a_straight_line(name: str, slope: int, ax) -> None:
    draw_pull_ends(ax, [kernels.KERNELS[name](2.0)], (-1, 6))
    u, pull = ax.lines[0].get_data()
    assert (u[0], u[-1]) == pytest.approx((0.1, 1e6))
    steep = np.log10(pull[-1] / pull[-41])
    assert steep == pytest.approx(slope, abs=1e-3)
    assert (ax.get_xscale(), ax.get_yscale()) == ("log", "log")


def test_a_pull_of_zero_is_left_out(ax) -> None:
    kernel = kernels.tls(2.0)
    draw_pull_ends(ax, [kernel], (-1, 3))
    assert ax.lines[0].get_xdata().max() <= 2.0
    assert ax.lines[0].get_color() == kernel_look("tls").color
