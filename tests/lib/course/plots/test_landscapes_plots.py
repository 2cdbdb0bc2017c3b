"""What a drawn graduation shows, read back from the axes."""

from __future__ import annotations

import numpy as np
import pytest
from robust_slam.estimators.graduation import gm_surrogate, tls_surrogate
from robust_slam.estimators.kernels import geman_mcclure
from robust_slam_course.plots.landscapes import draw_graduation, minima

Z = (-0.2, 0.1, 0.4, 10.0)
X = np.linspace(-4.0, 14.0, 3601)


def test_one_curve_and_its_minima_for_each_mu(ax) -> None:
    draw_graduation(ax, Z, X, tls_surrogate, 2.0, (1e-3, 50.0))
    first, low_first, last, low_last, _ = ax.lines
    assert (first.get_label(), last.get_label()) == ("μ = 0.001", "μ = 50")
    assert len(low_first.get_xdata()) == 1
    np.testing.assert_allclose(low_last.get_xdata(), [0.1, 10.0], atol=0.006)
    assert first.get_linestyle() != last.get_linestyle()


def test_a_curve_is_the_summed_surrogate_up_to_its_scale(ax) -> None:
    draw_graduation(ax, Z, X, gm_surrogate, 2.0, (10.0,), sigma=0.5)
    cost = sum(gm_surrogate((X - z) / 0.5, 2.0, 10.0) for z in Z)
    np.testing.assert_allclose(ax.lines[0].get_ydata(), cost / cost.max(), rtol=1e-12)


def test_at_mu_one_the_surrogate_lies_on_the_kernel_it_hardens_into(ax) -> None:
    draw_graduation(ax, Z, X, gm_surrogate, 2.0, (1.0,), kernel=geman_mcclure(2.0))
    curve, _, band, _ = ax.lines
    np.testing.assert_allclose(curve.get_ydata(), band.get_ydata(), rtol=1e-12)
    assert band.get_label() == "Geman–McClure"
    assert band.get_linewidth() > curve.get_linewidth()
    assert band.get_zorder() < curve.get_zorder()


def test_more_curves_than_looks_are_refused(ax) -> None:
    with pytest.raises(ValueError, match="mus: there are 9; give at most 8"):
        draw_graduation(ax, Z, X, gm_surrogate, 2.0, range(1, 10))


@pytest.mark.parametrize(
    ("values", "places"),
    [
        ([3, 2, 1, 2, 3], [2]),
        ([1, 2, 3], []),
        ([3, 1, 3, 0, 3], [1, 3]),
        ([3, 1, 1, 1, 3], [2]),
        ([3, 1, 1, 0, 3], [3]),
        ([1, 1, 1], []),
        ([0, 0, 1, 0, 0], []),
    ],
)
def test_a_minimum_rises_on_both_sides(values: list[int], places: list[int]) -> None:
    assert minima(values).tolist() == places
