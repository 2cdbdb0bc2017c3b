"""Wrong closures: they are wrong, they are marked, and nothing in them gives them away."""

from functools import partial

import numpy as np
import pytest
from robust_slam.graphs import circle, outliers, pose_graph
from robust_slam.graphs.outliers import (
    add_aliased_closures,
    add_grouped_closures,
    add_local_closures,
    add_random_closures,
    spoil_closures,
)
from robust_slam.groups import se2

from ..worlds import assert_same_poses, measured, random_information, refused, walked

ADDERS = {
    "random": (add_random_closures, 1),
    "local": (add_local_closures, 1),
    "random group": (add_grouped_closures, 10),
    "local group": (partial(add_grouped_closures, reach=20), 10),
    "aliased": (add_aliased_closures, 10),
}
adders = pytest.mark.parametrize(("add", "size"), ADDERS.values(), ids=ADDERS.keys())


def wander(seed, group, n=150, closures=12, spread=0.02):
    """A way that bends all the time, with closures that are inliers, and its true poses."""
    rng = np.random.default_rng(seed)
    bend = np.concatenate([np.zeros(group.DIMENSION), [0.1] * (group.DOF - group.DIMENSION)])
    steps = np.eye(group.DOF)[0] + rng.normal(size=(n - 1, group.DOF)) * bend
    truth = walked(group, group.exp(steps))
    pairs = np.sort(rng.permutation(n)[: 2 * closures].reshape(-1, 2), axis=1)
    edges = np.concatenate([along(n), pairs])
    covariance = spread**2 * random_information(group, len(edges), rng) / group.DOF
    noise = np.linalg.cholesky(covariance) @ rng.normal(size=(len(edges), group.DOF, 1))
    return measured(group, truth, edges, noise[..., 0], np.linalg.inv(covariance)), truth


def along(n):
    """The edges of the odometry."""
    return np.stack([np.arange(n - 1), np.arange(1, n)], axis=1)


def errors(graph, truth, chosen):
    """How far (m) each chosen edge puts pose j from where it is."""
    i, j = graph.edges[chosen].T
    put = graph.group.compose(truth[i], graph.measurement[chosen])
    return np.linalg.norm(graph.group.translation(put) - graph.group.translation(truth[j]), axis=1)


@adders
@pytest.mark.parametrize("count", [0, 3])
def test_the_mask_marks_the_new_edges_and_the_old_ones_are_left_alone(group, add, size, count):
    graph, truth = wander(0, group)
    longer, is_outlier = add(graph, count, np.random.default_rng(1), poses=truth)
    m = len(graph.edges)
    assert is_outlier.tolist() == [False] * m + [True] * count * size
    for name in ("edges", "measurement", "information", "is_odometry"):
        np.testing.assert_array_equal(getattr(longer, name)[:m], getattr(graph, name))
    assert not longer.is_odometry[is_outlier].any()


@adders
def test_at_the_truth_every_outlier_is_wrong_by_what_was_asked_for(group, add, size, seed):
    graph, truth = wander(seed, group, spread=1e-6)
    rng = np.random.default_rng(seed)
    longer, is_outlier = add(graph, 4, rng, poses=truth, apart=8.0)
    # The noise moves an outlier by far less than 1e-3.
    assert errors(longer, truth, is_outlier).min() >= 8.0 - 1e-3


def test_how_wrong_an_outlier_is_by_default(group):
    # A straight way of 160 steps whose lengths are 0.1, 0.1, 1, 1, 1 over and over: the
    # median step is 1, and the map 32 · 3.2 = 102.4 long.
    places = np.concatenate([[0.0], np.cumsum(np.tile([0.1, 0.1, 1.0, 1.0, 1.0], 32))])
    axis = np.eye(group.DIMENSION)
    truth = group.from_parts(np.tile(axis, (161, 1, 1)), np.outer(places, axis[0]))
    still = np.zeros((160, group.DOF))
    graph = measured(group, truth, along(161), still, 1e12 * np.eye(group.DOF))
    # Two steps on, every group of 5 holds a pair 0.2 apart; three steps on, none below 1.2.
    for add, count, options, least in (
        (add_random_closures, 80, {}, 51.2),
        (add_local_closures, 80, {"reach": 3}, 1.0),
        (add_grouped_closures, 16, {"size": 5}, 51.2),
        (add_grouped_closures, 16, {"size": 5, "reach": 3}, 1.2),
        (add_aliased_closures, 4, {"size": 5}, 51.2),
    ):
        longer, is_outlier = add(graph, count, np.random.default_rng(0), poses=truth, **options)
        wrong = errors(longer, truth, is_outlier)
        assert least - 1e-4 <= wrong.min() < 1.3 * least


