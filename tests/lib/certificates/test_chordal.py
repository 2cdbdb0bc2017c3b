"""The chordal problem: one quadratic form, whatever way it is written."""

from __future__ import annotations

import numpy as np
import pytest
from robust_slam.certificates import chordal
from robust_slam.certificates.chordal import ChordalProblem
from robust_slam.errors import Underdetermined
from robust_slam.graphs import pose_graph, se3
from robust_slam.graphs.isotropic import precisions
from robust_slam.graphs.pose_graph import PoseGraph
from robust_slam.graphs.rotations import nearest_rotations


def random_graph(group, seed, n=6, m=9, residual=0.5):
    """Poses and a connected graph whose residuals have about the given size."""
    rng = np.random.default_rng(seed)
    poses = group.exp(2.0 * rng.normal(size=(n, group.DOF)))
    tree = [(int(rng.integers(k)), k) for k in range(1, n)]
    loops = [tuple(rng.permutation(n)[:2]) for _ in range(m - n + 1)]
    edges = np.array(tree + loops)
    error = residual * rng.uniform(-1.0, 1.0, size=(m, group.DOF))
    true = group.between(poses[edges[:, 0]], poses[edges[:, 1]])
    root = rng.normal(size=(m, group.DOF, group.DOF))
    information = root @ np.swapaxes(root, 1, 2) + np.eye(group.DOF)
    measurement = group.compose(true, group.exp(error))
    return poses, PoseGraph(n, edges, measurement, information, np.arange(m) < n - 1)


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


def test_precisions_in_the_plane_by_hand():
    # tr diag(4, 1)⁻¹ = 5/4, so τ = 2 / (5/4) = 8/5; what couples t and θ is left out.
    information = np.array([[4.0, 0.0, 0.5], [0.0, 1.0, 0.2], [0.5, 0.2, 9.0]])
    graph = PoseGraph(2, [[0, 1]], np.zeros((1, 3)), [information], [True])
    kappa, tau = precisions(graph)
    np.testing.assert_allclose([kappa[0], tau[0]], [9.0, 1.6], rtol=1e-14)


def test_precisions_in_space_by_hand():
    # τ = 3 / (1 + 1/4 + 1/4) = 2 and κ = 3 / (2 (1/2 + 1/4 + 1/4)) = 3/2.
    information = np.diag([1.0, 4.0, 4.0, 2.0, 4.0, 4.0])
    graph = PoseGraph(2, [[0, 1]], se3.identity()[None], [information], [True])
    kappa, tau = precisions(graph)
    np.testing.assert_allclose([kappa[0], tau[0]], [1.5, 2.0], rtol=1e-14)


def test_tau_inverts_the_whole_block_not_its_diagonal():
    # [[2, 1], [1, 2]]⁻¹ = [[2, -1], [-1, 2]] / 3, so τ = 2 / (4/3) = 3/2, and not 2.
    information = np.array([[2.0, 1.0, 0.0], [1.0, 2.0, 0.0], [0.0, 0.0, 1.0]])
    graph = PoseGraph(2, [[0, 1]], np.zeros((1, 3)), [information], [True])
    assert precisions(graph)[1][0] == pytest.approx(1.5, rel=1e-14)


def test_small_residuals_cost_what_the_logarithm_says_but_angles_in_the_plane_twice(group):
    d, e = group.DIMENSION, 1e-4
    count = [1.0] * d + ([2.0] if d == 2 else [1.0] * 3)
    for axis in range(group.DOF):
        z = group.exp(e * np.eye(group.DOF)[axis])[None]
        graph = PoseGraph(2, [[0, 1]], z, [4.0 * np.eye(group.DOF)], [True])
        poses = np.stack([group.identity()] * 2)
        logarithm = 2.0 * pose_graph.cost(poses, graph)
        assert chordal.chordal_cost(graph, poses) == pytest.approx(
            count[axis] * logarithm, rel=1e-6
        )


def test_the_quadratic_form_is_the_summed_cost(group, seed):
    poses, graph = random_graph(group, seed)
    weights = np.random.default_rng(seed).uniform(0.1, 1.0, len(graph.edges))
    x, m = chordal.lift(poses), chordal.data_matrix(graph, weights)
    expected = summed_cost(graph, poses, weights)
    assert np.trace(x @ (m @ x.T)) == pytest.approx(expected, rel=1e-12)
    assert chordal.chordal_cost(graph, poses, weights) == pytest.approx(expected, rel=1e-12)


def test_the_data_matrix_is_symmetric_and_not_negative_and_moving_the_map_is_free(group):
    _, graph = random_graph(group, 3)
    m, d = chordal.data_matrix(graph).toarray(), group.DIMENSION
    np.testing.assert_allclose(m, m.T, atol=1e-13 * np.abs(m).max())
    assert np.linalg.eigvalsh(m)[0] > -1e-12 * np.abs(m).max()
    everywhere = np.arange(len(m)) % (d + 1) == d
    np.testing.assert_allclose(m @ everywhere, 0.0, atol=1e-12 * np.abs(m).max())


def test_a_common_motion_does_not_change_the_cost(group, seed):
    poses, graph = random_graph(group, seed)
    motion = group.exp(np.random.default_rng(seed).normal(size=group.DOF))
    assert chordal.chordal_cost(graph, group.compose(motion, poses)) == pytest.approx(
        chordal.chordal_cost(graph, poses), rel=1e-12
    )


def test_without_residuals_the_cost_is_0(group):
    poses, graph = random_graph(group, 4, residual=0.0)
    assert chordal.chordal_cost(graph, poses) < 1e-25


