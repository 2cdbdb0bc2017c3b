"""The chordal problem: one quadratic form, whatever way it is written."""

import numpy as np
import pytest
from robust_slam.certificates import chordal
from robust_slam.graphs import PoseGraph
from robust_slam.graphs.pose_graph import precisions
from robust_slam.groups import se3

from ..worlds import random_graph
from .dense import data_matrix, lift


def summed_cost(graph, poses, weights):
    group, total = graph.group, 0.0
    kappa, tau = precisions(graph)
    turn, place = group.rotation(poses), group.translation(poses)
    for k, (i, j) in enumerate(graph.edges):
        z = graph.measurement[k]
        turned = turn[j] - turn[i] @ group.rotation(z)
        moved = place[j] - place[i] - turn[i] @ group.translation(z)
        total += weights[k] * (kappa[k] * np.sum(turned**2) + tau[k] * np.sum(moved**2))
    return total


@pytest.mark.parametrize(
    ("information", "kappa", "tau"),
    [
        # tr diag(4, 1)⁻¹ = 5/4, so τ = 2 / (5/4) = 8/5; what couples t and θ is left out.
        ([[4.0, 0.0, 0.5], [0.0, 1.0, 0.2], [0.5, 0.2, 9.0]], 9.0, 1.6),
        # [[2, 1], [1, 2]]⁻¹ = [[2, -1], [-1, 2]] / 3, so τ = 2 / (4/3) = 3/2, and not 2.
        ([[2.0, 1.0, 0.0], [1.0, 2.0, 0.0], [0.0, 0.0, 1.0]], 1.0, 1.5),
        # τ = 3 / (1 + 1/4 + 1/4) = 2 and κ = 3 / (2 (1/2 + 1/4 + 1/4)) = 3/2.
        (np.diag([1.0, 4.0, 4.0, 2.0, 4.0, 4.0]), 1.5, 2.0),
    ],
    ids=["plane", "coupled positions", "space"],
)
def test_precisions_by_hand(information, kappa, tau):
    poses = np.zeros((2, 3)) if len(information) == 3 else np.stack([se3.identity()] * 2)
    graph = PoseGraph(2, [[0, 1]], poses[:1], [information], [True])
    np.testing.assert_allclose(np.ravel(precisions(graph)), [kappa, tau], rtol=1e-14)


def test_the_quadratic_form_is_the_summed_cost(group, seed):
    poses, graph = random_graph(seed, group)
    weights = np.random.default_rng(seed).uniform(0.1, 1.0, len(graph.edges))
    weights[7] = 0.0
    x, m = lift(poses), data_matrix(graph, weights)
    expected = summed_cost(graph, poses, weights)
    assert np.trace(x @ (m @ x.T)) == pytest.approx(expected, rel=1e-12)
    assert chordal.chordal_cost(graph, poses, weights) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("extra", [0, 1, 3])
def test_project_undoes_lift_at_any_rank_up_to_one_motion(group, extra):
    poses, _ = random_graph(6, group)
    d = group.DIMENSION
    rng = np.random.default_rng(extra)
    frame = np.linalg.qr(rng.normal(size=(d + extra, d)))[0]
    back = chordal.project(frame @ chordal.pose_blocks(poses))
    relative = group.between(back[0], back)
    np.testing.assert_allclose(relative, group.between(poses[0], poses), atol=1e-9)


def test_project_turns_a_mirrored_map_round(group):
    poses, graph = random_graph(7, group)
    mirror = np.eye(group.DIMENSION)
    mirror[0, 0] = -1.0
    back = chordal.project(mirror @ chordal.pose_blocks(poses))
    cost, expected = (chordal.chordal_cost(graph, each) for each in (back, poses))
    assert cost == pytest.approx(expected, rel=1e-10)
