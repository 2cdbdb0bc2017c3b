"""What is drawn of the ends of descents, read back from the axes."""

from __future__ import annotations

import numpy as np
import pytest
from robust_slam.estimators.kernels import cauchy, tls
from robust_slam_course.plots import basins

CROWD = np.append(np.zeros(20), 10.0)


def test_an_end_is_in_a_well_or_the_start_itself(ax) -> None:
    starts = np.linspace(-2.9, 12.9, 80)
    descends, stays = basins.draw_ends(ax, CROWD, tls(2.0), starts).lines
    ends = np.asarray(descends.get_ydata())
    assert set(np.unique(ends[~np.isnan(ends)])) == {0.0, 10.0}
    still = np.asarray(stays.get_ydata())
    drawn = ~np.isnan(still)
    np.testing.assert_array_equal(still[drawn], starts[drawn])
    assert np.all(np.minimum(np.abs(starts), np.abs(starts - 10.0))[drawn] > 2.0)
    assert drawn.sum() > 20
    assert descends.get_linestyle() != stays.get_linestyle()


def test_the_line_is_broken_where_the_end_jumps(ax) -> None:
    starts = np.linspace(0.0, 10.0, 41)
    descends, _ = basins.draw_ends(ax, [0.0, 10.0], cauchy(1.0), starts).lines
    ends = np.asarray(descends.get_ydata())
    moved = np.abs(np.diff(ends))
    assert np.all(moved[~np.isnan(moved)] < 1e-6)
    assert np.isnan(ends).any()


def test_every_point_of_the_fork_is_stationary(ax) -> None:
    low, high, merged, top = basins.draw_fork(ax, 10.0, 8.0).lines
    for line in (low, high, merged, top):
        for c, x in np.column_stack([line.get_xdata(), line.get_ydata()])[1:]:
            slope = cauchy(max(c, 1e-9)).psi(x - np.array([0.0, 10.0])).sum()
            assert slope == pytest.approx(0.0, abs=1e-9)
    assert [low.get_label(), top.get_label()] == ["minimum", "maximum"]
    assert merged.get_xdata()[0] == 5.0


def test_minima_and_maxima_of_the_fork_are_what_they_are_called(ax) -> None:
    low, _, merged, top = basins.draw_fork(ax, 10.0, 8.0).lines
    for line, at, sign in ((low, 45, 1), (merged, 1, 1), (top, 0, -1)):
        kernel = cauchy(max(float(line.get_xdata()[at]), 1.0))
        x = float(line.get_ydata()[at])
        here, aside = (kernel.rho(place - np.array([0.0, 10.0])).sum() for place in (x, x + 0.01))
        assert sign * (aside - here) > 0.0


def test_a_ring_costs_nothing_untwisted_and_more_with_every_turn(ax) -> None:
    curve, minima = basins.draw_twist(ax, 5, np.linspace(-0.5, 2.5, 301)).lines
    np.testing.assert_array_equal(minima.get_xdata(), [0.0, 1.0, 2.0])
    expected = [0.0, 0.4 * np.pi**2, 1.6 * np.pi**2]
    np.testing.assert_allclose(minima.get_ydata(), expected, atol=1e-12)
    cost = np.asarray(curve.get_ydata())
    for turn in minima.get_xdata():
        at = int(np.argmin(np.abs(np.asarray(curve.get_xdata()) - turn)))
        assert cost[at] < min(cost[at - 5], cost[at + 5])


def test_a_ring_of_two_is_refused(ax) -> None:
    with pytest.raises(ValueError, match="n is 2; give at least 3 headings"):
        basins.draw_twist(ax, 2, [0.0, 1.0])
