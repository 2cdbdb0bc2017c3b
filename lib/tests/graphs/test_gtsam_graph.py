"""GTSAM's factor graph of a pose graph has its cost, its minimum and its poses."""

import sys

import numpy as np
import pytest
from robust_slam.graphs import gtsam_graph, pose_graph, se2

from ..worlds import GROUPS, assert_same_poses, random_graph


def test_each_factor_is_half_the_square_of_its_edge(gtsam, group, seed):
    poses, graph = random_graph(seed, group, n=5, m=9)
    factors, values = gtsam_graph.to_gtsam(graph, poses)
    halves = [factors.at(k).error(values) for k in range(9)]
    np.testing.assert_allclose(2.0 * np.array(halves), pose_graph.squared_norms(graph, poses))


def test_values_of_another_graph_are_refused(gtsam):
    _, plane = random_graph(8, GROUPS["SE(2)"], n=4, m=4)
    poses, space = random_graph(8, GROUPS["SE(3)"], n=4, m=4)
    _, values = gtsam_graph.to_gtsam(space, poses)
    with pytest.raises(ValueError, match=r"values: .*Pose3"):
        gtsam_graph.poses_from_gtsam(values, plane)
    with pytest.raises(ValueError, match=r'values: .*key "0".*does not exist'):
        gtsam_graph.poses_from_gtsam(gtsam.Values(), space)


def test_without_gtsam_it_says_how_to_get_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "gtsam", None)
    poses, graph = random_graph(10, se2, n=4, m=4)
    with pytest.raises(ImportError, match="pip install gtsam"):
        gtsam_graph.to_gtsam(graph, poses)


def test_factors_of_gtsam_come_back_as_the_graph(gtsam, group, seed):
    poses, graph = random_graph(seed, group, n=12, m=20)
    factors, values = gtsam_graph.to_gtsam(graph, poses)
    found = gtsam_graph.from_gtsam(factors, values)
    np.testing.assert_array_equal(found.graph.edges, graph.edges)
    np.testing.assert_allclose(found.graph.information, graph.information, rtol=1e-9, atol=1e-9)
    assert_same_poses(group, found.graph.measurement, graph.measurement, atol=1e-13)
    assert_same_poses(group, found.poses, poses, atol=1e-13)
    named = gtsam_graph.to_gtsam(graph, poses, names=np.arange(12) + 100)
    assert gtsam_graph.from_gtsam(*named).ids.tolist() == list(range(100, 112))
    back = gtsam_graph.poses_from_gtsam(named[1], graph, names=np.arange(12) + 100)
    assert_same_poses(group, back, poses, atol=1e-13)
    assert "left out 1 factor PriorFactorPose" in found.summary()


def test_symbols_name_robots_and_robust_noise_is_taken_without_its_kernel(gtsam):
    noise = gtsam.noiseModel.Diagonal.Sigmas(np.array([0.1, 0.2, 0.05]))
    huber = gtsam.noiseModel.mEstimator.Huber.Create(1.3)
    robust = gtsam.noiseModel.Robust.Create(huber, noise)
    factors, keys = gtsam.NonlinearFactorGraph(), [gtsam.symbol(*name) for name in SYMBOLS]
    for i, j, how in ((0, 1, noise), (2, 3, noise), (1, 2, robust)):
        factors.add(gtsam.BetweenFactorPose2(keys[i], keys[j], gtsam.Pose2(1, 0, 0), how))
    found = gtsam_graph.from_gtsam(factors)
    assert found.names.tolist() == ["a0", "a1", "b0", "b1"] and found.poses is None
    assert found.graph.is_odometry.tolist() == [True, True, False]
    np.testing.assert_allclose(found.graph.information[2], np.diag([100.0, 25.0, 400.0]))
    with pytest.raises(ValueError, match="factors: give BetweenFactorPose2 or"):
        gtsam_graph.from_gtsam(gtsam.NonlinearFactorGraph())


SYMBOLS = [("a", 0), ("a", 1), ("b", 0), ("b", 1)]
