"""First poses: exact without noise, indifferent to names and frames, near with noise."""

from __future__ import annotations

from functools import reduce

import numpy as np
import pytest
from robust_slam.certificates.chordal import chordal_cost
from robust_slam.descent.start import chordal
from robust_slam.descent.undamped import gauss_newton
from robust_slam.errors import Underdetermined
from robust_slam.graphs import pose_graph
from robust_slam.graphs.generate import Noise, manhattan
from robust_slam.graphs.isotropic import precisions
from robust_slam.graphs.odometry import spanning_tree
from robust_slam.graphs.pose_graph import PoseGraph, select

STARTS = pytest.mark.parametrize("start", [spanning_tree, chordal])


def twists(group, rng, count, place, turn):
    """Tangent vectors whose parts have about the given sizes, in m and rad."""
    d = group.DIMENSION
    return rng.normal(size=(count, group.DOF)) * np.repeat([place, turn], [d, group.DOF - d])


def isotropic(group, place, turn):
    """Information matrices ``(m, D, D)`` from one number for each part of each edge."""
    d = group.DIMENSION
    entries = np.repeat(np.stack([place, turn], axis=1), [d, group.DOF - d], axis=1)
    return entries[:, :, None] * np.eye(group.DOF)


def random_graph(group, seed, n=12, closures=10, noise=0.0, odometry=True):
    """Poses, the first not at the identity, and a graph over them with edges both ways."""
    rng = np.random.default_rng(seed)
    truth = group.exp(twists(group, rng, n, 3.0, 1.0))
    chain = np.stack([np.arange(n - 1), np.arange(1, n)], axis=1)
    loops = np.array([rng.permutation(n)[:2] for _ in range(closures)]).reshape(-1, 2)
    edges = np.concatenate([chain, loops.astype(np.intp)])
    error = group.exp(twists(group, rng, len(edges), noise, 0.2 * noise))
    z = group.compose(group.between(truth[edges[:, 0]], truth[edges[:, 1]]), error)
    flags = odometry & (np.arange(len(edges)) < n - 1)
    information = isotropic(group, *rng.uniform(1.0, 50.0, size=(2, len(edges))))
    return truth, PoseGraph(n, edges, z, information, flags)


def rebuilt(graph, **changes):
    names = ("n", "edges", "measurement", "information", "is_odometry")
    return PoseGraph(**({name: getattr(graph, name) for name in names} | changes))


def assert_same_poses(group, a, b, atol=1e-9):
    np.testing.assert_allclose(group.log(group.between(a, b)), 0.0, atol=atol)


@STARTS
@pytest.mark.parametrize("odometry", [True, False])
def test_without_noise_it_is_the_truth_seen_from_pose_0(group, start, seed, odometry):
    truth, graph = random_graph(group, seed, odometry=odometry)
    assert_same_poses(group, start(graph), group.between(truth[0], truth))


@STARTS
def test_pose_0_is_the_identity(group, start):
    _, graph = random_graph(group, 0, noise=0.3)
    np.testing.assert_array_equal(start(graph)[0], group.identity())


@STARTS
def test_two_poses_and_one_edge_backwards(group, start):
    z = group.exp(twists(group, np.random.default_rng(1), 1, 2.0, 1.0))
    graph = PoseGraph(2, [[1, 0]], z, [np.eye(group.DOF)], [False])
    assert_same_poses(group, start(graph)[1], group.inverse(z[0]))


def test_with_complete_odometry_the_tree_is_dead_reckoning_whatever_closures_say(group, seed):
    _, graph = random_graph(group, seed, n=200, closures=40, noise=1.0)
    steps = graph.measurement[:199]
    walked = [group.identity()]
    for step in steps:
        walked.append(group.compose(walked[-1], step))
    assert_same_poses(group, spanning_tree(graph), np.array(walked), atol=1e-8)


