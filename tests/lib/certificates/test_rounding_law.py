"""No shift certifies a wrong map: the verdict follows from the bound on the gap."""

from __future__ import annotations

import numpy as np
import pytest
from robust_slam.certificates.optimality import Verdict, certificate, certify
from robust_slam.graphs import se2, se3
from robust_slam.graphs.pose_graph import PoseGraph

both_groups = pytest.mark.parametrize("group", [se2, se3], ids=["se2", "se3"])


def twisted_ring(group, n, kappa=1.0):
    """A ring of ``n`` exact measurements, closed with ``kappa``; its map twisted once."""
    edges = [(k, (k + 1) % n) for k in range(n)]
    z = np.stack([group.identity()] * n)
    information = np.tile(np.eye(group.DOF), (n, 1, 1))
    information[0] *= kappa
    turn = np.zeros((n, group.DOF))
    turn[:, -1] = 2.0 * np.pi * np.arange(n) / n
    return PoseGraph(n, edges, z, information, np.arange(n) < n - 1), group.exp(turn)


@both_groups
@pytest.mark.parametrize("eta", [None, 1e-300, 1e-15, 1e-9, 1e-3, 0.3, 10.0, 1e6, 1e300])
def test_no_eta_certifies_a_ring_that_is_twisted_once(group, eta):
    graph, twisted = twisted_ring(group, 12)
    record = certificate(graph, twisted, eta=eta)
    # The optimum costs 0, so the gap is the cost.
    assert record.verdict is Verdict.NOT_CERTIFIED
    assert record.cost > 1.0
    assert record.bound == pytest.approx(record.cost, rel=1e-12) or record.bound > record.cost


@both_groups
def test_a_single_heavy_edge_does_not_hide_a_twist_behind_rounding(group):
    # A shift of 1e-12 of the *mean* of M would exceed all other entries.
    graph, twisted = twisted_ring(group, 12, kappa=1e14)
    twisted[1] = twisted[0]
    record = certify(graph, twisted)[1]
    assert record.cost > 1.0
    assert record.verdict is Verdict.NOT_CERTIFIED


@both_groups
@pytest.mark.parametrize("eta", [None, 1e-12, 1e-11])
def test_an_optimal_map_is_certified_with_any_shift_at_rounding_level(group, eta):
    graph, _ = twisted_ring(group, 12)
    still = np.stack([group.identity()] * 12)
    assert certificate(graph, still, eta=eta).verdict is Verdict.CERTIFIED


@both_groups
def test_a_larger_shift_proves_less(group):
    rng = np.random.default_rng(0)
    graph, _ = twisted_ring(group, 8)
    noisy = group.compose(graph.measurement, group.exp(0.1 * rng.normal(size=(8, group.DOF))))
    graph = PoseGraph(8, graph.edges, noisy, graph.information, graph.is_odometry)
    poses, record = certify(graph, np.stack([group.identity()] * 8))
    wide = certificate(graph, poses, eta=1e-3)
    assert record.verdict is Verdict.CERTIFIED
    assert wide.verdict is Verdict.NOT_CERTIFIED
    d = group.DIMENSION
    assert record.cost - wide.lower_bound == pytest.approx(1e-3 * d * 8, rel=1e-6)
