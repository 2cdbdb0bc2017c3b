"""Pairwise consistency: distances by the book, in both groups, and what the largest set is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from robust_slam.consistency.pairwise import pairwise_consistent, pairwise_distances, pcm
from robust_slam.estimators.thresholds import chi_square_threshold
from robust_slam.graphs import se2
from robust_slam.graphs.generate import Noise, circle, manhattan, sphere
from robust_slam.graphs.odometry import dead_reckoning
from robust_slam.graphs.outliers import add_aliased_closures, add_random_closures
from robust_slam.graphs.pose_graph import PoseGraph

from tests.lib.worlds import perturbed, random_information, random_poses


def wandering(seed, group, n=12, closures=6, noise=0.02):
    """A chain with long lever arms and closures in either direction, nearly exact."""
    rng = np.random.default_rng(seed)
    steps = random_poses(group, n - 1, rng, reach=5.0, turn=1.0)
    odometry = [(k, k + 1) for k in range(n - 1)]
    pairs = [tuple(rng.choice(n, size=2, replace=False)) for _ in range(closures)]
    edges = np.array(odometry + pairs)
    m = len(edges)
    information = 1e3 * random_information(group, m, rng)
    blank = np.concatenate(
        [steps, np.broadcast_to(group.identity(), (closures, *steps.shape[1:]))]
    )
    graph = PoseGraph(n, edges, blank, information, np.arange(m) < n - 1)
    x = dead_reckoning(graph)
    true = group.between(x[edges[:, 0]], x[edges[:, 1]])
    error = noise * rng.normal(size=(m, group.DOF)) * (np.arange(m) >= n - 1)[:, None]
    return PoseGraph(
        n, edges, group.compose(true, group.exp(error)), information, graph.is_odometry
    )


def walk(group, graph, steps, start, end):
    """O(start→end): the odometry composed one step after the other, either way."""
    pose = group.identity()
    for k in range(start, end):
        pose = group.compose(pose, steps[k])
    for k in range(start - 1, end - 1, -1):
        pose = group.compose(pose, group.inverse(steps[k]))
    return pose


def cycle_error(group, graph, parts, p, q):
    """Log(z_p ∘ O(j_p→j_q) ∘ z_q⁻¹ ∘ O(i_q→i_p)) of four measured parts."""
    z_p, by_j, z_q, by_i = parts
    return group.log(
        group.compose(group.compose(group.compose(z_p, by_j), group.inverse(z_q)), by_i)
    )


def covariance_of_walk(group, graph, start, end):
    """Σ of O(start→end) for a perturbation on its right, by numerical derivatives."""
    steps = graph.measurement[: graph.n - 1]
    at = walk(group, graph, steps, start, end)
    total = np.zeros((group.DOF, group.DOF))
    for k in range(min(start, end), max(start, end)):
        slopes = []
        for e in np.eye(group.DOF):
            sides = []
            for h in (1e-6, -1e-6):
                moved = steps.copy()
                moved[k] = group.compose(steps[k], group.exp(h * e))
                other = walk(group, graph, moved, start, end)
                sides.append(group.log(group.between(at, other)))
            slopes.append((sides[0] - sides[1]) / 2e-6)
        jacobian = np.stack(slopes, axis=-1)
        total += jacobian @ np.linalg.inv(graph.information[k]) @ jacobian.T
    return total


def distance_by_hand(group, graph, p, q):
    """√(eᵀ Σ⁻¹ e), each part perturbed on its right, derivatives numerical."""
    (i_p, j_p), (i_q, j_q) = graph.edges[[p, q]]
    steps = graph.measurement[: graph.n - 1]
    parts = [
        graph.measurement[p],
        walk(group, graph, steps, j_p, j_q),
        graph.measurement[q],
        walk(group, graph, steps, i_q, i_p),
    ]
    spreads = [
        np.linalg.inv(graph.information[p]),
        covariance_of_walk(group, graph, j_p, j_q),
        np.linalg.inv(graph.information[q]),
        covariance_of_walk(group, graph, i_q, i_p),
    ]
    error = cycle_error(group, graph, parts, p, q)
    sigma = np.zeros((group.DOF, group.DOF))
    for place, spread in enumerate(spreads):
        slopes = []
        for e in np.eye(group.DOF):
            sides = []
            for h in (1e-6, -1e-6):
                moved = list(parts)
                moved[place] = group.compose(parts[place], group.exp(h * e))
                sides.append(cycle_error(group, graph, moved, p, q))
            slopes.append((sides[0] - sides[1]) / 2e-6)
        jacobian = np.stack(slopes, axis=-1)
        sigma += jacobian @ spread @ jacobian.T
    return np.sqrt(error @ np.linalg.solve(sigma, error))


def distance_through_every_step(group, graph, p, q):
    """√(eᵀ Σ⁻¹ e) with the cycle as a function of both closures and each odometry step."""
    (i_p, j_p), (i_q, j_q) = graph.edges[[p, q]]

    def error(measured):
        steps = measured[: graph.n - 1]
        by_j, by_i = walk(group, graph, steps, j_p, j_q), walk(group, graph, steps, i_q, i_p)
        return cycle_error(group, graph, (measured[p], by_j, measured[q], by_i), p, q)

    sigma = np.zeros((group.DOF, group.DOF))
    for k in [*range(graph.n - 1), p, q]:
        slopes = []
        for e in np.eye(group.DOF):
            ahead, back = (perturbed(group, graph.measurement, k, h * e) for h in (1e-6, -1e-6))
            slopes.append((error(ahead) - error(back)) / 2e-6)
        jacobian = np.stack(slopes, axis=-1)
        sigma += jacobian @ np.linalg.solve(graph.information[k], jacobian.T)
    e = error(graph.measurement)
    return np.sqrt(e @ np.linalg.solve(sigma, e))


@pytest.mark.parametrize("noise", [0.02, 0.5], ids=["honest", "lies"])
@pytest.mark.parametrize("seed", range(2))
def test_with_shared_odometry_every_step_counts_as_one_measurement(group, noise, seed):
    graph = wandering(seed, group, n=9, noise=noise)
    distances = pairwise_distances(graph, shared_odometry=True)
    closures = np.flatnonzero(~graph.is_odometry)
    for a, b in zip(*np.triu_indices(len(closures), 1), strict=True):
        expected = distance_through_every_step(group, graph, closures[a], closures[b])
        assert distances[a, b] == pytest.approx(expected, rel=1e-4, abs=1e-6)


@pytest.mark.parametrize("noise", [0.02, 0.5], ids=["honest", "lies"])
@pytest.mark.parametrize("seed", range(2))
def test_distances_are_those_of_the_definition(group, noise, seed):
    graph = wandering(seed, group, noise=noise)
    distances = pairwise_distances(graph)
    closures = np.flatnonzero(~graph.is_odometry)
    for a in range(len(closures)):
        for b in range(a + 1, len(closures)):
            expected = distance_by_hand(group, graph, closures[a], closures[b])
            assert distances[a, b] == pytest.approx(expected, rel=1e-4, abs=1e-6)


def test_distances_are_symmetric_and_zero_to_oneself(group):
    distances = pairwise_distances(wandering(4, group))
    np.testing.assert_array_equal(distances, distances.T)
    np.testing.assert_array_equal(np.diag(distances), 0.0)


@pytest.mark.parametrize("shared", [False, True])
def test_exact_measurements_are_at_distance_0(group, shared):
    graph = wandering(5, group, noise=0.0)
    np.testing.assert_allclose(pairwise_distances(graph, shared_odometry=shared), 0.0, atol=1e-6)


def test_closures_that_are_all_turned_round_say_the_same(group):
    # To first order only: the two cycles are linearised at either end of the same error.
    graph = wandering(6, group, noise=1e-6)
    edges, measurement = graph.edges.copy(), graph.measurement.copy()
    information = graph.information.copy()
    turned = ~graph.is_odometry
    edges[turned], measurement[turned] = edges[turned][:, ::-1], group.inverse(measurement[turned])
    # A perturbation on the right of z is one on the right of z⁻¹, carried by −Ad(z).
    carried = np.linalg.inv(group.adjoint(graph.measurement))
    moved = np.swapaxes(carried, 1, 2) @ information @ carried
    information[turned] = 0.5 * (moved + np.swapaxes(moved, 1, 2))[turned]
    round_about = PoseGraph(graph.n, edges, measurement, information, graph.is_odometry)
    for shared in (False, True):
        np.testing.assert_allclose(
            pairwise_distances(round_about, shared_odometry=shared),
            pairwise_distances(graph, shared_odometry=shared),
            rtol=1e-4,
            atol=1e-9,
        )


@pytest.mark.parametrize("ends", [((2, 6), (10, 16)), ((6, 2), (10, 16)), ((2, 16), (12, 4))])
def test_with_shared_odometry_the_squares_are_chi_square(ends):
    """Monte Carlo: overlapping stretches, the same steps in both odometry parts."""
    rng = np.random.default_rng(7)
    squares = {False: [], True: []}
    sigma = np.array([0.02, 0.02, 0.004])
    truth_steps = np.tile([1.0, 0.0, 0.15], (20, 1))
    edges = np.array([*((k, k + 1) for k in range(20)), *ends])
    information = np.eye(3)[None] / sigma[None, :, None] ** 2 * np.ones((22, 1, 1))
    information[20:] *= 100.0
    is_odometry = np.arange(22) < 20
    blank = np.concatenate([truth_steps, np.zeros((2, 3))])
    x = dead_reckoning(PoseGraph(21, edges, blank, information, is_odometry))
    true = se2.between(x[edges[:, 0]], x[edges[:, 1]])
    for _ in range(1500):
        drawn = rng.normal(size=(22, 3)) / np.sqrt(np.einsum("kii->ki", information))
        graph = PoseGraph(21, edges, se2.compose(true, se2.exp(drawn)), information, is_odometry)
        for shared, values in squares.items():
            values.append(pairwise_distances(graph, shared_odometry=shared)[0, 1] ** 2)
    # The mean of χ² with 3 degrees of freedom is 3, and its deviation here √(6/1500) = 0.063.
    assert np.mean(squares[True]) == pytest.approx(3.0, abs=0.25)
    assert abs(np.mean(squares[False]) - 3.0) > 0.5


@pytest.mark.parametrize(
    "world",
    [
        lambda rng: circle(40, rng, laps=2, closures=15),
        lambda rng: manhattan(100, rng, closures=30),
        lambda rng: sphere(60, rng),
    ],
    ids=["circle", "manhattan", "sphere"],
)
def test_random_lies_are_not_in_the_largest_set(world, seed):
    rng = np.random.default_rng(seed)
    graph, truth = world(rng)
    spoiled, is_lie = add_random_closures(graph, 8, rng, poses=truth)
    result = pcm(spoiled)
    assert result.clique.proven
    assert not np.any(result.kept[is_lie])
    assert np.all(result.kept[spoiled.is_odometry])
    assert np.mean(result.kept[~is_lie]) > 0.9


def test_what_is_kept_is_consistent_two_by_two():
    rng = np.random.default_rng(8)
    graph, truth = manhattan(100, rng, closures=30)
    spoiled, _ = add_random_closures(graph, 10, rng, poses=truth)
    result = pcm(spoiled)
    inside = result.adjacency[np.ix_(result.clique.members, result.clique.members)]
    assert np.all(inside)
    np.testing.assert_array_equal(
        np.flatnonzero(result.kept & ~spoiled.is_odometry),
        result.closures[result.clique.members],
    )


def test_a_larger_group_of_lies_that_agree_wins():
    rng = np.random.default_rng(9)
    graph, truth = manhattan(200, rng, closures=6)
    spoiled, is_lie = add_aliased_closures(graph, 1, rng, size=15, poses=truth)
    consistent = pairwise_consistent(spoiled, chi_square_threshold(0.99, 3))
    closures = np.flatnonzero(~spoiled.is_odometry)
    lies = is_lie[closures]
    assert np.mean(consistent[np.ix_(lies, lies)]) > 0.9
    assert np.count_nonzero(pcm(spoiled).kept & is_lie) > 6


def test_gamma_is_compared_with_the_norm_and_not_its_square():
    graph = wandering(10, se2, closures=8, noise=0.05)
    distances = pairwise_distances(graph)
    gamma = float(np.median(distances[distances > 0.0]))
    np.testing.assert_array_equal(pairwise_consistent(graph, gamma), distances <= gamma)


def test_the_default_gamma_keeps_an_honest_pair_with_the_probability():
    rng = np.random.default_rng(11)
    graph, _ = manhattan(100, rng, closures=30)
    threshold = chi_square_threshold(0.9, 3)
    np.testing.assert_array_equal(pcm(graph, probability=0.9).kept, pcm(graph, threshold).kept)


def test_only_the_marked_closures_are_compared():
    graph = wandering(12, se2)
    marked = ~graph.is_odometry
    marked[graph.n - 1] = False
    np.testing.assert_allclose(
        pairwise_distances(graph, marked), pairwise_distances(graph)[1:, 1:]
    )


def test_of_a_step_measured_twice_the_first_counts_as_in_dead_reckoning(group):
    graph = wandering(17, group)
    order = np.append(np.arange(len(graph.edges)), 3)
    measurement, information = graph.measurement[order], 7.0 * graph.information[order]
    measurement[-1], information[:-1] = group.identity(), graph.information
    twice = PoseGraph(
        graph.n, graph.edges[order], measurement, information, graph.is_odometry[order]
    )
    np.testing.assert_allclose(pairwise_distances(twice), pairwise_distances(graph))


@pytest.mark.parametrize("shared", [False, True])
def test_far_from_the_first_pose_and_after_many_steps_the_digits_are_still_there(group, shared):
    # Before the same loops the robot drives 3000 m. No cycle runs over that way, so that the
    # distances stay as they are, while the sums over it are large.
    near = wandering(18, group, noise=0.3)
    ahead = group.exp(3.0 * np.eye(group.DOF)[0])
    far_steps = np.stack([np.arange(1000), np.arange(1, 1001)], axis=1)
    far = PoseGraph(
        near.n + 1000,
        np.concatenate([far_steps, near.edges + 1000]),
        np.concatenate([np.broadcast_to(ahead, (1000, *ahead.shape)), near.measurement]),
        np.concatenate([np.tile(near.information[0], (1000, 1, 1)), near.information]),
        np.concatenate([np.ones(1000, dtype=bool), near.is_odometry]),
    )
    np.testing.assert_allclose(
        pairwise_distances(far, shared_odometry=shared),
        pairwise_distances(near, shared_odometry=shared),
        rtol=1e-5,
        atol=1e-9,
    )


def test_trusted_closures_are_members_or_the_contradiction_is_told():
    rng = np.random.default_rng(13)
    graph, truth = circle(40, rng, laps=2, closures=12)
    spoiled, is_lie = add_random_closures(graph, 2, rng, poses=truth)
    lie = np.flatnonzero(is_lie)[0]
    trusted = np.arange(len(spoiled.edges)) == lie
    assert pcm(spoiled, trusted=trusted).kept[lie]
    honest = np.flatnonzero(~spoiled.is_odometry & ~is_lie)[0]
    both = trusted | (np.arange(len(spoiled.edges)) == honest)
    with pytest.raises(ValueError, match=f"edges {honest} and {lie} contradict each other"):
        pcm(spoiled, trusted=both)


def test_without_closures_the_odometry_is_kept():
    graph, _ = manhattan(30, np.random.default_rng(14), closures=0)
    result = pcm(graph)
    assert np.all(result.kept)
    assert result.clique.proven and result.clique.bound == 0
    assert pairwise_distances(graph).shape == (0, 0)


def test_a_small_budget_says_that_nothing_is_proven():
    rng = np.random.default_rng(15)
    graph, _ = manhattan(120, rng, closures=60, noise=Noise(scale=2.5))
    full = pcm(graph)
    hurried = pcm(graph, budget=1)
    assert hurried.clique.members.size <= full.clique.members.size <= hurried.clique.bound


def test_bad_arguments_are_refused_by_name():
    graph = wandering(16, se2)
    with pytest.raises(ValueError, match=r"gamma is -1\.0"):
        pcm(graph, -1.0)
    with pytest.raises(ValueError, match=r"probability is 1\.0"):
        pcm(graph, probability=1.0)
    with pytest.raises(ValueError, match="budget is 0"):
        pcm(graph, budget=0)
    with pytest.raises(ValueError, match="edge 0 is odometry; mark loop closures alone"):
        pairwise_distances(graph, np.ones(len(graph.edges), dtype=bool))
    with pytest.raises(ValueError, match="trusted: the shape"):
        pcm(graph, trusted=[True])
    unmarked = replace(graph, is_odometry=np.zeros(len(graph.edges), dtype=bool))
    with pytest.raises(ValueError, match="no odometry edge leads from pose 0 to pose 1"):
        pcm(unmarked)
