"""The table of growth: as written, as committed, as read."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks import growth
from benchmarks.growth import Size

COMMITTED = Path(__file__).resolve().parents[2] / "chapters" / "data" / "growth.csv"


def test_a_written_table_reads_back(tmp_path):
    path = tmp_path / "growth.csv"
    path.write_text(growth.table([Size(10, 11, 0.5, 0.25, 0.125, 90.0, 70.0)] * 2))
    assert np.loadtxt(path, delimiter=",")[1].tolist() == [10, 11, 0.5, 0.25, 0.125, 90, 70]


@pytest.mark.long
def test_a_small_map_costs_time_and_memory():
    (size,) = growth.measured([200])
    assert (size.poses, size.closures) == (200, 200)
    assert 0.0 < size.step < 1.0
    assert size.base <= size.memory < 1000.0


def test_the_committed_table_has_every_size_its_command_and_its_seed():
    header = [line for line in COMMITTED.read_text().splitlines() if line.startswith("#")]
    assert header == [line for line in growth.table([]).splitlines() if line]
    rows = np.loadtxt(COMMITTED, delimiter=",")
    assert rows[:, 0] == pytest.approx(growth.SIZES)
    assert np.all(np.diff(rows[:, 4]) > 0.0)
