"""What a drawn growth shows, read back from the axes."""

from __future__ import annotations

import numpy as np
import pytest
from robust_slam_course.plots.growth import draw_growth, fitted_exponent

SIZES = [10.0, 100.0, 1000.0]


def test_the_exponent_of_a_power_law_is_found() -> None:
    assert fitted_exponent(SIZES, 3.0 * np.array(SIZES) ** 1.5) == pytest.approx(1.5, abs=1e-12)


def test_the_exponent_is_the_least_squares_slope_of_the_logarithms() -> None:
    # By hand, in powers of ten: heights 0, 2, 2 over 1, 2, 3 have the slope (2 − 0)/2.
    assert fitted_exponent(SIZES, [1.0, 100.0, 100.0]) == pytest.approx(1.0, abs=1e-12)


def test_points_and_the_fitted_line_are_drawn_over_logarithmic_axes(ax) -> None:
    draw_growth(ax, SIZES, 2.0 * np.array(SIZES) ** 1.25)
    law, points = ax.lines
    assert ax.get_xscale() == ax.get_yscale() == "log"
    assert points.get_xdata().tolist() == SIZES
    assert law.get_label() == "∝ $n^{1.25}$"
    assert law.get_ydata() == pytest.approx(2.0 * np.array([10.0, 1000.0]) ** 1.25)


def test_line_and_points_differ_in_more_than_colour(ax) -> None:
    draw_growth(ax, SIZES, SIZES)
    law, points = ax.lines
    assert (law.get_linestyle(), law.get_marker()) == ("--", "None")
    assert (points.get_linestyle(), points.get_marker()) == ("None", "o")


@pytest.mark.parametrize(
    ("sizes", "costs", "told"),
    [
        ([1.0], [1.0], "at least 2"),
        ([1.0, 2.0], [1.0], "costs"),
        ([1.0, 2.0], [0.0, 1.0], "above"),
    ],
)
def test_what_has_no_power_law_is_refused(
    ax, sizes: list[float], costs: list[float], told: str
) -> None:
    with pytest.raises(ValueError, match=told):
        draw_growth(ax, sizes, costs)
