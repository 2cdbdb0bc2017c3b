"""Steps of the odometry that slipped are found, and no others are given up."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from robust_slam.graphs import add_random_closures, ate, manhattan, sphere
from robust_slam.graphs.outliers import add_aliased_closures
from robust_slam.solver import Support, solve

STEPS = (30, 75)


def _slipped(graph, steps, metres=3.0, radians=0.6):
    """Return ``graph`` where the odometry at ``steps`` is off, though it claims what it did."""
    group, measurement = graph.group, graph.measurement.copy()
    error = np.zeros((len(steps), group.DOF))
    error[:, 0], error[:, -1] = metres, radians
    measurement[list(steps)] = group.compose(measurement[list(steps)], group.exp(error))
    return replace(graph, measurement=measurement)


@pytest.mark.parametrize("make", [manhattan, sphere])
def test_slips_are_found_and_the_map_is_right_without_them(make, seed):
    rng = np.random.default_rng(seed)
    graph, truth = make(100, rng, closures=45)
    graph, is_outlier = add_random_closures(graph, 20, rng)
    answer = solve(_slipped(graph, STEPS))
    assert answer.slips.tolist() == list(STEPS)
    assert ate(answer.poses, truth) < 0.4
    assert not np.any(answer.kept & is_outlier)
    assert answer.support is Support.WEAK
    assert "slipped at 2 steps: 30-31, 75-76" in answer.summary()


def test_an_odometry_that_did_not_slip_is_trusted(seed):
    rng = np.random.default_rng(seed)
    graph, _ = add_random_closures(manhattan(100, rng, closures=45)[0], 60, rng)
    answer = solve(graph)
    assert answer.slips.size == 0
    assert answer.support is Support.UNIQUE


def test_closures_of_one_place_are_no_slip():
    """The robot takes one place for another: its five closures agree, as after a slip."""
    rng = np.random.default_rng(0)
    graph, truth = manhattan(100, rng, closures=4)
    graph, _ = add_aliased_closures(graph, 1, rng, size=5, poses=truth)
    answer = solve(graph)
    assert answer.slips.size == 0
