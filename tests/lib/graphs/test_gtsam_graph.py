"""GTSAM's factor graph of a pose graph has its cost, its minimum and its poses."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from robust_slam.descent import gauss_newton, start
from robust_slam.graphs import gtsam_graph, pose_graph, se2

from tests.lib.worlds import GROUPS, assert_same_poses, public_graph, random_graph


def minimum(gtsam, graph, poses):
    """The poses and the error at which GTSAM's own Gauss–Newton ends."""
    factors, values = gtsam_graph.to_gtsam(graph, poses)
    settings = gtsam.GaussNewtonParams()
    settings.setRelativeErrorTol(1e-14)
    settings.setAbsoluteErrorTol(1e-14)
    ended = gtsam.GaussNewtonOptimizer(factors, values, settings).optimize()
    return gtsam_graph.poses_from_gtsam(ended, graph), factors.error(ended)


def test_each_factor_is_half_the_square_of_its_edge(gtsam, group, seed):
    poses, graph = random_graph(seed, group, n=5, m=9)
    factors, values = gtsam_graph.to_gtsam(graph, poses)
    halves = [factors.at(k).error(values) for k in range(9)]
    np.testing.assert_allclose(2.0 * np.array(halves), pose_graph.squared_norms(graph, poses))


def test_poses_go_there_and_come_back(gtsam, group):
    poses, graph = random_graph(6, group, n=12, m=14)
    _, values = gtsam_graph.to_gtsam(graph, poses)
    back = gtsam_graph.poses_from_gtsam(values, graph)
    assert back.shape == poses.shape
    assert_same_poses(group, back, poses, atol=1e-13)


@pytest.mark.parametrize("name", ["tinyGrid3D", "smallGrid3D"])
def test_on_public_graphs_both_end_at_the_same_cost(gtsam, name):
    graph = public_graph(name)
    first = start.chordal(graph)
    _, error = minimum(gtsam, graph, first)
    ours = pose_graph.cost(graph, gauss_newton(graph, first))
    assert ours == pytest.approx(error, rel=1e-6)


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
