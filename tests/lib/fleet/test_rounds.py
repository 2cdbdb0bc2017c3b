"""A fleet finds the map that a centre would find, and only the boundary crosses."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from robust_slam._arrays import Array, Indices, Mask
from robust_slam.descent.undamped import gauss_newton
from robust_slam.estimators.graduation import gnc
from robust_slam.estimators.result import StopReason
from robust_slam.estimators.thresholds import chi_square_threshold
from robust_slam.fleet.robot import Message
from robust_slam.fleet.rounds import Fleet, Outcome, solve
from robust_slam.graphs import pose_graph, se2
from robust_slam.graphs.generate import Noise, manhattan, sphere
from robust_slam.graphs.metrics import ate
from robust_slam.graphs.odometry import spanning_tree
from robust_slam.graphs.outliers import add_random_closures
from robust_slam.graphs.pose_graph import PoseGraph
from robust_slam.problems import PoseGraphProblem

C = chi_square_threshold(0.99, 3)
SIZES = {2: 60, 3: 40, 4: 30}
SEEDS = range(5)


def crossing(graph: PoseGraph, labels: Indices) -> Mask:
    return labels[graph.edges[:, 0]] != labels[graph.edges[:, 1]]


def apart(graph: PoseGraph, labels: Indices) -> PoseGraph:
    """The graph of robots that have no odometry from one to the other."""
    return pose_graph.select(graph, ~(graph.is_odometry & crossing(graph, labels)))


def town(robots: int, seed: int, lies: int = 10) -> tuple[PoseGraph, Mask, Indices]:
    """Robots that walk through one town, with lies between them."""
    rng = np.random.default_rng(seed)
    n = robots * SIZES[robots]
    labels = np.arange(n) // SIZES[robots]
    walk, truth = manhattan(n, rng, side=6, closures=n // 4)
    graph, lie = add_random_closures(apart(walk, labels), 5 * lies, rng, poses=truth)
    between = np.flatnonzero(lie & crossing(graph, labels))[:lies]
    used = ~lie
    used[between] = True
    return pose_graph.select(graph, used), lie[used], labels


@pytest.fixture(scope="module")
def pair() -> tuple[PoseGraph, Mask, Indices]:
    return town(2, 0)


@pytest.fixture(scope="module")
def run(pair: tuple[PoseGraph, Mask, Indices]) -> Outcome:
    graph, _, labels = pair
    return solve(graph, labels, C)


@pytest.mark.parametrize("robots", SIZES)
@pytest.mark.parametrize("seed", SEEDS)
def test_the_fleet_finds_the_map_of_the_centre(robots: int, seed: int) -> None:
    graph, is_lie, labels = town(robots, seed)
    centre = gnc(PoseGraphProblem(graph), C)
    outcome = solve(graph, labels, C)
    last = outcome.rounds[-1]
    assert outcome.stop is StopReason.BINARY_WEIGHTS
    np.testing.assert_array_equal(last.weights, centre.weights)
    assert not np.any(last.weights[is_lie])
    best = pose_graph.cost(centre.x, graph, centre.weights)
    assert pose_graph.cost(last.poses, graph, last.weights) == pytest.approx(best, rel=1e-6)
    assert len(outcome.rounds) < 200


def test_it_works_in_space() -> None:
    rng = np.random.default_rng(1)
    walk, truth = sphere(90, rng, closures=60)
    labels = np.arange(90) // 45
    graph, is_lie = add_random_closures(apart(walk, labels), 6, rng, poses=truth)
    c = chi_square_threshold(0.99, 6)
    centre = gnc(PoseGraphProblem(graph), c)
    last = solve(graph, labels, c).rounds[-1]
    np.testing.assert_array_equal(last.weights, centre.weights)
    assert np.any(is_lie & crossing(graph, labels))
    best = pose_graph.cost(centre.x, graph, centre.weights)
    assert pose_graph.cost(last.poses, graph, last.weights) == pytest.approx(best, rel=1e-6)


def test_only_the_boundary_and_words_cross(
    pair: tuple[PoseGraph, Mask, Indices], monkeypatch: pytest.MonkeyPatch
) -> None:
    graph, _, labels = pair
    crossed: list[Message] = []
    carry = Fleet.carry

    def overheard(fleet: Fleet, messages: list[Message]) -> bool:
        crossed.extend(messages)
        return carry(fleet, messages)

    monkeypatch.setattr(Fleet, "carry", overheard)
    last = solve(graph, labels, C).rounds[-1]
    shared = np.flatnonzero(crossing(graph, labels))
    border = np.unique(graph.edges[shared])
    for message in crossed:
        mine = set(border[labels[border] == message.sender].tolist())
        assert message.poses.keys() <= mine
        assert message.weights.keys() <= set(shared.tolist())
        assert message.numbers == 3 * len(message.poses) + len(message.weights) + (
            message.word is not None
        )
    assert len(border) < graph.n / 2
    assert sum(message.numbers for message in crossed) == last.numbers
    assert len(crossed) == last.messages


def test_a_robot_knows_no_pose_of_others_but_the_boundary() -> None:
    graph, _, labels = town(3, 0)
    fleet = Fleet(graph, labels)
    fleet.meet()
    for robot in fleet.robots:
        ends = graph.edges[np.any(labels[graph.edges] == robot.name, axis=1)]
        assert set(robot.seen) == set(ends[labels[ends] != robot.name].tolist())
        assert set(robot.number.tolist()) == set(
            np.flatnonzero(np.any(labels[graph.edges] == robot.name, axis=1)).tolist()
        )
        held = [v for v in vars(robot).values() if isinstance(v, np.ndarray)]
        assert max(len(array) for array in held) <= max(len(robot.own), len(robot.number))
        assert not [v for v in vars(robot).values() if isinstance(v, PoseGraph | Fleet)]


def test_what_others_do_inside_is_not_heard() -> None:
    graph, _, labels = town(3, 0)
    fleet = Fleet(graph, labels)
    fleet.meet()
    border = np.unique(graph.edges[crossing(graph, labels)])
    robot = fleet.robots[1]
    before = robot.tell()
    inside = ~np.isin(robot.own, border)
    robot.poses[inside] = se2.compose(robot.poses[inside], [1.0, 2.0, 0.3])
    assert np.any(inside)
    for old, new in zip(before, robot.tell(), strict=True):
        assert old.receiver == new.receiver
        assert {k: v.tolist() for k, v in old.poses.items()} == {
            k: v.tolist() for k, v in new.poses.items()
        }


def test_what_a_robot_has_seen_is_where_the_pose_is() -> None:
    graph, _, labels = town(3, 1)
    fleet = Fleet(graph, labels)
    fleet.meet()
    for _ in range(4):
        fleet.descend(None, 1e-3, 3)
        for robot in fleet.robots:
            for pose, place in robot.seen.items():
                owner = fleet.robots[labels[pose]]
                assert np.array_equal(owner.poses[owner.own == pose][0], place)


def test_a_round_never_raises_the_weighted_cost(
    pair: tuple[PoseGraph, Mask, Indices], run: Outcome
) -> None:
    graph = pair[0]
    falls = 0
    for before, after in zip(run.rounds[1:], run.rounds[2:], strict=False):
        if np.array_equal(before.weights, after.weights):
            old, new = (pose_graph.cost(r.poses, graph, after.weights) for r in (before, after))
            assert new <= old * (1 + 1e-9)
            falls += new < old
    assert falls > 20


def test_counts_grow_from_round_to_round(run: Outcome) -> None:
    numbers = [r.numbers for r in run.rounds]
    assert numbers == sorted(set(numbers))
    messages = [r.messages for r in run.rounds]
    assert messages == sorted(set(messages))


@pytest.mark.parametrize("space", [False, True])
def test_an_edge_costs_both_its_robots_the_same(space: bool) -> None:
    rng = np.random.default_rng(2)
    walk, _ = sphere(40, rng) if space else manhattan(40, rng, side=3, closures=30)
    labels = np.arange(40) // 20
    graph = apart(walk, labels)
    fleet = Fleet(graph, labels)
    fleet.meet()
    poses = np.concatenate([robot.poses for robot in fleet.robots])
    right = pose_graph.residual_norms(poses, graph)
    for robot in fleet.robots:
        block, own = robot.block()
        np.testing.assert_allclose(
            pose_graph.residual_norms(own, block)[:-1], right[robot.number], rtol=1e-6, atol=1e-9
        )


def outvoted(honest: int, lies: int) -> tuple[PoseGraph, Array, Indices]:
    """Two robots with so many true edges between them, and so many that say anything."""
    rng = np.random.default_rng(0)
    walk, truth = manhattan(80, rng, side=5, closures=60)
    labels = np.arange(80) // 40
    graph = apart(walk, labels)
    across = np.flatnonzero(crossing(graph, labels))
    z = graph.measurement.copy()
    z[across[honest:]] = rng.uniform([-5, -5, -3], [5, 5, 3], (len(across) - honest, 3))
    used = ~np.isin(np.arange(len(z)), across[honest + lies :])
    return pose_graph.select(dataclasses.replace(graph, measurement=z), used), truth, labels


@pytest.mark.parametrize(("honest", "lies"), [(3, 0), (4, 6), (6, 10)])
def test_three_that_agree_outvote_any_number_that_do_not(honest: int, lies: int) -> None:
    graph, truth, labels = outvoted(honest, lies)
    fleet = Fleet(graph, labels)
    fleet.meet()
    fleet.record(None)
    assert ate(fleet.rounds[0].poses, truth) < 1.0


def test_a_lie_in_the_only_edge_between_two_robots_is_believed() -> None:
    graph, truth, labels = outvoted(0, 1)
    last = solve(graph, labels, C).rounds[-1]
    assert last.weights[crossing(graph, labels)] == [1.0]
    assert ate(last.poses, truth) > 1.0


def test_a_robot_that_trusts_no_neighbour_keeps_its_frame() -> None:
    graph, _, labels = town(2, 0)
    fleet = Fleet(graph, labels)
    fleet.meet()
    robot = fleet.robots[1]
    robot.weights[robot.shared] = 0.0
    first = robot.poses[0].copy()
    while robot.improve(1e-9):
        np.testing.assert_allclose(robot.poses[0], first, atol=1e-9)
    own = np.all(labels[graph.edges] == 1, axis=1)
    alone = PoseGraph(
        n=len(robot.own),
        edges=graph.edges[own] - robot.own[0],
        measurement=graph.measurement[own],
        information=graph.information[own],
        is_odometry=graph.is_odometry[own],
    )
    best = pose_graph.cost(gauss_newton(alone, spanning_tree(alone)), alone)
    assert pose_graph.cost(robot.poses, alone) == pytest.approx(best, rel=1e-6)


def test_without_lies_nothing_is_rejected() -> None:
    rng = np.random.default_rng(0)
    walk, _ = manhattan(60, rng, side=4, closures=30, noise=Noise(scale=0.1))
    labels = np.arange(60) // 30
    graph = apart(walk, labels)
    # Dead reckoning is worse than the closures, so the threshold has to allow for it.
    outcome = solve(graph, labels, 50.0)
    assert outcome.stop is StopReason.NOTHING_TO_REJECT
    assert outcome.rounds[-1].mu is None
    assert outcome.rounds[-1].weights.all()


@pytest.mark.parametrize("limit", [1, 60])
def test_rounds_may_run_out(pair: tuple[PoseGraph, Mask, Indices], limit: int) -> None:
    graph, _, labels = pair
    outcome = solve(graph, labels, C, max_rounds=limit, tol=1e-300)
    assert outcome.stop is StopReason.ITERATION_LIMIT
    assert len(outcome.rounds) <= 2 * limit + 3


@pytest.mark.parametrize(
    ("labels", "message"),
    [
        (np.zeros(60, dtype=int), "two at least"),
        (np.arange(60) // 30 * 2, "without a gap"),
        (np.arange(60) // 30 * 1.0, "60 whole numbers"),
        (np.arange(59) // 30, "60 whole numbers"),
        (np.arange(60) % 2, "robot 0, its poses counted from 0"),
    ],
)
def test_labels_that_do_not_fit_are_refused(labels: Any, message: str) -> None:
    graph, _ = manhattan(60, np.random.default_rng(0), closures=0)
    with pytest.raises(ValueError, match=message):
        Fleet(graph, labels)


@pytest.mark.parametrize("wrong", [{"every": 0}, {"max_rounds": 0}, {"tol": 0.0}])
def test_limits_out_of_range_are_refused(
    pair: tuple[PoseGraph, Mask, Indices], wrong: dict[str, Any]
) -> None:
    graph, _, labels = pair
    with pytest.raises(ValueError, match="give more than 0"):
        solve(graph, labels, C, **wrong)
