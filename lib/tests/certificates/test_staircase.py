"""The staircase leaves local minima, and certifies nothing where the relaxation is not tight."""

import numpy as np
import pytest
from robust_slam.certificates import Verdict, certify, chordal
from robust_slam.certificates.chordal import chordal_cost
from robust_slam.certificates.newton import Stop
from robust_slam.certificates.sdp import solve_sdp
from robust_slam.certificates.staircase import rounded, solve_certified
from robust_slam.graphs import PoseGraph, se3

from ..worlds import assert_same_poses, ring
from .dense import data_matrix, marginalised


@pytest.mark.parametrize("n", [5, 8, 12])
@pytest.mark.parametrize("chords", [0, 2])
@pytest.mark.parametrize("seed", range(2))
def test_a_twisted_noisy_cycle_ends_at_the_certified_optimum(group, n, chords, seed):
    graph, truth, twisted = ring(group, n, seed, 0.1, chords)
    poses, record = solve_certified(graph, twisted)
    _, expected = certify(graph, truth)
    assert expected.verdict is record.verdict is Verdict.CERTIFIED
    assert record.cost == pytest.approx(expected.cost, rel=1e-9)
    assert chordal_cost(graph, poses) == pytest.approx(record.cost, rel=1e-12)
    np.testing.assert_array_equal(poses[0], twisted[0])


def test_where_the_relaxation_is_not_tight_the_bound_is_closer_than_before():
    # A ring of 30 whose measured rotations are so noisy that no map reaches the relaxation.
    graph, truth, _ = ring(se3, 30, 0, 0.2, reach=0.0)
    _, before = certify(graph, truth)
    poses, record = solve_certified(graph, truth)
    assert before.verdict is record.verdict is Verdict.NOT_CERTIFIED
    assert record.stop is Stop.LOOSE
    assert record.cost <= before.cost * (1.0 + 1e-12)
    assert 0.0 < record.bound < 0.1 * before.bound
    assert record.lower_bound < chordal_cost(graph, poses)


@pytest.mark.long
def test_where_no_climb_lowers_the_cost_the_relaxation_is_loose():
    n, rng = 30, np.random.default_rng(0)
    steps = se3.exp(0.2 * rng.normal(size=(n, 6)))
    edges = [(k, (k + 1) % n) for k in range(n)]
    graph = PoseGraph(n, edges, steps, [np.eye(6)] * n, np.arange(n) < n - 1)
    _, record = solve_certified(graph, np.stack([se3.identity()] * n))
    assert record.verdict is Verdict.NOT_CERTIFIED and record.stop is Stop.LOOSE
    assert 0.0 < record.bound < 0.1 * record.cost


def test_its_lower_bound_is_the_value_of_the_semidefinite_relaxation(seed):
    graph, truth, _ = ring(se3, 10, seed, 0.8, reach=0.0)
    _, record = solve_certified(graph, truth)
    q = marginalised(data_matrix(graph), 3)
    assert record.lower_bound == pytest.approx(solve_sdp(q, 3).value, rel=1e-6)


@pytest.mark.parametrize("extra", [0, 1])
def test_rounding_moves_the_map_as_a_whole_to_where_pose_0_was(group, extra):
    graph, truth, _ = ring(group, 8, 1, 0.1)
    rng = np.random.default_rng(extra)
    map_ = group.compose(truth, group.exp(rng.normal(size=(8, group.DOF))))
    d = group.DIMENSION
    frame = np.linalg.qr(rng.normal(size=(d + extra, d)))[0]
    like = group.compose(group.exp(rng.normal(size=group.DOF)), truth)
    poses = rounded(graph, frame @ chordal.pose_blocks(map_), like)
    np.testing.assert_array_equal(poses[0], like[0])
    assert_same_poses(group, group.between(poses[0], poses), group.between(map_[0], map_))


def test_weights_take_edges_out(group):
    graph, truth, twisted = ring(group, 6, 2, 0.1, chords=2)
    weights = np.where(np.arange(8) == 6, 0.0, 0.7)
    _, record = solve_certified(graph, twisted, weights)
    assert record.verdict is Verdict.CERTIFIED
    assert record.cost == pytest.approx(certify(graph, truth, weights)[1].cost, rel=1e-9)


def test_without_climbs_it_stays_and_bad_input_is_refused(group):
    graph, _, twisted = ring(group, 5, 3, 0.05)
    assert solve_certified(graph, twisted, max_climbs=0)[1].verdict is Verdict.NOT_CERTIFIED
    with pytest.raises(ValueError, match="max_climbs is -1"):
        solve_certified(graph, twisted, max_climbs=-1)
