"""What drawn switches and modes show, read back from the axes."""

from __future__ import annotations

import numpy as np
import pytest
from robust_slam.estimators.mixtures import NullHypothesis
from robust_slam_course.plots.switches import draw_modes, draw_switch_costs, draw_switches


def test_the_marker_stands_at_the_lowest_point_of_its_curve(ax) -> None:
    draw_switch_costs(ax, (1.0, 9.0), lam=1.0)
    curves, markers = ax.lines[::2], ax.lines[1::2]
    for curve, marker in zip(curves, markers, strict=True):
        s, cost = (np.asarray(values) for values in curve.get_data())
        at, lowest = (float(values[0]) for values in marker.get_data())
        assert at == pytest.approx(s[cost.argmin()], abs=0.005)
        assert lowest == pytest.approx(cost.min(), abs=1e-3)
    assert [curve.get_label() for curve in curves] == ["χ² = 1", "χ² = 9"]
    assert markers[0].get_marker() != markers[1].get_marker()


def test_each_switch_is_a_stem_under_its_name_and_lies_are_crosses(ax) -> None:
    draw_switches(ax, [1.0, 0.25, 0.5], [False, True, False], "ABC")
    honest, lies = ax.lines
    np.testing.assert_array_equal(honest.get_xydata(), [[0.0, 1.0], [2.0, 0.5]])
    np.testing.assert_array_equal(lies.get_xydata(), [[1.0, 0.25]])
    assert honest.get_marker() != lies.get_marker()
    tops = [path.vertices[1].tolist() for stems in ax.collections for path in stems.get_paths()]
    assert tops == [[0.0, 1.0], [2.0, 0.5], [1.0, 0.25]]
    assert [label.get_text() for label in ax.get_xticklabels()] == ["A", "B", "C"]


@pytest.mark.parametrize(("switches", "lies"), [([1.0], [False, True]), ([1.0, 0.0], [True])])
def test_switches_and_marks_fit_the_names(ax, switches: list, lies: list) -> None:
    with pytest.raises(ValueError, match=r"switches|is_outlier"):
        draw_switches(ax, switches, lies, "AB")


def test_the_modes_cross_at_the_switch(ax) -> None:
    rule = NullHypothesis(0.9, 10.0, 1)
    draw_modes(ax, rule, u_max=5.0)
    lower, inlier, outlier, switch = (np.asarray(line.get_ydata()) for line in ax.lines)
    np.testing.assert_array_equal(lower, np.minimum(inlier, outlier))
    u = np.asarray(ax.lines[1].get_xdata())
    crossing = float(np.interp(0.0, inlier - outlier, u))
    assert float(ax.lines[3].get_xdata()[0]) == pytest.approx(crossing, abs=1e-3)
    assert float(switch[0]) == pytest.approx(crossing**2 / 2, abs=1e-2)
    assert "3.015" in str(ax.lines[3].get_label())
