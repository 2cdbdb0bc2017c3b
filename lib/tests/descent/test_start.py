"""First poses: exact without noise, indifferent to names and frames, near with noise."""

from dataclasses import replace

import numpy as np
import pytest
from robust_slam.certificates.chordal import chordal_cost
from robust_slam.descent.start import chordal
from robust_slam.errors import Underdetermined
from robust_slam.graphs import spanning_tree
from robust_slam.graphs.pose_graph import precisions

from ..worlds import assert_rotations, assert_same_poses, chain_with_closures, random_poses


@pytest.fixture(params=[spanning_tree, chordal])
def start(request):
    return request.param


@pytest.mark.parametrize("odometry", [True, False])
def test_without_noise_it_is_the_truth_seen_from_pose_0(group, start, seed, odometry):
    truth, graph = chain_with_closures(group, seed, odometry=odometry)
    assert_same_poses(group, start(graph), group.between(truth[0], truth))


def test_poses_with_turned_axes_come_out_turned(group, start, seed):
    _, graph = chain_with_closures(group, seed, noise=0.3)
    turn = random_poses(group, graph.n, np.random.default_rng(seed), reach=0.0)
    i, j = graph.edges.T
    z = group.compose(group.compose(group.inverse(turn[i]), graph.measurement), turn[j])
    seen = group.compose(group.compose(group.inverse(turn[0]), start(graph)), turn)
    assert_same_poses(group, start(replace(graph, measurement=z)), seen)


def test_in_other_units_only_the_positions_change(group, start):
    _, graph = chain_with_closures(group, 4, noise=0.3)
    z = group.from_parts(graph.rotation, 100.0 * graph.translation)
    unit = np.repeat([100.0, 1.0], [group.DIMENSION, group.DOF - group.DIMENSION])
    poses = start(graph)
    expected = group.from_parts(group.rotation(poses), 100.0 * group.translation(poses))
    information = graph.information / np.outer(unit, unit)
    got = start(replace(graph, measurement=z, information=information))
    assert_same_poses(group, got, expected, atol=1e-8)


def relaxed_rotations(graph, weights):
    """The same least squares, dense: one row of blocks for each edge, R_0 on the right."""
    d, m = graph.group.DIMENSION, len(graph.edges)
    rows = np.zeros((m, d, graph.n, d))
    scale = np.sqrt(weights * precisions(graph)[0])
    for k, (i, j) in enumerate(graph.edges):
        rows[k, :, j] += scale[k] * np.eye(d)
        rows[k, :, i] -= scale[k] * graph.rotation[k].T
    flat = rows.reshape(m * d, graph.n * d)
    free = np.linalg.lstsq(flat[:, d:], -flat[:, :d], rcond=None)[0]
    return np.concatenate([np.eye(d)[None], np.swapaxes(free.reshape(-1, d, d), 1, 2)])


def test_chordal_rotations_are_nearest_to_the_relaxation_and_no_positions_do_better(group, seed):
    _, graph = chain_with_closures(group, seed, noise=1.0)
    weights = np.random.default_rng(seed).uniform(0.1, 2.0, len(graph.edges))
    weights[-3:] = 0.0
    relaxed = relaxed_rotations(graph, weights)
    poses = chordal(graph, weights)
    found = group.rotation(poses)
    assert_rotations(found)
    # R is the rotation nearest to X exactly if RᵀX is symmetric and the sum of any two of
    # its eigenvalues is not negative.
    polar = np.swapaxes(found, 1, 2) @ relaxed
    np.testing.assert_allclose(polar, np.swapaxes(polar, 1, 2), atol=1e-9)
    assert np.all(np.linalg.eigvalsh(polar)[:, :2].sum(axis=1) > 0.0)
    least = chordal_cost(graph, poses, weights)
    place, rng = group.translation(poses), np.random.default_rng(seed)
    for size in (1e-3, 1.0):
        moved = group.from_parts(found, place + size * rng.normal(size=place.shape))
        assert chordal_cost(graph, moved, weights) > least


@pytest.mark.parametrize("weight", [1e-300, 1e-15])
def test_a_map_that_hangs_on_next_to_nothing_is_told(group, seed, weight):
    _, graph = chain_with_closures(group, seed, n=6, closures=0)
    with pytest.raises(Underdetermined, match="singular to working precision"):
        chordal(graph, [1.0, weight, 1.0, 1.0, 1.0])
