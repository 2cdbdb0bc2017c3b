"""What is drawn of an estimate is what the history holds."""

from __future__ import annotations

import numpy as np
import pytest
from robust_slam.estimators.kernels import KERNELS, cauchy, tls
from robust_slam.estimators.reweighting import irls
from robust_slam.problems import LocationProblem
from robust_slam_course.plots import location as plots

Z, SIGMA = np.array([0.1, -0.2, 0.15, -0.1, 5.0]), 0.3
IS_LIE = np.array([False, False, False, False, True])
RESULT = irls(LocationProblem(Z, SIGMA), cauchy(1.0))
GRID = np.linspace(-1, 6, 141)


def test_the_area_of_a_disc_is_its_weight(ax):
    weights = np.array([1.0, 0.5, 0.25, 0.0, 0.1])
    drawn = plots.draw_weights(ax, Z, weights, 0.3, IS_LIE)
    rings_in, discs_in, rings_out, discs_out = drawn.collections
    np.testing.assert_allclose(discs_in.get_sizes(), plots.FULL_AREA * weights[:4])
    np.testing.assert_allclose(discs_out.get_sizes(), plots.FULL_AREA * weights[4:])
    assert set(rings_in.get_sizes()) == set(rings_out.get_sizes()) == {plots.FULL_AREA}


def test_readings_stand_at_their_value_and_apart_from_each_other(ax):
    drawn = plots.draw_weights(ax, Z, np.ones(5), 0.3, IS_LIE, height=2.0)
    offsets = np.vstack([drawn.collections[0].get_offsets(), drawn.collections[2].get_offsets()])
    np.testing.assert_allclose(offsets[:, 0], Z)
    assert np.all(np.diff(offsets[:, 1]) < -0.1)
    assert offsets[:, 1].mean() == pytest.approx(2.0)
    assert list(drawn.lines[0].get_xdata()) == [0.3, 0.3]


def test_inliers_and_outliers_differ_by_shape_as_well(ax):
    rings_in, _, rings_out, _ = plots.draw_weights(ax, Z, np.ones(5), 0.0, IS_LIE).collections
    assert len(rings_in.get_paths()[0].vertices) != len(rings_out.get_paths()[0].vertices)


def test_weights_are_printed_on_the_level_of_their_reading(ax):
    drawn = plots.label_weights(ax, [1.0, 0.25], height=0.0, spread=1.0)
    assert [(t.get_text(), t.get_position()[1]) for t in drawn.texts[1:]] == [
        ("1.0000", 0.5),
        ("0.2500", -0.5),
    ]


def test_a_row_shows_the_weights_and_the_estimate_of_its_step(ax):
    drawn = plots.draw_reweighting(ax, Z, RESULT.history, (0, 1), IS_LIE)
    assert [t.get_text() for t in drawn.texts] == ["x = 0.9900", "x = 0.1026"]
    assert [t.get_text() for t in drawn.get_yticklabels()] == ["step 0", "step 1"]
    sizes = drawn.collections[5].get_sizes()
    np.testing.assert_allclose(sizes, plots.FULL_AREA * RESULT.history[1].weights[:4])


def test_the_landscape_is_the_robust_cost(ax):
    fine = np.linspace(-1, 6, 1401)
    (line,) = plots.draw_landscape(ax, Z, SIGMA, cauchy(1.0), fine).lines
    at = np.interp([step.x for step in RESULT.history], *line.get_data())
    np.testing.assert_allclose(at, [step.cost for step in RESULT.history], atol=1e-3)


@pytest.mark.parametrize("make", KERNELS.values(), ids=KERNELS.keys())
def test_the_parabola_of_a_step_is_above_the_cost_and_lowest_at_the_next_x(ax, make):
    kernel = make(4.0)
    path = irls(LocationProblem(Z, SIGMA), kernel).history
    drawn = plots.draw_landscape(ax, Z, SIGMA, kernel, GRID, at=path[0].x)
    cost, parabola, touch, lowest = drawn.lines
    assert np.all(parabola.get_ydata() >= cost.get_ydata() - 1e-9)
    assert float(touch.get_ydata()[0]) == pytest.approx(path[0].cost)
    assert float(lowest.get_xdata()[0]) == pytest.approx(path[1].x)
    assert float(lowest.get_ydata()[0]) == pytest.approx(parabola.get_ydata().min(), abs=0.2)


def test_without_any_weight_the_parabola_is_flat_and_has_no_lowest_point(ax):
    drawn = plots.draw_landscape(ax, Z, SIGMA, tls(1.0), GRID, at=0.99)
    assert len(drawn.lines) == 3
    assert np.ptp(drawn.lines[1].get_ydata()) == 0.0


def test_a_descent_begins_and_ends_where_the_history_does(ax):
    _, start, end = plots.draw_descent(ax, RESULT.history).lines
    assert float(start.get_xdata()[0]) == RESULT.history[0].x
    assert float(end.get_ydata()[0]) == RESULT.cost


def test_the_line_of_convergence_shrinks_by_the_rate_and_ends_on_the_last_error(ax):
    errors = [1.0, 0.6, 0.2, 0.1]
    points, line = plots.draw_convergence(ax, errors, rate=0.5).lines
    np.testing.assert_allclose(points.get_ydata(), errors)
    np.testing.assert_allclose(line.get_ydata(), [0.8, 0.4, 0.2, 0.1])
