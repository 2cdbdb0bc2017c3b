"""Newton on the chordal cost: its model, quadratic convergence, and hard graphs that end fast."""

import logging
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from robust_slam.certificates import chordal
from robust_slam.certificates.chordal import ChordalProblem, pose_blocks
from robust_slam.certificates.newton import Stop, descend, polish
from robust_slam.certificates.optimality import Verdict
from robust_slam.certificates.staircase import solve_certified
from robust_slam.certificates.tangent import stationarity
from robust_slam.descent.minimise import gauss_newton
from robust_slam.descent.start import chordal as chordal_start
from robust_slam.errors import NotConverged
from robust_slam.graphs.generate import Noise, circle, sphere
from robust_slam.graphs.odometry import dead_reckoning
from robust_slam.groups import se2
from robust_slam.groups.rotations import nearest_stiefel

from ..worlds import building, measured, random_information, refused, shaken, walked

pytestmark = pytest.mark.long

LOUD = Noise(odometry=(0.1, 0.3), closure=(0.1, 0.3))


def loops(group, seed, n=12, noise=0.1):
    """A noisy ring with chords, edges of unequal information, and its true poses."""
    rng = np.random.default_rng(seed)
    steps = 0.4 * rng.normal(size=(n, group.DOF)) + np.eye(group.DOF)[0]
    truth = walked(group, group.exp(steps[1:]))
    edges = [(k, (k + far) % n) for far in (1, 4) for k in range(n)]
    information = random_information(group, len(edges), rng) + 4.0 * np.eye(group.DOF)
    error = noise * rng.normal(size=(len(edges), group.DOF))
    return measured(group, truth, edges, error, information), truth


def test_the_convergence_is_quadratic(group, seed):
    graph, truth = loops(group, seed, noise=0.03)
    problem = ChordalProblem.of(graph)
    optimum = polish(graph, gauss_newton(graph, truth))
    start = pose_blocks(shaken(group, optimum, 1e-2, np.random.default_rng(0)))
    sizes = [point.stationarity for point in descend(problem, start).history]
    assert sizes[0] > 1e-4
    for before, after in pairwise(sizes):
        assert after <= 100.0 * before**2 + 1e-14


def test_stationarity_has_no_unit_and_does_not_know_where_the_map_lies(group):
    graph, truth = loops(group, 7)
    problem = ChordalProblem.of(graph)
    expected = stationarity(problem, pose_blocks(truth))
    motion = group.exp(np.full(group.DOF, 1.5))
    moved = pose_blocks(group.compose(motion, truth))
    assert stationarity(problem, moved) == pytest.approx(expected, rel=1e-9)
    heavier = ChordalProblem.of(graph, np.full(len(graph.edges), 7.0))
    blocks = pose_blocks(truth)
    assert stationarity(heavier, blocks) == pytest.approx(expected, rel=1e-9)
    in_cm = 100.0
    d = group.DIMENSION
    measured, precision = problem.measured.copy(), problem.precision.copy()
    measured[:, :d, d] *= in_cm
    precision[:, d] /= in_cm**2
    blocks[..., d] *= in_cm
    smaller = ChordalProblem(problem.n, d, problem.edges, measured, precision)
    assert stationarity(smaller, blocks) == pytest.approx(expected, rel=1e-9)


@refused(({"tol": -1.0}, "tol is -1"), ({"max_iterations": 0}, "max_iterations is 0"))
def test_bad_input_is_refused_by_name(wrong, message):
    graph, truth = loops(se2, 8)
    with pytest.raises(ValueError, match=message):
        polish(graph, truth, **wrong)


def test_too_few_steps_are_an_error(group):
    graph, truth = loops(group, 8)
    far = shaken(group, truth, 1.0, np.random.default_rng(0))
    with pytest.raises(NotConverged, match=r"after 1 steps .* start from better poses"):
        polish(graph, far, max_iterations=1)


