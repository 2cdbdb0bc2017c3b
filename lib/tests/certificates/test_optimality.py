"""Certificates: exact eigenvalues, the right bound, and what a certificate does not say."""

from dataclasses import replace

import numpy as np
import pytest
from robust_slam.certificates import Verdict, certificate, certify, chordal
from robust_slam.certificates.chordal import ChordalProblem, chordal_cost
from robust_slam.certificates.newton import polish
from robust_slam.graphs import se2, se3
from robust_slam.graphs.pose_graph import PoseGraph

from ..worlds import about_z, refused, ring, unit_information
from .dense import lift, marginalised


def turning_cycle(group, n, angle):
    """A cycle of ``n`` equal rotations, every pose at the same place."""
    edges = [(k, (k + 1) % n) for k in range(n)]
    z = group.from_parts(about_z(group, np.full(n, angle)), np.zeros((n, group.DIMENSION)))
    information = np.tile(unit_information(group), (n, 1, 1))
    return PoseGraph(n, edges, z, information, np.arange(n) < n - 1)


def dense_certificate(graph, poses, weights=None):
    """S with the positions, and S_R without them."""
    problem = ChordalProblem.of(graph, weights)
    blocks = chordal.certificate_blocks(problem, chordal.pose_blocks(poses))
    s = chordal.assemble(problem, blocks).toarray()
    return s, marginalised(s, graph.group.DIMENSION)


def test_at_a_stationary_point_s_x_is_0_and_d_eigenvalues_of_0_certify(group, seed):
    graph, truth, twisted = ring(group, 6, seed, 0.1, chords=2)
    poses, record = certify(graph, truth)
    for stationary in (polish(graph, twisted), poses):
        s, s_r = dense_certificate(graph, stationary)
        stacked = np.concatenate(list(group.rotation(stationary)), axis=1)
        np.testing.assert_allclose(s @ lift(stationary).T, 0.0, atol=1e-11)
        np.testing.assert_allclose(s_r @ stacked.T, 0.0, atol=1e-11)
    values, d = np.linalg.eigvalsh(s_r), group.DIMENSION
    np.testing.assert_allclose(values[:d], 0.0, atol=1e-12)
    assert values[d] > 0.1
    assert record.verdict is Verdict.CERTIFIED
    assert abs(record.lambda_min) < 1e-12
    assert record.direction is None
    assert 0.0 <= record.bound < 1e-8
    assert record.cost == pytest.approx(chordal_cost(graph, poses), rel=1e-14)


@pytest.mark.parametrize("n", [6, 40])
@pytest.mark.parametrize("twist", [False, True])
def test_the_sparse_eigenvalue_is_the_dense_one(group, n, twist):
    # 80 and 120 unknowns are beyond the dense solver's limit, 12 and 18 are not.
    graph, truth, twisted = ring(group, n, 3, 0.01)
    poses = polish(graph, twisted if twist else truth)
    record = certificate(graph, poses)
    s, s_r = dense_certificate(graph, poses)
    assert record.lambda_min == pytest.approx(np.linalg.eigvalsh(s_r)[0], rel=1e-8, abs=1e-12)
    assert (record.direction is not None) == twist
    if twist:
        row = record.direction.ravel()
        assert np.linalg.norm(record.direction[:, :-1]) == pytest.approx(1.0, rel=1e-12)
        assert row @ s @ row == pytest.approx(record.lambda_min, rel=1e-8)


def test_the_twisted_five_cycle_is_refused_and_its_bound_is_its_gap():
    # No noise, so the least cost is 0; the twisted state costs 10 (2 − 2 cos 72°).
    graph = turning_cycle(se2, 5, 0.0)
    twisted = np.zeros((5, 3))
    twisted[:, 2] = 2.0 * np.pi * np.arange(5) / 5
    poses, record = certify(graph, twisted)
    gap = 10.0 * (2.0 - 2.0 * np.cos(np.radians(72.0)))
    assert gap == pytest.approx(13.819660, rel=1e-7)
    np.testing.assert_allclose(se2.wrap(poses - twisted), 0.0, atol=1e-12)
    assert record.verdict is Verdict.NOT_CERTIFIED
    assert record.stationarity < 1e-14
    assert record.cost == pytest.approx(gap, rel=1e-12)
    assert record.bound == pytest.approx(gap, rel=1e-9)
    assert record.lambda_min == pytest.approx(-gap / 10.0, rel=1e-9)


