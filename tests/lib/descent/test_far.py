"""A map far from the origin converges to the same shape as one at the origin."""

from __future__ import annotations

import numpy as np
import pytest
from robust_slam.descent.damped import levenberg_marquardt
from robust_slam.descent.undamped import gauss_newton
from robust_slam.graphs.generate import manhattan, sphere
from robust_slam.graphs.odometry import dead_reckoning
from robust_slam.graphs.pose_graph import cost

pytestmark = pytest.mark.long


@pytest.mark.parametrize("make", [manhattan, sphere])
@pytest.mark.parametrize("solve", [gauss_newton, levenberg_marquardt])
@pytest.mark.parametrize("offset", [1e5, 1e9])
def test_the_cost_does_not_depend_on_where_the_map_is(make, solve, offset):
    graph, _ = make(60, 0)
    first = dead_reckoning(graph)
    group = graph.group
    away = group.from_parts(group.rotation(group.identity()), np.full(group.DIMENSION, offset))
    near = cost(graph, solve(graph, first))
    far = cost(graph, solve(graph, group.compose(away, first)))
    # Coordinates of 1e9 m are rounded to 1e-7 m.
    assert far == pytest.approx(near, rel=1e-12 * offset + 1e-9)