def test_the_tree_takes_few_closures_then_few_edges_then_the_first_edge(group):
    edges = [[0, 1], [1, 2], [4, 3], [0, 2], [2, 4], [3, 0], [0, 3], [4, 5]]
    is_odometry = [True, True, True, False, False, False, False, True]
    z = group.exp(twists(group, np.random.default_rng(2), 8, 1.0, 0.5))
    graph = PoseGraph(6, edges, z, [np.eye(group.DOF)] * 8, is_odometry)
    # Pose 2 over the odometry, not over the closure 0–2. One closure leads on, at the
    # best at once from pose 0 to 3, by edge 5, which comes before its twin 6.
    paths = {1: [0], 2: [0, 1], 3: [~5], 4: [~5, ~2], 5: [~5, ~2, 7]}
    poses = spanning_tree(graph)
    for pose, path in paths.items():
        steps = [z[k] if k >= 0 else group.inverse(z[~k]) for k in path]
        assert_same_poses(group, poses[pose], reduce(group.compose, steps), atol=1e-12)


def test_only_whether_a_weight_is_0_matters_to_the_tree(group):
    _, graph = random_graph(group, 3, noise=0.5, odometry=False)
    weights = np.where(np.arange(21) % 4 == 1, 0.0, np.linspace(0.01, 3.0, 21))
    left = select(graph, weights > 0.0)
    np.testing.assert_array_equal(spanning_tree(graph, weights), spanning_tree(left))


def test_turning_edges_round_changes_nothing_for_the_tree(group, seed):
    _, graph = random_graph(group, seed, noise=0.5)
    back = rebuilt(graph, edges=graph.edges[:, ::-1], measurement=group.inverse(graph.measurement))
    assert_same_poses(group, spanning_tree(back), spanning_tree(graph))


@STARTS
def test_other_numbers_for_the_poses_change_nothing_else(group, start, seed):
    _, graph = random_graph(group, seed, noise=0.3)
    name = np.concatenate([[0], 1 + np.random.default_rng(seed).permutation(graph.n - 1)])
    renamed = rebuilt(graph, edges=name[graph.edges])
    assert_same_poses(group, start(renamed)[name], start(graph))


@STARTS
def test_poses_with_turned_axes_come_out_turned(group, start, seed):
    _, graph = random_graph(group, seed, noise=0.3)
    turn = group.exp(twists(group, np.random.default_rng(seed), graph.n, 0.0, 2.0))
    i, j = graph.edges.T
    z = group.compose(group.compose(group.inverse(turn[i]), graph.measurement), turn[j])
    seen = group.compose(group.compose(group.inverse(turn[0]), start(graph)), turn)
    assert_same_poses(group, start(rebuilt(graph, measurement=z)), seen)


@STARTS
def test_in_other_units_only_the_positions_change(group, start):
    _, graph = random_graph(group, 4, noise=0.3)
    z = group.from_parts(graph.rotation, 100.0 * graph.translation)
    unit = np.repeat([100.0, 1.0], [group.DIMENSION, group.DOF - group.DIMENSION])
    poses = start(graph)
    expected = group.from_parts(group.rotation(poses), 100.0 * group.translation(poses))
    information = graph.information / np.outer(unit, unit)
    got = start(rebuilt(graph, measurement=z, information=information))
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


def test_chordal_rotations_are_nearest_to_the_dense_relaxation(group, seed):
    _, graph = random_graph(group, seed, noise=1.0)
    weights = np.random.default_rng(seed).uniform(0.1, 2.0, len(graph.edges))
    relaxed = relaxed_rotations(graph, weights)
    found = group.rotation(chordal(graph, weights))
    d = group.DIMENSION
    np.testing.assert_allclose(
        found @ np.swapaxes(found, 1, 2), np.tile(np.eye(d), (12, 1, 1)), atol=1e-12
    )
    np.testing.assert_allclose(np.linalg.det(found), 1.0, atol=1e-12)
    # R is the rotation nearest to X exactly if RᵀX is symmetric and the sum of any two of
    # its eigenvalues is not negative.
    polar = np.swapaxes(found, 1, 2) @ relaxed
    np.testing.assert_allclose(polar, np.swapaxes(polar, 1, 2), atol=1e-9)
    assert np.all(np.linalg.eigvalsh(polar)[:, :2].sum(axis=1) > 0.0)