def small_sphere(n=220):
    rng = np.random.default_rng(0)
    return sphere(n, rng, around=16, neighbours=3, noise=LOUD)[0]


def small_building(n=600):
    return building(n, np.random.default_rng(0))[0]


graphs = pytest.mark.parametrize("make", [small_building, small_sphere])


def random_point(problem, r):
    rng = np.random.default_rng(0)
    turn = nearest_stiefel(rng.normal(size=(problem.n, r, problem.d)))
    return np.concatenate([turn, rng.normal(size=(problem.n, r, 1))], axis=2)


def stiff_building():
    """Positions are measured so well that the rotations turn large parts of the map."""
    rng = np.random.default_rng(0)
    return building(1500, rng, closures=60, deviation=(1e-4, 3e-3))[0]


@pytest.mark.parametrize("make", [small_building, stiff_building, small_sphere])
def test_from_the_chordal_start_a_hard_graph_is_certified_in_few_steps(make):
    # Positions that move along straight lines take 71 steps in the stiff building.
    graph = make()
    first = chordal_start(graph)
    descent = descend(ChordalProblem.of(graph), pose_blocks(first))
    assert descent.converged and len(descent.history) <= 9
    _, record = solve_certified(graph, first)
    assert record.verdict is Verdict.CERTIFIED
    assert record.cost == pytest.approx(descent.last.cost, rel=1e-9)


@graphs
def test_no_step_raises_the_cost_from_any_start_at_any_rank(make):
    problem = ChordalProblem.of(make(100))
    for extra in (0, 1, 2):
        history = descend(problem, random_point(problem, problem.d + extra), 1e-6, 15).history
        costs = np.array([point.cost for point in history])
        assert np.all(np.diff(costs) <= 1e-12 * costs[:-1])
        assert costs[-1] < 0.5 * costs[0]


def test_every_limit_ends_with_the_best_point_and_its_reason():
    graph = small_sphere(60)
    problem = ChordalProblem.of(graph)
    first = random_point(problem, 3)
    by_steps = descend(problem, first, max_iterations=2)
    assert by_steps.stop is Stop.ITERATION_LIMIT and len(by_steps.history) == 3
    by_time = descend(problem, first, max_seconds=0.0)
    assert by_time.stop is Stop.TIME_LIMIT and by_time.last.blocks is by_time.history[0].blocks
    assert not by_steps.converged and not by_time.converged
    flat = descend(problem, pose_blocks(chordal_start(graph)), 0.0, least_decrease=1e-3)
    assert flat.stop is Stop.FLAT and not flat.converged
    best = descend(problem, pose_blocks(chordal_start(graph)), 0.0)
    assert best.stop is Stop.ROUNDING and best.converged
    assert best.last.cost <= flat.last.cost <= best.last.cost * (1.0 + 1e-3)


def test_the_staircase_says_why_it_ends_and_logs_each_rank(caplog):
    # Odometry that turns twice as far winds the two rounds up wrongly.
    graph, _ = circle(40, np.random.default_rng(1), laps=2, closures=10)
    wound = dead_reckoning(replace(graph, measurement=graph.measurement * [1.0, 1.0, 2.0]))
    stuck, record = solve_certified(graph, gauss_newton(graph, wound), max_climbs=0)
    assert record.verdict is Verdict.NOT_CERTIFIED
    assert record.stop is Stop.ITERATION_LIMIT
    with caplog.at_level(logging.INFO, "robust_slam"):
        _, record = solve_certified(graph, stuck)
    assert record.verdict is Verdict.CERTIFIED and record.stop is not None
    assert [line.split(":")[0] for line in caplog.messages[:2]] == ["rank 2", "rank 3"]
    late, record = solve_certified(graph, stuck, max_seconds=0.0)
    assert record.stop is Stop.TIME_LIMIT
    assert record.verdict is not Verdict.CERTIFIED
    assert chordal.chordal_cost(graph, late) <= chordal.chordal_cost(graph, stuck) * (1 + 1e-12)