def test_an_edge_of_weight_0_drops_out(group):
    _, graph = random_graph(group, 5)
    kept = np.arange(len(graph.edges)) != 7
    rest = pose_graph.select(graph, kept)
    np.testing.assert_allclose(
        chordal.data_matrix(graph, kept.astype(float)).toarray(),
        chordal.data_matrix(rest).toarray(),
        rtol=1e-14,
    )
    assert len(ChordalProblem.of(graph, kept.astype(float)).edges) == len(rest.edges)


def test_half_the_gradient_of_the_cost_is_x_times_m(group, seed):
    poses, graph = random_graph(group, seed)
    problem = ChordalProblem.of(graph)
    blocks = chordal.pose_blocks(poses)
    pulls = np.zeros_like(blocks)
    np.add.at(pulls, graph.edges, chordal.edge_gradients(problem, blocks))
    product = chordal.lift(poses) @ chordal.data_matrix(graph).toarray()
    np.testing.assert_allclose(chordal.as_matrix(pulls), product, atol=1e-10)


def best_positions(graph, poses):
    """Least squares over the stacked equations t_j − t_i = R_i t̃, t_0 = 0."""
    turn, (_, tau) = graph.group.rotation(poses), precisions(graph)
    rows = np.zeros((len(graph.edges), graph.n))
    rows[np.arange(len(rows)), graph.edges[:, 1]] += 1.0
    rows[np.arange(len(rows)), graph.edges[:, 0]] -= 1.0
    moved = (turn[graph.edges[:, 0]] @ graph.translation[..., None])[..., 0]
    root = np.sqrt(tau)[:, None]
    place = np.linalg.lstsq(root * rows[:, 1:], root * moved, rcond=None)[0]
    return np.concatenate([np.zeros((1, graph.group.DIMENSION)), place])


def test_marginalised_is_the_cost_with_the_best_positions(group, seed):
    poses, graph = random_graph(group, seed)
    d = group.DIMENSION
    q = chordal.marginalised(chordal.data_matrix(graph), graph.n, d)
    turn = group.rotation(poses)
    best = group.from_parts(turn, best_positions(graph, poses))
    stacked = np.concatenate(list(turn), axis=1)
    np.testing.assert_array_equal(q, q.T)
    assert q.shape == (d * graph.n, d * graph.n)
    assert np.trace(stacked @ q @ stacked.T) == pytest.approx(
        chordal.chordal_cost(graph, best), rel=1e-10
    )


@pytest.mark.parametrize("extra", [0, 1, 3])
def test_project_undoes_lift_at_any_rank_up_to_one_motion(group, extra):
    poses, graph = random_graph(group, 6)
    d = group.DIMENSION
    rng = np.random.default_rng(extra)
    frame = np.linalg.qr(rng.normal(size=(d + extra, d)))[0]
    back = chordal.project(frame @ chordal.lift(poses), graph.n)
    relative = group.between(back[0], back)
    np.testing.assert_allclose(relative, group.between(poses[0], poses), atol=1e-9)


def test_project_turns_a_mirrored_map_round(group):
    poses, graph = random_graph(group, 7)
    mirror = np.eye(group.DIMENSION)
    mirror[0, 0] = -1.0
    back = chordal.project(mirror @ chordal.lift(poses), graph.n)
    assert chordal.chordal_cost(graph, back) == pytest.approx(
        chordal.chordal_cost(graph, poses), rel=1e-10
    )


@pytest.mark.parametrize("d", [2, 3])
def test_the_nearest_rotation_is_a_rotation_and_none_is_nearer(d, seed):
    rng = np.random.default_rng(seed)
    matrices = rng.normal(size=(40, d, d))
    nearest = nearest_rotations(matrices)
    np.testing.assert_allclose(
        nearest @ np.swapaxes(nearest, 1, 2), np.broadcast_to(np.eye(d), (40, d, d)), atol=1e-12
    )
    np.testing.assert_allclose(np.linalg.det(nearest), 1.0)
    others = nearest_rotations(rng.normal(size=(500, 1, d, d)))
    distance = np.linalg.norm(nearest - matrices, axis=(1, 2))
    assert np.all(distance <= np.linalg.norm(others - matrices, axis=(2, 3)) + 1e-12)
    np.testing.assert_allclose(nearest_rotations(nearest), nearest, atol=1e-12)


def test_matrix_and_blocks_are_two_views_of_x(group):
    poses, graph = random_graph(group, 8)
    blocks = chordal.pose_blocks(poses)
    x = chordal.lift(poses)
    d = group.DIMENSION
    np.testing.assert_array_equal(x[:, d + 1 : 2 * d + 1], group.rotation(poses[1]))
    np.testing.assert_array_equal(x[:, 2 * d + 1], group.translation(poses[1]))
    np.testing.assert_array_equal(chordal.as_blocks(x, graph.n), blocks)


def test_bad_input_is_refused_by_name(group):
    poses, graph = random_graph(group, 9)
    m = len(graph.edges)
    with pytest.raises(ValueError, match="poses: the shape"):
        chordal.chordal_cost(graph, poses[:-1])
    with pytest.raises(ValueError, match="weights: the shape"):
        chordal.chordal_cost(graph, poses, np.ones(m + 1))
    with pytest.raises(ValueError, match="weights: edge 0 weighs less than 0"):
        chordal.data_matrix(graph, np.arange(m) - 1.0)
    with pytest.raises(Underdetermined, match="poses are loose"):
        chordal.data_matrix(graph, np.zeros(m))
    with pytest.raises(ValueError, match="matrix: the shape"):
        chordal.marginalised(chordal.data_matrix(graph), graph.n + 1, group.DIMENSION)
    with pytest.raises(ValueError, match="matrix: the shape"):
        chordal.project(np.zeros((3, 7)), graph.n)
    with pytest.raises(ValueError, match="matrix: it has 1 rows"):
        chordal.project(chordal.lift(poses)[:1], graph.n)