@adders
def test_no_pair_is_drawn_twice_and_an_outlier_has_the_information_of_an_inlier(group, add, size):
    graph, truth = wander(2, group)
    longer, is_outlier = add(graph, 60 // size, np.random.default_rng(3), poses=truth)
    assert len(np.unique(longer.edges[is_outlier], axis=0)) == 60 // size * size
    i, j = longer.edges[is_outlier].T
    assert np.all(j > i + 1)
    inliers = {matrix.tobytes() for matrix in graph.information[~graph.is_odometry]}
    claimed = {matrix.tobytes() for matrix in longer.information[is_outlier]}
    assert claimed <= inliers
    assert len(claimed) > 1


@adders
def test_the_seed_decides(group, add, size):
    graph, truth = wander(6, group)
    rngs = map(np.random.default_rng, (1, 1, 2))
    first, again, other = (add(graph, 3, rng, poses=truth)[0] for rng in rngs)
    np.testing.assert_array_equal(first.edges, again.edges)
    np.testing.assert_array_equal(first.measurement, again.measurement)
    assert not np.array_equal(first.edges[-3:], other.edges[-3:])


def test_the_noise_is_that_of_the_odometry_where_there_are_no_closures(group):
    rng = np.random.default_rng(6)
    covariance = 0.01 * random_information(group, 1, rng)[0] / group.DOF
    precision = np.linalg.inv(covariance)
    precision = (precision + precision.T) / 2.0
    truth = walked(group, group.exp(np.tile(np.eye(group.DOF)[0], (299, 1))))
    graph = measured(group, truth, along(300), np.zeros((299, group.DOF)), precision)
    longer, is_outlier = add_random_closures(graph, 4000, rng)
    np.testing.assert_array_equal(longer.information[is_outlier][0], graph.information[0])
    drawn = group.log(longer.measurement[is_outlier])
    # An entry's deviation is at most √(2/4000) of the largest variance; 5 of them.
    limit = 5.0 * np.sqrt(2.0 / 4000.0) * covariance.diagonal().max()
    np.testing.assert_allclose(np.cov(drawn.T), covariance, atol=limit)


def test_local_outliers_stay_within_reach(group, seed):
    graph, truth = wander(seed, group)
    rng = np.random.default_rng(seed)
    longer, is_outlier = add_local_closures(graph, 40, rng, reach=6, poses=truth)
    gap = np.diff(longer.edges[is_outlier], axis=1)
    assert set(np.unique(gap)) == {2, 3, 4, 5, 6}


@pytest.mark.parametrize("reach", [None, 8])
def test_a_group_follows_the_way_and_measures_the_identity_all_along(group, reach):
    graph, truth = wander(8, group, spread=1e-6)
    rng = np.random.default_rng(9)
    longer, is_outlier = add_grouped_closures(graph, 5, rng, size=7, reach=reach, poses=truth)
    edges = longer.edges[is_outlier].reshape(5, 7, 2)
    np.testing.assert_array_equal(edges, edges[:, :1] + np.arange(7)[None, :, None])
    assert np.all(np.diff(edges[:, 0], axis=1) <= (graph.n if reach is None else reach))
    z = longer.measurement[is_outlier]
    assert_same_poses(group, z, np.broadcast_to(group.identity(), z.shape), atol=1e-3)


def test_an_aliased_group_asks_for_one_rigid_displacement(group, seed):
    graph, truth = wander(seed, group, spread=1e-7)
    rng = np.random.default_rng(seed)
    longer, is_outlier = add_aliased_closures(graph, 2, rng, size=8, poses=truth)
    (i, j), z = longer.edges[is_outlier].T, longer.measurement[is_outlier]
    # The displacement of the world that each closure asks for is x_i ∘ z ∘ x_j⁻¹.
    moves = group.compose(group.compose(truth[i], z), group.inverse(truth[j]))
    for first in (0, 8):
        same = np.broadcast_to(moves[first], (8, *group.POSE_SHAPE))
        assert_same_poses(group, moves[first : first + 8], same, atol=1e-3)
        # A group starts where two poses are taken for one.
        assert_same_poses(group, z[first], group.identity(), atol=1e-5)
    assert not np.allclose(moves[0], moves[8], atol=1e-2)


def test_an_aliased_group_is_found_where_two_stretches_look_alike():
    # Two straight streets and a bend between them that is nowhere like itself.
    rng = np.random.default_rng(12)
    bend = np.concatenate([np.zeros(14), rng.uniform(0.2, 0.6, 16), np.zeros(14)])
    truth = walked(se2, np.stack([np.ones(44), np.zeros(44), bend], axis=1))
    graph = measured(se2, truth, along(45), np.zeros((44, 3)), 1e12 * np.eye(3))
    longer, is_outlier = add_aliased_closures(graph, 1, rng, size=10, apart=5.0)
    i, j = longer.edges[is_outlier].T
    assert i.max() <= 14
    assert j.min() >= 30
    np.testing.assert_allclose(longer.measurement[is_outlier], 0.0, atol=1e-4)


@pytest.mark.parametrize("fraction", [0.0, 0.3, 1.0])
def test_spoiling_replaces_the_asked_share_in_place(group, seed, fraction):
    graph, truth = wander(seed, group, closures=20)
    worse, is_outlier = spoil_closures(graph, fraction, np.random.default_rng(seed), poses=truth)
    assert is_outlier.sum() == round(20 * fraction)
    assert not np.any(is_outlier & graph.is_odometry)
    for name in ("edges", "information", "is_odometry"):
        np.testing.assert_array_equal(getattr(worse, name), getattr(graph, name))
    np.testing.assert_array_equal(worse.measurement[~is_outlier], graph.measurement[~is_outlier])
    u = pose_graph.residual_norms(worse, truth)
    assert np.all(u[is_outlier] > 20.0)
    assert u[~is_outlier].max() < 7.0


def test_a_spoiled_closure_measures_another_pose_that_is_far_enough(group, seed):
    graph, truth = wander(seed, group, closures=20, spread=1e-7)
    rng = np.random.default_rng(seed)
    worse, is_outlier = spoil_closures(graph, 0.5, rng, poses=truth, apart=3.0)
    assert errors(worse, truth, is_outlier).min() >= 3.0 - 1e-4
    put = group.compose(truth[worse.edges[is_outlier, 0]], worse.measurement[is_outlier])
    gap = group.translation(put)[:, None] - group.translation(truth)
    assert np.linalg.norm(gap, axis=2).min(axis=1).max() < 1e-4


def test_the_noise_of_a_spoiled_closure_is_that_of_an_inlier(group, seed):
    # Poses are 1 m apart, so that the one that a closure measures is the nearest to it.
    graph, truth = wander(seed, group, n=300, closures=150, spread=0.01)
    worse, is_outlier = spoil_closures(graph, 1.0, np.random.default_rng(seed), poses=truth)
    start, z = truth[worse.edges[is_outlier, 0]], worse.measurement[is_outlier]
    put = group.translation(group.compose(start, z))[:, None]
    meant = np.linalg.norm(put - group.translation(truth), axis=2).argmin(axis=1)
    r = group.log(group.between(group.between(start, truth[meant]), z))
    squares = np.einsum("ka,kab,kb->k", r, worse.information[is_outlier], r)
    # The mean of 150 times χ² with D degrees has the variance 2 D/150.
    assert squares.mean() == pytest.approx(group.DOF, abs=4.0 * np.sqrt(2.0 * group.DOF / 150))


def test_poses_just_as_far_apart_as_asked_are_far_enough_wherever_the_map_is():
    """A sixth of a round apart they are one radius from each other, up to rounding."""
    graph, truth = circle(36, 0, laps=2, closures=12)
    drawn = set()
    for angle in range(7):
        poses = se2.compose(np.array([3.0, 7.0, angle]), truth)
        radius = np.linalg.norm(poses[3, :2] - poses[0, :2])
        drawn.add(add_random_closures(graph, 40, 0, poses=poses, apart=radius)[0].edges.tobytes())
    assert len(drawn) == 1


@refused(
    ({"count": -1}, "count is -1"),
    ({"count": 3, "apart": 1000.0}, "only 0 pairs at least 1e"),
    ({"count": 100}, "count is 100, and 12 poses have at most 55"),
    ({"count": 54}, "count is 54, and only .* pairs at least 5.03 m apart were found"),
    ({"count": 1, "poses": np.zeros((3, 3))}, "poses: the shape"),
)
def test_what_cannot_be_drawn_is_refused(wrong, message):
    graph, _ = circle(12, np.random.default_rng(0))
    with pytest.raises(ValueError, match=message):
        add_random_closures(graph, rng=np.random.default_rng(0), **wrong)


@pytest.mark.parametrize(
    ("name", "wrong", "message"),
    [
        ("add_local_closures", {"count": 3, "reach": 1}, "reach is 1"),
        ("add_grouped_closures", {"groups": -1}, "groups is -1"),
        ("add_grouped_closures", {"groups": 1, "size": 0}, "size is 0"),
        ("add_grouped_closures", {"groups": 1, "size": 200}, "only 0 groups of 200"),
        ("add_grouped_closures", {"groups": 1, "reach": 0}, "reach is 0"),
        ("add_aliased_closures", {"groups": 1, "size": 150}, "only 0 groups of 150"),
        ("spoil_closures", {"fraction": 1.5}, "fraction is 1.5"),
        ("spoil_closures", {"fraction": float("nan")}, "fraction is nan"),
        ("spoil_closures", {"fraction": 0.5, "apart": 1e4}, "apart is 1e"),
        ("spoil_closures", {"fraction": 0.5, "poses": np.zeros((3, 3))}, "poses: the shape"),
    ],
)
def test_what_cannot_be_is_refused_by_name(group, name, wrong, message):
    graph, truth = wander(0, group)
    given = {"rng": np.random.default_rng(0), "poses": truth}
    with pytest.raises(ValueError, match=message):
        getattr(outliers, name)(graph, **(given | wrong))
