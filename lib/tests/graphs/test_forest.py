"""Trees of edges: what runs along them, common ancestors, sessions, and first poses."""

from functools import reduce

import numpy as np
import pytest
from robust_slam.graphs import odometry
from robust_slam.graphs.generate import manhattan
from robust_slam.graphs.odometry import dead_reckoning, sessions, spanning_tree
from robust_slam.graphs.pose_graph import PoseGraph, select

from ..worlds import assert_same_poses, chain_with_closures, random_poses, renumbered, walked


def random_forest(n, seed):
    """Each pose is a root or hangs below one of the three poses before it."""
    rng = np.random.default_rng(seed)
    parent = np.array(
        [k if k == 0 or rng.random() < 0.1 else rng.integers(max(0, k - 3), k) for k in range(n)]
    )
    return odometry.Forest(parent, np.full(n, -1), np.zeros(n, dtype=int))


def way_up(forest, pose):
    """The pose, its parent and so on, and n above the root."""
    way = [pose]
    while forest.parent[way[-1]] != way[-1]:
        way.append(int(forest.parent[way[-1]]))
    return [*way, forest.parent.size]


@pytest.mark.parametrize("n", [1, 2, 3, 17, 64, 100])
@pytest.mark.parametrize("seed", range(3))
def test_the_common_ancestor_is_the_first_pose_on_both_ways_up(n, seed):
    forest = random_forest(n, seed)
    a, b = np.random.default_rng(seed).integers(n, size=(2, 100))
    expected = [
        next(pose for pose in way_up(forest, i) if pose in way_up(forest, j))
        for i, j in zip(a, b, strict=True)
    ]
    np.testing.assert_array_equal(odometry.Ancestors.of(forest).common(a, b), expected)


def test_sums_run_from_the_root_and_leave_it_out():
    forest = random_forest(40, 1)
    values = np.random.default_rng(1).normal(size=(40, 2))
    for pose, total in enumerate(odometry.sums_along(forest, values)):
        below_root = way_up(forest, pose)[:-2]
        np.testing.assert_allclose(total, values[below_root].sum(axis=0), atol=1e-12)


def test_dead_reckoning_from_another_pose_is_the_same_map():
    graph, _ = manhattan(40, np.random.default_rng(4), closures=5)
    other, number = renumbered(graph, 17)
    known = dead_reckoning(graph)
    expected = graph.group.between(np.broadcast_to(known[17], known.shape), known)
    np.testing.assert_allclose(dead_reckoning(other)[number], expected, atol=1e-12)


def test_a_gap_in_the_odometry_makes_two_sessions_and_no_dead_reckoning():
    graph, _ = manhattan(30, np.random.default_rng(5), closures=12)
    cut = select(graph, ~np.all(graph.edges == [14, 15], axis=1))
    assert sessions(cut).tolist() == [0] * 15 + [1] * 15
    with pytest.raises(ValueError, match="no path of odometry leads from pose 0 to pose 15"):
        dead_reckoning(cut)


def test_dead_reckoning_and_a_tree_with_complete_odometry_take_its_steps_alone(group, seed):
    _, graph = chain_with_closures(group, seed, n=200, closures=40, noise=1.0)
    expected = walked(group, graph.measurement[:199])
    for start in (dead_reckoning, spanning_tree):
        assert_same_poses(group, start(graph), expected, atol=1e-8)


def test_dead_reckoning_takes_the_fewest_edges_and_of_twins_the_first():
    z = [[5.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [9.0, 0.0, 0.0], [7.0, 0.0, 0.0]]
    edges = [[1, 2], [0, 1], [0, 1], [0, 1], [0, 2]]
    for shortcut, last in ((False, 6.0), (True, 7.0)):
        graph = PoseGraph(3, edges, z, [np.eye(3)] * 5, [True, True, True, False, shortcut])
        np.testing.assert_array_equal(dead_reckoning(graph)[:, 0], [0.0, 1.0, last])


def test_the_tree_takes_few_closures_then_few_edges_then_the_first_edge(group):
    edges = [[0, 1], [1, 2], [4, 3], [0, 2], [2, 4], [3, 0], [0, 3], [4, 5]]
    is_odometry = [True, True, True, False, False, False, False, True]
    z = random_poses(group, 8, np.random.default_rng(2))
    graph = PoseGraph(6, edges, z, [np.eye(group.DOF)] * 8, is_odometry)
    # Pose 2 over the odometry, not over the closure 0–2. One closure leads on, at the
    # best at once from pose 0 to 3, by edge 5, which comes before its twin 6.
    paths = {1: [0], 2: [0, 1], 3: [~5], 4: [~5, ~2], 5: [~5, ~2, 7]}
    poses = spanning_tree(graph)
    for pose, path in paths.items():
        steps = [z[k] if k >= 0 else group.inverse(z[~k]) for k in path]
        assert_same_poses(group, poses[pose], reduce(group.compose, steps), atol=1e-12)


def test_only_whether_a_weight_is_0_matters_to_the_tree(group):
    _, graph = chain_with_closures(group, 3, noise=0.5, odometry=False)
    weights = np.where(np.arange(21) % 4 == 1, 0.0, np.linspace(0.01, 3.0, 21))
    left = select(graph, weights > 0.0)
    np.testing.assert_array_equal(spanning_tree(graph, weights), spanning_tree(left))
