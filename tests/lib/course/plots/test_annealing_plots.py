"""What drawings of graduated non-convexity show, read back from the axes."""

from __future__ import annotations

import numpy as np
import pytest
from robust_slam.estimators import kernels
from robust_slam.estimators.graduation import (
    gm_process,
    gm_surrogate,
    gm_weight,
    gnc,
    tls_surrogate,
    tls_weight,
)
from robust_slam.problems import LocationProblem
from robust_slam_course.plots.annealing import draw_family, draw_paths, draw_prices, draw_stage

Z = (-0.2, 0.1, 0.4, 10.0)
U = np.linspace(0.0, 8.0, 41)


def test_a_family_lies_over_the_cost_that_it_ends_at(ax) -> None:
    draw_family(ax, tls_surrogate, 2.0, (0.1, 1e6), U, kernels.tls(2.0).rho)
    band, soft, hard = ax.lines
    np.testing.assert_allclose(hard.get_ydata(), band.get_ydata(), atol=1e-6)
    np.testing.assert_allclose(soft.get_ydata(), tls_surrogate(U, 2.0, 0.1))
    assert soft.get_label() == "μ = 0.1"
    assert soft.get_color() != hard.get_color() != band.get_color()
    assert band.get_linewidth() > hard.get_linewidth()


def test_a_family_needs_no_end(ax) -> None:
    draw_family(ax, tls_weight, 2.0, (0.1, 1.0, 3.0), U)
    assert len(ax.lines) == 3


def test_the_marker_stands_at_the_lowest_price(ax) -> None:
    draw_prices(ax, gm_process, gm_weight, 2.0, 3.0, (0.0, 1.0, 4.0))
    for curve, marker in zip(ax.lines[::2], ax.lines[1::2], strict=True):
        (w,), (least,) = marker.get_data()
        assert least <= curve.get_ydata().min() + 1e-12
        assert abs(w - curve.get_xdata()[curve.get_ydata().argmin()]) <= 0.005


def test_a_move_stands_on_the_curve(ax) -> None:
    x = np.linspace(-3.0, 13.0, 161)
    draw_stage(ax, Z, x, gm_surrogate, 2.0, 5.0, (2.5, 0.1), sigma=0.5)
    curve, before, after = ax.lines[0], ax.lines[-2], ax.lines[-1]
    for point, at in ((before, 2.5), (after, 0.1)):
        assert point.get_xdata()[0] == at
        height = np.interp(at, x, curve.get_ydata())
        assert point.get_ydata()[0] == pytest.approx(height, abs=1e-9)
    assert before.get_marker() != after.get_marker()


def test_a_path_has_a_point_for_each_solve_and_none_for_the_start(ax) -> None:
    history = gnc(LocationProblem(Z), 2.0).history
    draw_paths(ax, {"one": history, "two": history})
    for line, name in zip(ax.lines, ("one", "two"), strict=True):
        np.testing.assert_array_equal(line.get_xdata(), [step.mu for step in history[1:]])
        np.testing.assert_array_equal(line.get_ydata(), [step.x for step in history[1:]])
        assert line.get_label() == name
    assert ax.lines[0].get_marker() != ax.lines[1].get_marker()
    assert ax.get_xscale() == "log"