@pytest.mark.parametrize(
    ("group", "n", "reach"), [(se2, 5, 1.0), (se2, 8, 1.0), (se3, 8, 3.0), (se3, 12, 3.0)]
)
@pytest.mark.parametrize("seed", range(4))
def test_the_bound_of_the_s_with_positions_is_too_small_and_ours_is_not(group, n, reach, seed):
    # In space the twist leaves a third of the rotations' columns alone, so that the bound
    # has room to be wrong in; long arms give the positions more of the eigenvector.
    graph, truth, twisted = ring(group, n, seed, 0.02, reach=reach)
    best, proof = certify(graph, truth)
    poses, record = certify(graph, twisted)
    assert proof.verdict is Verdict.CERTIFIED
    assert record.verdict is Verdict.NOT_CERTIFIED
    gap = record.cost - chordal_cost(graph, best)
    s, _ = dense_certificate(graph, poses)
    wrong = -group.DIMENSION * n * np.linalg.eigvalsh(s)[0]
    assert 0.0 < wrong < gap <= record.bound


@pytest.mark.parametrize("seed", range(6))
def test_the_bound_holds_at_any_map(group, seed):
    graph, truth, _ = ring(group, 6, seed, 0.1, chords=2)
    _, best = certify(graph, truth)
    rng = np.random.default_rng(seed)
    anywhere = group.compose(truth, group.exp(rng.normal(size=(6, group.DOF)) * 10.0**-seed))
    record = certificate(graph, anywhere)
    assert record.verdict is Verdict.NOT_STATIONARY
    assert record.lower_bound <= best.cost * (1.0 + 1e-12)
    floor = max(0.0, record.lower_bound)
    assert record.bound == pytest.approx(record.cost - floor, rel=1e-12)
    assert record.cost - record.bound <= best.cost * (1.0 + 1e-12)


def test_a_cholesky_test_that_passes_where_positions_are_wrong_is_no_certificate(group):
    # All measured positions are 0, so S does not know of the map's positions at all: it is
    # that of the truth, and passes with any shift.
    graph = turning_cycle(group, 5, 0.0)
    turn = about_z(group, np.zeros(5))
    place = np.random.default_rng(0).normal(size=(5, group.DIMENSION))
    record = certificate(graph, group.from_parts(turn, place))
    assert record.direction is None
    assert abs(record.lambda_min) < 1e-12
    assert record.verdict is Verdict.NOT_STATIONARY
    assert record.bound >= record.cost > 1.0


@refused(({"eta": 0.0}, r"eta is 0\.0"), ({"tol": -1.0}, r"tol is -1\.0"))
def test_bad_input_is_refused_by_name(wrong, message):
    graph, truth, _ = ring(se2, 5, 4, 0.1)
    with pytest.raises(ValueError, match=message):
        certificate(graph, truth, **wrong)


def twisted_ring(group, n, kappa=1.0):
    """A ring of ``n`` exact measurements, closed with ``kappa``, and its map twisted once."""
    graph = turning_cycle(group, n, 0.0)
    information = graph.information.copy()
    information[0] *= kappa
    turn = np.zeros((n, group.DOF))
    turn[:, -1] = 2.0 * np.pi * np.arange(n) / n
    return replace(graph, information=information), group.exp(turn)


@pytest.mark.parametrize("eta", [None, 1e-300, 1e-15, 1e-9, 1e-3, 0.3, 10.0, 1e6, 1e300])
def test_no_eta_certifies_a_ring_that_is_twisted_once(group, eta):
    record = certificate(*twisted_ring(group, 12), eta=eta)
    # The optimum costs 0, so the gap is the cost.
    assert record.verdict is Verdict.NOT_CERTIFIED
    assert record.cost > 1.0
    assert record.bound == pytest.approx(record.cost, rel=1e-12) or record.bound > record.cost


def test_a_single_heavy_edge_does_not_hide_a_twist_behind_rounding(group):
    # A shift of 1e-12 of the *mean* of M would exceed all other entries.
    graph, twisted = twisted_ring(group, 12, kappa=1e14)
    twisted[1] = twisted[0]
    record = certify(graph, twisted)[1]
    assert record.cost > 1.0
    assert record.verdict is Verdict.NOT_CERTIFIED


@pytest.mark.parametrize("eta", [None, 1e-12, 1e-11])
def test_an_optimal_map_is_certified_with_any_shift_at_rounding_level(group, eta):
    still = np.stack([group.identity()] * 12)
    assert certificate(turning_cycle(group, 12, 0.0), still, eta=eta).verdict is Verdict.CERTIFIED


def test_a_larger_shift_proves_less(group):
    graph, truth, _ = ring(group, 8, 0, 0.1)
    poses, record = certify(graph, truth)
    wide = certificate(graph, poses, eta=1e-3)
    assert record.verdict is Verdict.CERTIFIED
    assert wide.verdict is Verdict.NOT_CERTIFIED
    assert record.cost - wide.lower_bound == pytest.approx(8e-3 * group.DIMENSION, rel=1e-6)
