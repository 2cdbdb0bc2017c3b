"""Wrong closures: they are wrong, they are marked, and nothing in them gives them away."""

from __future__ import annotations

import numpy as np
import pytest
from robust_slam import pose_graph, se2
from robust_slam.generate import Noise, circle, dead_reckoning
from robust_slam.outliers import add_random_closures
from robust_slam.pose_graph import PoseGraph


def spoiled(seed=0, count=6, **options):
    rng = np.random.default_rng(seed)
    graph, truth = circle(40, rng, laps=2, closures=10)
    return graph, truth, *add_random_closures(graph, count, rng, **options)


def test_the_mask_marks_the_new_edges_and_the_old_ones_are_left_alone():
    graph, _, longer, is_outlier = spoiled()
    m = len(graph.edges)
    assert is_outlier.tolist() == [False] * m + [True] * 6
    for name in ("edges", "measurement", "information", "is_odometry"):
        np.testing.assert_array_equal(getattr(longer, name)[:m], getattr(graph, name))
    assert not longer.is_odometry[is_outlier].any()


def test_at_the_truth_every_lie_is_far_out_and_nothing_else_is():
    _, truth, longer, is_outlier = spoiled(count=20)
    u = pose_graph.residual_norms(truth, longer)
    assert u[is_outlier].min() > 20.0
    assert u[~is_outlier].max() < 6.0


def test_a_lie_says_that_two_distant_poses_are_one_place():
    _, _, longer, is_outlier = spoiled(count=20, apart=7.0)
    i, j = longer.edges[is_outlier].T
    place = dead_reckoning(longer)[:, :2]
    assert np.linalg.norm(place[i] - place[j], axis=1).min() >= 7.0
    assert np.abs(longer.measurement[is_outlier]).max() < 0.3


def test_the_distance_is_judged_by_the_poses_that_are_given():
    rng = np.random.default_rng(3)
    graph, truth = circle(40, rng, noise=Noise(scale=8.0))
    longer, is_outlier = add_random_closures(graph, 30, rng, poses=truth, apart=9.5)
    i, j = longer.edges[is_outlier].T
    assert np.linalg.norm(truth[i, :2] - truth[j, :2], axis=1).min() >= 9.5


def test_no_pair_is_drawn_twice():
    _, _, longer, is_outlier = spoiled(count=60)
    assert len(np.unique(longer.edges[is_outlier], axis=0)) == 60


def test_the_claimed_information_is_that_of_honest_closures():
    rng = np.random.default_rng(4)
    noise = Noise(odometry=(0.1, 0.1, 0.1), closure=(0.2, 0.3, 0.05))
    graph, _ = circle(400, rng, laps=2, closures=10, noise=noise)
    longer, is_outlier = add_random_closures(graph, 3000, rng)
    claimed = longer.information[is_outlier]
    np.testing.assert_allclose(claimed, np.tile(graph.information[-1], (3000, 1, 1)))
    np.testing.assert_allclose(
        longer.measurement[is_outlier].std(axis=0), [0.2, 0.3, 0.05], rtol=0.06
    )


def test_without_honest_closures_the_information_is_that_of_the_odometry():
    rng = np.random.default_rng(5)
    graph, _ = circle(20, rng, closures=0)
    longer, is_outlier = add_random_closures(graph, 2, rng)
    np.testing.assert_array_equal(longer.information[is_outlier], graph.information[:2])


def test_the_noise_of_a_lie_is_correlated_as_its_information_says():
    covariance = np.array([[0.04, 0.03, 0.0], [0.03, 0.09, 0.01], [0.0, 0.01, 0.01]])
    steps = [[k, k + 1] for k in range(299)]
    ahead = np.tile([1.0, 0.0, 0.0], (299, 1))
    information = np.tile(np.linalg.inv(covariance), (299, 1, 1))
    graph = PoseGraph(300, steps, ahead, information, np.ones(299, dtype=bool))
    longer, is_outlier = add_random_closures(graph, 4000, np.random.default_rng(6))
    drawn = se2.log(longer.measurement[is_outlier])
    np.testing.assert_allclose(np.cov(drawn.T), covariance, atol=0.005)


def test_the_seed_decides():
    first, again, other = (spoiled(seed)[2] for seed in (1, 1, 2))
    np.testing.assert_array_equal(first.edges, again.edges)
    np.testing.assert_array_equal(first.measurement, again.measurement)
    assert not np.array_equal(first.edges[-6:], other.edges[-6:])


def test_no_lies_leave_the_graph_as_it_is():
    graph, _, longer, is_outlier = spoiled(count=0)
    np.testing.assert_array_equal(longer.measurement, graph.measurement)
    assert not is_outlier.any()


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ({"count": -1}, "count is -1"),
        ({"count": 3, "apart": 1000.0}, "only 0 pairs at least 1e"),
        ({"count": 2000}, "count is 2000, and only"),
        ({"count": 1, "poses": np.zeros((3, 3))}, "poses: the shape"),
    ],
)
def test_what_cannot_be_drawn_is_refused(arguments, told):
    with pytest.raises(ValueError, match=told):
        spoiled(**arguments)
