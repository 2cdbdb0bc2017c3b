"""PCM on any odometry: written either way, from any fixed pose, in several sessions."""

import numpy as np
import pytest
from robust_slam.consistency import pairwise
from robust_slam.consistency.bridges import find_bridges
from robust_slam.consistency.pairwise import pairwise_distances, pcm, total_distances
from robust_slam.graphs.generate import manhattan
from robust_slam.graphs.pose_graph import PoseGraph, select

from ..worlds import renumbered, with_outliers


def spoiled(make, seed, outliers=15):
    return with_outliers(make, 60, seed, outliers, closures=25)[:2]


@pytest.mark.parametrize("first", [1, 30, 59])
def test_distances_do_not_depend_on_the_fixed_pose(first):
    graph, _ = spoiled(manhattan, 1)
    distances = pairwise_distances(renumbered(graph, first)[0])
    np.testing.assert_allclose(distances, pairwise_distances(graph), rtol=1e-6, atol=1e-9)


def two_sessions(seed):
    graph, is_outlier = spoiled(manhattan, seed)
    used = ~np.all(graph.edges == [29, 30], axis=1)
    return select(graph, used), is_outlier[used]


def test_closures_are_compared_with_those_that_join_the_same_sessions():
    graph, _ = two_sessions(3)
    apart = pairwise_distances(graph)
    i, j = np.sort(graph.edges[~graph.is_odometry], axis=1).T
    kind = (i >= 30) * 1 + (j >= 30) * 1
    together = kind[:, None] == kind
    np.fill_diagonal(together, False)
    assert np.all(apart[together] > 0.0)
    assert np.all(apart[~together] == 0.0)
    totals = total_distances(graph, ~graph.is_odometry)
    np.testing.assert_allclose(totals[~graph.is_odometry], apart.sum(axis=1))


def test_with_exact_odometry_a_gap_changes_no_distance_within_a_session():
    graph, _ = spoiled(manhattan, 4)
    whole = pairwise_distances(graph)
    cut = select(graph, ~np.all(graph.edges == [29, 30], axis=1))
    ends = graph.edges[~graph.is_odometry]
    early, late = np.all(ends < 30, axis=1), np.all(ends >= 30, axis=1)
    for part in (early, late):
        block = np.ix_(part, part)
        np.testing.assert_allclose(pairwise_distances(cut)[block], whole[block], atol=1e-9)


def test_bridges_join_the_sessions_with_a_closure_that_most_agree_with():
    graph, is_outlier = two_sessions(5)
    bridges = find_bridges(graph, pcm(graph).kept)
    assert bridges.edges.size == 1
    assert not is_outlier[bridges.edges[0]]
    assert bridges.support[0] > 1
    early = graph.edges[bridges.edges[0]] < 30
    assert early.sum() == 1


def test_three_sessions_are_joined_by_the_pairs_that_most_closures_join():
    graph, _ = spoiled(manhattan, 8, outliers=0)
    graph = select(graph, ~(graph.is_odometry & np.isin(graph.edges[:, 0], (19, 39))))
    consistency = pcm(graph)
    ends = graph.edges[consistency.kept & ~graph.is_odometry] // 20
    apart = np.sort(ends[ends[:, 0] != ends[:, 1]], axis=1)
    counts = sorted(np.unique(apart, axis=0, return_counts=True)[1].tolist())
    assert len(counts) == 3 and counts[0] < counts[1]
    assert sorted(find_bridges(graph, consistency.kept).support.tolist()) == counts[1:]


def test_without_gaps_there_are_no_bridges_and_closures_without_any_odometry_are_all_kept():
    graph, _ = spoiled(manhattan, 6)
    assert find_bridges(graph, pcm(graph).kept).edges.size == 0
    z = [[1, 0, 0], [1, 0, 0], [2, 0, 0]]
    graph = PoseGraph(3, [[0, 1], [1, 2], [0, 2]], z, [np.eye(3)] * 3, [False] * 3)
    assert np.all(pcm(graph).kept)


def test_a_budget_of_pairs_compares_in_blocks_and_says_so(monkeypatch):
    graph, is_outlier = spoiled(manhattan, 7, outliers=10)
    whole = pcm(graph)
    monkeypatch.setitem(pairwise.PAIRS, 2, 200)
    limited = pcm(graph)
    assert whole.complete and not limited.complete
    assert len(limited.blocks) > 1
    compared = np.zeros_like(whole.adjacency)
    for block in limited.blocks:
        compared[np.ix_(block.members, block.members)] = True
    np.testing.assert_array_equal(limited.adjacency[compared], whole.adjacency[compared])
    assert np.all(limited.adjacency[~compared])
    assert np.sum(compared) // 2 <= 2 * 200
    assert np.mean(limited.kept[is_outlier]) < 0.5
