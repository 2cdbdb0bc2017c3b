"""What drawn switches and modes show, read back from the axes."""

from __future__ import annotations

import numpy as np
import pytest
from robust_slam.estimators.mixtures import NullHypothesis
from robust_slam_course.plots.switches import draw_modes, draw_switch_costs


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
