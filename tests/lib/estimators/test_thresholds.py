"""The threshold is on the norm of a residual, not on its square."""

from __future__ import annotations

import pytest
from robust_slam.estimators.thresholds import chi_square_threshold


@pytest.mark.parametrize(
    ("dimension", "norm"), [(1, 2.575829304), (3, 3.368214175), (6, 4.100230949)]
)
def test_the_norms_that_99_percent_stay_below(dimension, norm):
    assert chi_square_threshold(0.99, dimension) == pytest.approx(norm, rel=1e-9)


@pytest.mark.parametrize("probability", [0.0, 1.0, -0.1, 99.0, float("nan")])
def test_a_probability_outside_the_open_unit_interval_is_refused(probability):
    with pytest.raises(ValueError, match="probability"):
        chi_square_threshold(probability, 3)


@pytest.mark.parametrize("dimension", [0, -1, 1.5])
def test_a_dimension_that_is_no_count_is_refused(dimension):
    with pytest.raises(ValueError, match="dimension"):
        chi_square_threshold(0.99, dimension)
