"""The tables of the labs' pictures are what the library decides."""

import json
from importlib.resources import files
from typing import Any

import numpy as np
import pytest
from robust_slam.graphs.pose_graph import select
from robust_slam.incremental import GrowingMap
from robust_slam.problems import PoseGraphProblem
from robust_slam_course import labs

from tools.data import labs as made

TABLE: dict[str, Any] = json.loads(
    (files("robust_slam_course.pictures") / "labs.json").read_text(encoding="utf-8")
)


@pytest.mark.parametrize("arrives", [17, 20, 23, 24, 31])
def test_the_map_keeps_what_the_table_has(arrives):
    assert TABLE["minds"][arrives - labs.ARRIVALS[0]] == list(made.mind(arrives)), made.__doc__


@pytest.mark.parametrize("solver", ["gnc", "switches"])
def test_a_run_and_its_certificates_are_those_of_the_table(solver):
    for turns, there in [*zip(labs.TURNS, TABLE["proofs"][solver], strict=True)][::6]:
        run = made.certified(solver, turns)
        assert np.allclose(run.pop("steps"), there["steps"], atol=1)
        assert run.items() <= there.items(), made.__doc__


def test_the_map_that_is_drawn_is_the_one_that_has_grown():
    graph, _ = labs.late_town()
    order = labs.in_order(graph, 17)
    growing = GrowingMap(select(graph, graph.is_odometry), find_noise=False)
    for k in order[~graph.is_odometry[order]]:
        growing.add(**labs.edge(graph, k))
    drawn = PoseGraphProblem(select(growing.graph, growing.kept)).initial()
    assert np.abs(growing.poses - drawn).max() < 1e-3