def test_no_other_positions_do_better_with_the_chordal_rotations(group, seed):
    _, graph = random_graph(group, seed, noise=1.0)
    weights = np.random.default_rng(seed).uniform(0.1, 2.0, len(graph.edges))
    poses = chordal(graph, weights)
    least = chordal_cost(graph, poses, weights)
    turn, place = group.rotation(poses), group.translation(poses)
    rng = np.random.default_rng(seed)
    for size in (1e-3, 1.0):
        moved = group.from_parts(turn, place + size * rng.normal(size=place.shape))
        assert chordal_cost(graph, moved, weights) > least


@pytest.mark.parametrize("seed", range(6))
def test_with_noise_the_chordal_start_costs_less_than_the_tree(group, seed):
    _, graph = random_graph(group, seed, n=40, closures=40, noise=0.3)
    there = pose_graph.cost(chordal(graph), graph)
    assert there < 0.2 * pose_graph.cost(spanning_tree(graph), graph)


@pytest.mark.parametrize("seed", [1, 4])
def test_from_the_tree_gauss_newton_may_end_in_a_minimum_that_chordal_avoids(seed):
    sigma = (0.3, 0.3, 0.15)
    graph, _ = manhattan(100, np.random.default_rng(seed), noise=Noise(sigma, sigma))
    high, low = (
        pose_graph.cost(gauss_newton(graph, start(graph)), graph)
        for start in (spanning_tree, chordal)
    )
    assert high > 5.0 * low


def test_a_weight_multiplies_the_information_and_0_leaves_out(group):
    _, graph = random_graph(group, 5, noise=0.5)
    weights = np.where(np.arange(21) % 5 == 4, 0.0, np.linspace(0.2, 2.0, 21))
    weights[:11] = 0.5
    kept = weights > 0.0
    scaled = select(
        rebuilt(
            graph, information=np.where(kept, weights, 1.0)[:, None, None] * graph.information
        ),
        kept,
    )
    assert_same_poses(group, chordal(graph, weights), chordal(scaled))


@STARTS
@pytest.mark.parametrize(
    ("weights", "told"),
    [
        (np.ones(3), "weights: the shape"),
        (np.full(21, np.nan), "weights: the entry"),
        (np.where(np.arange(21) == 7, -0.5, 1.0), "weights: edge 7 weighs less than 0"),
    ],
)
def test_weights_that_are_none_are_refused(group, start, weights, told):
    _, graph = random_graph(group, 6)
    with pytest.raises(ValueError, match=told):
        start(graph, weights)


@STARTS
def test_a_pose_that_weights_cut_off_is_named(group, start):
    _, graph = random_graph(group, 7, closures=0)
    weights = np.where(np.arange(11) == 4, 0.0, 1.0)
    with pytest.raises(Underdetermined, match=r"joins pose 5 to pose 0 \(7 poses are loose\)"):
        start(graph, weights)


@pytest.mark.parametrize("weight", [1e-300, 1e-15])
def test_a_map_that_hangs_on_next_to_nothing_is_told(group, seed, weight):
    _, graph = random_graph(group, seed, n=6, closures=0)
    with pytest.raises(Underdetermined, match="singular to working precision"):
        chordal(graph, [1.0, weight, 1.0, 1.0, 1.0])


def test_a_map_that_hangs_on_little_is_still_exact_without_noise(group, seed):
    truth, graph = random_graph(group, seed, n=6, closures=0)
    poses = chordal(graph, [1.0, 1e-4, 1.0, 1.0, 1e4])
    assert_same_poses(group, poses, group.between(truth[0], truth), atol=1e-6)
