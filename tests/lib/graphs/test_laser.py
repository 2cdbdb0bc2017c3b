"""The building: the truth fits, its graph is badly conditioned, and its gaps are closed."""

from __future__ import annotations

import numpy as np
import pytest
from robust_slam.graphs import pose_graph, se2
from robust_slam.graphs.generate import sphere
from robust_slam.graphs.laser import building
from robust_slam.graphs.odometry import spanning_tree


def test_without_noise_the_truth_costs_nothing_and_the_spanning_tree_finds_it():
    graph, truth = building(400, np.random.default_rng(0), gaps=3, closures=60, scale=0.0)
    assert pose_graph.cost(graph, truth) < 1e-12
    np.testing.assert_allclose(truth[0], 0.0, atol=1e-12)
    found = se2.between(spanning_tree(graph), truth)
    np.testing.assert_allclose(found, 0.0, atol=1e-9)


def test_at_the_truth_an_edge_costs_a_chi_square_of_3_degrees():
    graph, truth = building(2000, np.random.default_rng(3))
    squares = pose_graph.squared_norms(graph, truth)
    for edges in (graph.is_odometry, ~graph.is_odometry):
        spread = np.sqrt(6.0 / np.sum(edges))
        assert np.mean(squares[edges]) == pytest.approx(3.0, abs=4.0 * spread)


def test_gaps_are_missing_and_closures_join_what_they_separate():
    graph, truth = building(800, np.random.default_rng(5), gaps=4, closures=100)
    i, j = graph.edges.T
    assert graph.is_odometry.sum() == 800 - 1 - 4
    assert np.all(j[graph.is_odometry] == i[graph.is_odometry] + 1)
    assert np.sum(~graph.is_odometry) == 100
    assert not graph.odometry_joins_all  # PoseGraph has checked that all edges join all poses
    apart = np.linalg.norm(truth[i, :2] - truth[j, :2], axis=1)
    assert apart[~graph.is_odometry].max() <= 1.0 + 1e-9


def test_bad_input_is_refused():
    rng = np.random.default_rng(0)
    with pytest.raises(ValueError, match="gaps 299"):
        building(300, rng, gaps=299)
    with pytest.raises(ValueError, match="the closures do not join"):
        building(300, rng, gaps=200)
    with pytest.raises(ValueError, match="closures is 10000"):
        building(300, rng, gaps=0, closures=10_000)
    with pytest.raises(ValueError, match="neighbours is 2"):
        sphere(100, rng, neighbours=2)


@pytest.mark.parametrize("neighbours", [1, 3, 5])
def test_a_pose_of_the_sphere_has_neighbours_on_the_next_ring(neighbours):
    graph, _ = sphere(120, np.random.default_rng(0), around=12, neighbours=neighbours)
    first, after = graph.edges[~graph.is_odometry].T
    inside = first < 120 - 12 - neighbours
    assert np.all(np.bincount(first[inside]) == neighbours)
    assert set((after - first).tolist()) == set(range(12 - neighbours // 2, 13 + neighbours // 2))
