"""The table of NEES: its band, what it counts, and maps of which nothing is claimed."""

import numpy as np
import pytest

from benchmarks import nees
from benchmarks.nees import Row


def test_the_band_is_that_of_the_chi_square_distribution():
    # From a table: χ² with 10 degrees of freedom is between 3.247 and 20.483 in 95 % of all cases.
    assert nees.band(10, 1) == pytest.approx((3.247, 20.483), abs=1e-3)
    assert nees.band(5, 2) == pytest.approx((3.247 / 2, 20.483 / 2), abs=1e-3)
    low, high = nees.band(3, 20_000)
    assert (high - low) / 2 == pytest.approx(1.96 * np.sqrt(6 / 20_000), rel=1e-3)


@pytest.mark.parametrize("setting", nees.SETTINGS[:3], ids=lambda setting: setting.name)
def test_a_row_has_the_errors_of_its_worlds(setting):
    row = nees.measure(setting, 4, seed=7)
    assert row.freedom == (6 if "sphere" in setting.name else 3)
    assert np.all(row.unique) and row.kept == 0
    again = nees.measure(setting, 2, seed=9)
    np.testing.assert_array_equal(again.drawn, row.drawn[2:])
    assert 0.2 < np.mean([row.drawn, row.far]) / row.freedom < 3.0


def test_maps_without_unique_support_are_in_the_last_column_alone():
    unique = np.array([True, True, False])
    row = Row(nees.SETTINGS[3], np.array([2.0, 4.0, 60.0]), np.full(3, 1.0), unique, 3, 5, 1.25)
    cells = nees.line(row)[len(nees.SETTINGS[3].name) :].split()
    low, high = nees.band(3, 2)
    expected = ["3", "2", f"{low:.2f}-{high:.2f}", "3.00", "1.00", "100.0%", "5", "1.2", "22.00"]
    assert cells == expected
