"""Dead reckoning takes the odometry alone; a spanning tree takes closures where it must."""

from __future__ import annotations

from dataclasses import replace
from functools import reduce

import numpy as np
from robust_slam.graphs.odometry import dead_reckoning, spanning_tree
from robust_slam.graphs.pose_graph import PoseGraph, select

from tests.lib.worlds import assert_same_poses, chain_with_closures, random_poses, walked


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


def test_turning_edges_round_changes_nothing_for_the_tree(group, seed):
    _, graph = chain_with_closures(group, seed, noise=0.5)
    back = replace(graph, edges=graph.edges[:, ::-1], measurement=group.inverse(graph.measurement))
    assert_same_poses(group, spanning_tree(back), spanning_tree(graph))
