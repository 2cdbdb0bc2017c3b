"""A fleet finds the map that a centre would find, and only the boundary crosses."""

from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from robust_slam.descent.minimise import gauss_newton
from robust_slam.estimators import StopReason, chi_square_threshold, gnc
from robust_slam.fleet.rounds import Fleet, solve
from robust_slam.graphs import PoseGraph, add_random_closures, ate, pose_graph, spanning_tree
from robust_slam.graphs.generate import manhattan, sphere
from robust_slam.problems import PoseGraphProblem

from ..worlds import refused

pytestmark = pytest.mark.long

C = chi_square_threshold(0.99, 3)
SIZES = {2: 60, 3: 40, 4: 30}


def crossing(graph, labels):
    return labels[graph.edges[:, 0]] != labels[graph.edges[:, 1]]


def apart(graph, labels):
    """The graph of robots that have no odometry from one to the other."""
    return pose_graph.select(graph, ~(graph.is_odometry & crossing(graph, labels)))


@cache
def town(robots, seed, outliers=10):
    """Robots that walk through one town, with outliers between them."""
    rng = np.random.default_rng(seed)
    n = robots * SIZES[robots]
    labels = np.arange(n) // SIZES[robots]
    walk, truth = manhattan(n, rng, side=6, closures=n // 4)
    graph, is_outlier = add_random_closures(apart(walk, labels), 5 * outliers, rng, poses=truth)
    between = np.flatnonzero(is_outlier & crossing(graph, labels))[:outliers]
    used = ~is_outlier
    used[between] = True
    return pose_graph.select(graph, used), is_outlier[used], labels


def met(graph, labels):
    """A fleet whose robots have put their maps into one frame."""
    fleet = Fleet(graph, labels)
    fleet.meet()
    return fleet


def assert_map_of_the_centre(graph, labels, c):
    """Solve with the fleet and at a centre: the same weights, the same cost."""
    centre = gnc(PoseGraphProblem(graph), c)
    outcome = solve(graph, labels, c)
    last = outcome.rounds[-1]
    np.testing.assert_array_equal(last.weights, centre.weights)
    best = pose_graph.cost(graph, centre.x, centre.weights)
    assert pose_graph.cost(graph, last.poses, last.weights) == pytest.approx(best, rel=1e-6)
    return outcome


@pytest.mark.parametrize("robots", SIZES)
def test_the_fleet_finds_the_map_of_the_centre(robots):
    graph, is_outlier, labels = town(robots, 0)
    outcome = assert_map_of_the_centre(graph, labels, C)
    assert outcome.stop is StopReason.BINARY_WEIGHTS
    assert not np.any(outcome.rounds[-1].weights[is_outlier])
    assert len(outcome.rounds) < 200


def test_it_works_in_space():
    rng = np.random.default_rng(1)
    walk, truth = sphere(90, rng, closures=60)
    labels = np.arange(90) // 45
    graph, is_outlier = add_random_closures(apart(walk, labels), 6, rng, poses=truth)
    assert np.any(is_outlier & crossing(graph, labels))
    assert_map_of_the_centre(graph, labels, chi_square_threshold(0.99, 6))


def test_only_the_boundary_and_words_cross(monkeypatch):
    graph, _, labels = town(2, 0)
    crossed, carry = [], Fleet.carry

    def overheard(fleet, messages):
        crossed.extend(messages)
        return carry(fleet, messages)

    monkeypatch.setattr(Fleet, "carry", overheard)
    last = solve(graph, labels, C).rounds[-1]
    shared = np.flatnonzero(crossing(graph, labels))
    border = np.unique(graph.edges[shared])
    for message in crossed:
        assert message.poses.keys() <= set(border[labels[border] == message.sender].tolist())
        assert message.weights.keys() <= set(shared.tolist())
        words = int(message.word is not None)
        assert message.numbers == 3 * len(message.poses) + len(message.weights) + words
    assert len(border) < graph.n / 2
    assert sum(message.numbers for message in crossed) == last.numbers
    assert len(crossed) == last.messages


def test_a_robot_knows_no_pose_of_others_but_the_boundary():
    graph, _, labels = town(3, 0)
    for robot in met(graph, labels).robots:
        touching = np.any(labels[graph.edges] == robot.name, axis=1)
        ends = graph.edges[touching]
        assert set(robot.seen) == set(ends[labels[ends] != robot.name].tolist())
        assert set(robot.number.tolist()) == set(np.flatnonzero(touching).tolist())
        held = [v for v in vars(robot).values() if isinstance(v, np.ndarray)]
        assert max(len(array) for array in held) <= max(len(robot.own), len(robot.number))
        assert not [v for v in vars(robot).values() if isinstance(v, PoseGraph | Fleet)]


def test_what_a_robot_has_seen_is_where_the_pose_is():
    graph, _, labels = town(3, 1)
    fleet = met(graph, labels)
    for _ in range(4):
        fleet.descend(None, 1e-3, 3)
        for robot in fleet.robots:
            for pose, place in robot.seen.items():
                owner = fleet.robots[labels[pose]]
                assert np.array_equal(owner.poses[owner.own == pose][0], place)


def test_a_round_never_raises_the_weighted_cost_and_counts_grow():
    graph, _, labels = town(2, 0)
    rounds = solve(graph, labels, C).rounds
    falls = 0
    for before, after in pairwise(rounds[1:]):
        if np.array_equal(before.weights, after.weights):
            old, new = (pose_graph.cost(graph, r.poses, after.weights) for r in (before, after))
            assert new <= old * (1 + 1e-9)
            falls += new < old
    assert falls > 20
    assert np.all(np.diff([(r.numbers, r.messages) for r in rounds], axis=0) > 0)


def outvoted(inliers, outliers):
    """Two robots with so many inliers between them, and so many edges of any measurement."""
    rng = np.random.default_rng(0)
    walk, truth = manhattan(80, rng, side=5, closures=60)
    labels = np.arange(80) // 40
    graph = apart(walk, labels)
    across = np.flatnonzero(crossing(graph, labels))
    z = graph.measurement.copy()
    z[across[inliers:]] = rng.uniform([-5, -5, -3], [5, 5, 3], (len(across) - inliers, 3))
    used = ~np.isin(np.arange(len(z)), across[inliers + outliers :])
    return pose_graph.select(replace(graph, measurement=z), used), truth, labels


@pytest.mark.parametrize(("inliers", "outliers"), [(3, 0), (4, 6), (6, 10)])
def test_three_that_agree_outvote_any_number_that_do_not(inliers, outliers):
    graph, truth, labels = outvoted(inliers, outliers)
    fleet = met(graph, labels)
    fleet.record(None)
    assert ate(fleet.rounds[0].poses, truth) < 1.0


def test_an_outlier_in_the_only_edge_between_two_robots_is_believed():
    graph, truth, labels = outvoted(0, 1)
    last = solve(graph, labels, C).rounds[-1]
    assert last.weights[crossing(graph, labels)] == [1.0]
    assert ate(last.poses, truth) > 1.0


def test_a_robot_that_trusts_no_neighbour_keeps_its_frame():
    graph, _, labels = town(2, 0)
    robot = met(graph, labels).robots[1]
    robot.weights[robot.shared] = 0.0
    first = robot.poses[0].copy()
    while robot.improve(1e-9):
        np.testing.assert_allclose(robot.poses[0], first, atol=1e-9)
    own = np.all(labels[graph.edges] == 1, axis=1)
    parts = (graph.measurement[own], graph.information[own], graph.is_odometry[own])
    alone = PoseGraph(len(robot.own), graph.edges[own] - robot.own[0], *parts)
    best = pose_graph.cost(alone, gauss_newton(alone, spanning_tree(alone)))
    assert pose_graph.cost(alone, robot.poses) == pytest.approx(best, rel=1e-6)


@pytest.mark.parametrize("limit", [1, 60])
def test_rounds_may_run_out(limit):
    graph, _, labels = town(2, 0)
    outcome = solve(graph, labels, C, max_rounds=limit, tol=1e-300)
    assert outcome.stop is StopReason.ITERATION_LIMIT
    assert len(outcome.rounds) <= 2 * limit + 3


@refused(
    (np.zeros(60, dtype=int), "two at least"),
    (np.arange(60) // 30 * 2, "without a gap"),
    (np.arange(60) // 30 * 1.0, "60 whole numbers"),
    (np.arange(59) // 30, "60 whole numbers"),
    (np.arange(60) % 2, "robot 0, its poses counted from 0"),
)
def test_labels_that_do_not_fit_are_refused(wrong, message):
    graph, _ = manhattan(60, np.random.default_rng(0), closures=0)
    with pytest.raises(ValueError, match=message):
        Fleet(graph, wrong)


@pytest.mark.parametrize("wrong", [{"every": 0}, {"max_rounds": 0}, {"tol": 0.0}])
def test_limits_out_of_range_are_refused(wrong):
    graph, _, labels = town(2, 0)
    with pytest.raises(ValueError, match="give more than 0"):
        solve(graph, labels, C, **wrong)
