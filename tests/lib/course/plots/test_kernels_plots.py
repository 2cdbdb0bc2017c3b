"""The curves that are drawn are the kernels' own."""

from __future__ import annotations

import numpy as np
import pytest
from robust_slam.estimators.kernels import KERNELS, cauchy, huber, tls
from robust_slam.estimators.thresholds import chi_square_threshold
from robust_slam_course.plots import kernels as plots
from scipy.integrate import trapezoid

ALL = [make(1.5) for make in KERNELS.values()]


@pytest.mark.parametrize("kernel", ALL, ids=lambda kernel: kernel.name)
@pytest.mark.parametrize(
    ("draw", "curve"), [(plots.draw_costs, "rho"), (plots.draw_influences, "psi")]
)
def test_a_curve_holds_the_kernels_values(ax, kernel, draw, curve):
    (line,) = draw(ax, [kernel], u_max=6.0).lines
    u, values = line.get_data()
    drawn = np.isfinite(values)
    np.testing.assert_array_equal(values[drawn], getattr(kernel, curve)(u)[drawn])
    assert u[0] == 0.0 and u[-1] == 6.0
    assert np.all(np.diff(u) <= 6.0 / 40)


@pytest.mark.parametrize("kernel", ALL, ids=lambda kernel: kernel.name)
def test_the_line_breaks_at_a_jump_and_nowhere_else(ax, kernel):
    (line,) = plots.draw_influences(ax, [kernel], u_max=6.0).lines
    gaps = np.isnan(line.get_ydata())
    assert gaps.sum() == (1 if kernel.name == "tls" else 0)
    assert np.allclose(line.get_xdata()[gaps], kernel.scale, rtol=1e-6)


def test_the_mark_stands_on_every_curve(ax):
    drawn = plots.draw_influences(ax, ALL, u_max=6.0, mark=2.0)
    marks = [line for line in drawn.lines if len(line.get_xdata()) == 1]
    assert [float(line.get_ydata()[0]) for line in marks] == [float(k.psi(2.0)) for k in ALL]


def test_curvature_is_marked_where_convexity_ends(ax):
    drawn = plots.draw_curvatures(ax, [huber(1.0), cauchy(1.0), tls(1.0)], u_max=4.0)
    marks = [line for line in drawn.lines if len(line.get_xdata()) == 1]
    at = [(float(line.get_xdata()[0]), float(line.get_ydata()[0])) for line in marks]
    assert at[0] == pytest.approx((1.0, 0.0), abs=1e-5)
    assert at[1] == pytest.approx((1.0, 1.0), abs=1e-5)
    assert len(at) == 2


def test_curvature_of_cauchy_follows_the_formula(ax):
    (line, _, _) = plots.draw_curvatures(ax, [cauchy(1.0)], u_max=4.0).lines
    u, values = line.get_data()
    np.testing.assert_allclose(values, (1 - u**2) / (1 + u**2) ** 2, atol=1e-5)


@pytest.mark.parametrize("kernel", ALL, ids=lambda kernel: kernel.name)
@pytest.mark.parametrize("touch", [0.5, 3.0])
def test_the_majoriser_touches_and_lies_above(ax, kernel, touch):
    cost, parabola, points = plots.draw_majoriser(ax, kernel, touch, u_max=6.0).lines
    assert np.all(parabola.get_ydata() >= cost.get_ydata() - 1e-12)
    np.testing.assert_allclose(points.get_ydata(), kernel.rho(touch))
    at = np.interp(touch, parabola.get_xdata(), parabola.get_ydata())
    assert at == pytest.approx(float(kernel.rho(touch)), abs=1e-3)


def test_the_threshold_lines_keep_their_share_of_the_density(ax):
    drawn = plots.draw_norm_densities(ax, (1, 3, 6), probability=0.9)
    for d, density, wall in zip((1, 3, 6), drawn.lines[::2], drawn.lines[1::2], strict=True):
        threshold = float(wall.get_xdata()[0])
        assert threshold == chi_square_threshold(0.9, d)
        u, p = density.get_data()
        assert trapezoid(np.where(u <= threshold, p, 0.0), u) == pytest.approx(0.9, abs=0.02)
    assert [text.get_text() for text in drawn.texts] == ["1.64", "2.50", "3.26"]


def test_drift_draws_one_line_for_each_kernel(ax):
    drawn = plots.draw_drift(ax, [0.0, 1.0], {"huber": [0.0, 0.1], "tls": [0.0, 0.0]})
    assert [line.get_label() for line in drawn.lines] == ["Huber", "TLS"]
    assert len({line.get_linestyle() for line in drawn.lines}) == 2 or (
        drawn.lines[0].get_color() != drawn.lines[1].get_color()
    )
