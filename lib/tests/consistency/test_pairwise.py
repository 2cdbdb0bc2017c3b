"""Pairwise consistency: distances by the book, in both groups, and what the largest set is."""

from dataclasses import replace
from functools import reduce

import numpy as np
import pytest
from robust_slam.consistency.pairwise import pairwise_consistent, pairwise_distances, pcm
from robust_slam.estimators.thresholds import chi_square_threshold
from robust_slam.graphs import circle, manhattan, sphere
from robust_slam.graphs.outliers import add_aliased_closures
from robust_slam.graphs.pose_graph import PoseGraph, with_closures
from robust_slam.groups import se2

from .. import worlds
from ..worlds import measured, random_poses, refused, walked, with_outliers


def wandering(seed, group, n=12, closures=6, noise=0.02):
    """A chain with long lever arms and closures in either direction, nearly exact."""
    rng = np.random.default_rng(seed)
    poses = walked(group, random_poses(group, n - 1, rng, reach=5.0, turn=1.0))
    pairs = [tuple(rng.choice(n, size=2, replace=False)) for _ in range(closures)]
    edges = [(k, k + 1) for k in range(n - 1)] + pairs
    information = 1e3 * worlds.random_information(group, len(edges), rng)
    error = noise * rng.normal(size=(len(edges), group.DOF))
    error[: n - 1] = 0.0
    return measured(group, poses, edges, error, information)


def distance(group, graph, p, q):
    """√(eᵀ Σ⁻¹ e) with the error e of the cycle as a function of all that was measured.

    Each of the two stretches of odometry has steps of its own. Every measurement is perturbed
    on its right.
    """
    (i_p, j_p), (i_q, j_q) = graph.edges[[p, q]]
    steps = np.arange(graph.n - 1)
    copies = np.concatenate([steps, steps, [p, q]])

    def error(z):
        by_j, by_i = walked(group, z[steps]), walked(group, z[graph.n - 1 + steps])
        # Log(z_p ∘ O(j_p→j_q) ∘ z_q⁻¹ ∘ O(i_q→i_p))
        there, back = group.between(by_j[j_p], by_j[j_q]), group.between(by_i[i_q], by_i[i_p])
        return group.log(reduce(group.compose, (z[-2], there, group.inverse(z[-1]), back)))

    z = graph.measurement[copies]
    sigma = np.zeros((group.DOF, group.DOF))
    for k, edge in enumerate(copies):

        def moved(delta, k=k):
            return error(worlds.perturbed(group, z, k, delta))

        jacobian = worlds.slopes(moved, group.DOF)
        sigma += jacobian @ np.linalg.solve(graph.information[edge], jacobian.T)
    e = error(z)
    return np.sqrt(e @ np.linalg.solve(sigma, e))


@pytest.mark.parametrize("noise", [0.02, 0.5], ids=["inliers", "outliers"])
def test_distances_are_those_of_the_definition(group, noise):
    graph = wandering(0, group, n=9, closures=4, noise=noise)
    distances = pairwise_distances(graph)
    closures = np.flatnonzero(~graph.is_odometry)
    graph = worlds.turned(
        graph, graph.edges[:, 0] > graph.edges[:, 1]
    )  # in the direction of travel
    for a, b in zip(*np.triu_indices(len(closures), 1), strict=True):
        expected = distance(group, graph, closures[a], closures[b])
        assert distances[a, b] == pytest.approx(expected, rel=1e-4, abs=1e-6)


@pytest.mark.parametrize(
    ("make", "n", "options"),
    [
        (circle, 40, {"laps": 2, "closures": 15}),
        (manhattan, 100, {"closures": 30}),
        (sphere, 60, {}),
    ],
    ids=["circle", "manhattan", "sphere"],
)
def test_random_outliers_are_not_in_the_largest_set_which_is_consistent(make, n, options, seed):
    graph, is_outlier, *_ = with_outliers(make, n, seed, 8, **options)
    result = pcm(graph)
    members = result.clique.members
    assert result.clique.proven
    assert np.all(result.adjacency[np.ix_(members, members)])
    kept = np.flatnonzero(result.kept & ~graph.is_odometry)
    np.testing.assert_array_equal(kept, result.closures[members])
    assert not np.any(result.kept[is_outlier])
    assert np.all(result.kept[graph.is_odometry])
    assert np.mean(result.kept[~is_outlier]) > 0.9


def test_a_larger_group_of_outliers_that_agree_wins():
    rng = np.random.default_rng(9)
    clean, truth = manhattan(200, rng, closures=6)
    graph, is_outlier = add_aliased_closures(clean, 1, rng, size=15, poses=truth)
    consistent = pairwise_consistent(graph, chi_square_threshold(0.99, 3))
    outliers = is_outlier[~graph.is_odometry]
    assert np.mean(consistent[np.ix_(outliers, outliers)]) > 0.9
    assert np.count_nonzero(pcm(graph).kept & is_outlier) > 6


def test_gamma_is_compared_with_the_norm_and_is_by_default_that_of_the_probability():
    graph = wandering(10, se2, closures=8, noise=0.05)
    distances = pairwise_distances(graph)
    gamma = float(np.median(distances[distances > 0.0]))
    np.testing.assert_array_equal(pairwise_consistent(graph, gamma), distances <= gamma)
    by_probability = pcm(graph, probability=0.9).adjacency
    np.testing.assert_array_equal(by_probability, distances <= chi_square_threshold(0.9, 3))


def test_only_the_marked_closures_are_compared():
    graph = wandering(12, se2)
    marked = ~graph.is_odometry
    marked[graph.n - 1] = False
    expected = pairwise_distances(graph)[1:, 1:]
    np.testing.assert_allclose(pairwise_distances(graph, marked), expected)


def test_of_a_step_measured_twice_the_first_counts_as_in_dead_reckoning(group):
    graph = wandering(17, group)
    again = with_closures(graph, [[3, 4]], group.identity()[None], 7.0 * graph.information[3])
    twice = replace(again, is_odometry=np.append(graph.is_odometry, True))
    np.testing.assert_allclose(pairwise_distances(twice), pairwise_distances(graph))


def test_far_from_the_first_pose_and_after_many_steps_the_digits_are_still_there(group):
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
    expected = pairwise_distances(near)
    np.testing.assert_allclose(pairwise_distances(far), expected, rtol=1e-5, atol=1e-9)


def test_without_closures_the_odometry_is_kept():
    graph, _ = manhattan(30, np.random.default_rng(14), closures=0)
    result = pcm(graph)
    assert np.all(result.kept)
    assert result.clique.proven and result.clique.bound == 0
    assert pairwise_distances(graph).shape == (0, 0)


@refused(({"gamma": -1.0}, r"gamma is -1\.0"), ({"probability": 1.0}, r"probability is 1\.0"))
def test_bad_arguments_are_refused_by_name(wrong, message):
    with pytest.raises(ValueError, match=message):
        pcm(wandering(16, se2), **wrong)


def test_odometry_is_not_compared():
    graph = wandering(16, se2)
    with pytest.raises(ValueError, match="edge 0 is odometry; mark loop closures alone"):
        pairwise_distances(graph, np.ones(len(graph.edges), dtype=bool))
