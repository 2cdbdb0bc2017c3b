"""Wrong closures: they are wrong, they are marked, and nothing in them gives them away."""

from __future__ import annotations

import numpy as np
import pytest
from robust_slam.graphs import outliers, pose_graph, se2
from robust_slam.graphs.generate import Noise, circle
from robust_slam.graphs.odometry import dead_reckoning
from robust_slam.graphs.outliers import (
    add_aliased_closures,
    add_grouped_closures,
    add_local_closures,
    add_random_closures,
    spoil_closures,
)
from robust_slam.graphs.pose_graph import PoseGraph

from tests.lib.worlds import assert_same_poses, random_poses, refused


def local_group(graph, count, rng, **options):
    return add_grouped_closures(graph, count, rng, reach=20, **options)


ADDERS = {
    "random": (add_random_closures, 1),
    "local": (add_local_closures, 1),
    "random group": (add_grouped_closures, 10),
    "local group": (local_group, 10),
    "aliased": (add_aliased_closures, 10),
}
adders = pytest.mark.parametrize(("add", "size"), ADDERS.values(), ids=ADDERS.keys())


def wander(seed, group, n=150, closures=12, spread=0.02):
    """A way that bends all the time, with honest closures, and its true poses."""
    rng = np.random.default_rng(seed)
    ahead = np.eye(group.DOF)[0]
    bend = np.concatenate([np.zeros(group.DIMENSION), [0.1] * (group.DOF - group.DIMENSION)])
    truth = [group.identity()]
    for _ in range(n - 1):
        truth.append(
            group.compose(truth[-1], group.exp(ahead + rng.normal(size=group.DOF) * bend))
        )
    truth = np.array(truth)
    steps = np.stack([np.arange(n - 1), np.arange(1, n)], axis=1)
    pairs = np.sort(rng.permutation(n)[: 2 * closures].reshape(-1, 2), axis=1)
    edges = np.concatenate([steps, pairs])
    root = rng.normal(size=(len(edges), group.DOF, group.DOF))
    covariance = spread**2 * (root @ np.swapaxes(root, 1, 2) / group.DOF + np.eye(group.DOF))
    noise = np.linalg.cholesky(covariance) @ rng.normal(size=(len(edges), group.DOF, 1))
    z = group.between(truth[edges[:, 0]], truth[edges[:, 1]])
    graph = PoseGraph(
        n,
        edges,
        group.compose(z, group.exp(noise[..., 0])),
        np.linalg.inv(covariance),
        np.arange(len(edges)) < n - 1,
    )
    return graph, truth


def errors(graph, truth, chosen):
    """How far (m) each chosen edge puts pose j from where it is."""
    i, j = graph.edges[chosen].T
    put = graph.group.compose(truth[i], graph.measurement[chosen])
    return np.linalg.norm(graph.group.translation(put) - graph.group.translation(truth[j]), axis=1)


def spoiled(seed=0, count=6, **options):
    rng = np.random.default_rng(seed)
    graph, truth = circle(40, rng, laps=2, closures=10)
    return graph, truth, *add_random_closures(graph, count, rng, **options)


@adders
def test_the_mask_marks_the_new_edges_and_the_old_ones_are_left_alone(group, add, size):
    graph, truth = wander(0, group)
    longer, is_lie = add(graph, 3, np.random.default_rng(1), poses=truth)
    m = len(graph.edges)
    assert is_lie.tolist() == [False] * m + [True] * 3 * size
    for name in ("edges", "measurement", "information", "is_odometry"):
        np.testing.assert_array_equal(getattr(longer, name)[:m], getattr(graph, name))
    assert not longer.is_odometry[is_lie].any()


@adders
def test_at_the_truth_every_lie_is_wrong_by_what_was_asked_for(group, add, size, seed):
    graph, truth = wander(seed, group, spread=1e-6)
    rng = np.random.default_rng(seed)
    longer, is_lie = add(graph, 4, rng, poses=truth, apart=8.0)
    # The noise moves a lie by far less than 1e-3.
    assert errors(longer, truth, is_lie).min() >= 8.0 - 1e-3


def test_how_wrong_a_lie_is_by_default(group):
    # A straight way of 160 steps whose lengths are 0.1, 0.1, 1, 1, 1 over and over: the
    # median step is 1, and the map 32 · 3.2 = 102.4 long.
    along = np.concatenate([[0.0], np.cumsum(np.tile([0.1, 0.1, 1.0, 1.0, 1.0], 32))])
    axis = np.eye(group.DIMENSION)
    truth = group.from_parts(np.tile(axis, (161, 1, 1)), np.outer(along, axis[0]))
    edges = np.stack([np.arange(160), np.arange(1, 161)], axis=1)
    information = np.tile(1e12 * np.eye(group.DOF), (160, 1, 1))
    z = group.between(truth[:-1], truth[1:])
    graph = PoseGraph(161, edges, z, information, np.ones(160, dtype=bool))
    # Two steps on, every group of 5 holds a pair 0.2 apart; three steps on, none below 1.2.
    for add, count, options, least in (
        (add_random_closures, 80, {}, 51.2),
        (add_local_closures, 80, {"reach": 3}, 1.0),
        (add_grouped_closures, 16, {"size": 5}, 51.2),
        (add_grouped_closures, 16, {"size": 5, "reach": 3}, 1.2),
        (add_aliased_closures, 4, {"size": 5}, 51.2),
    ):
        longer, is_lie = add(graph, count, np.random.default_rng(0), poses=truth, **options)
        wrong = errors(longer, truth, is_lie)
        assert least - 1e-4 <= wrong.min() < 1.3 * least


@adders
def test_at_the_truth_the_lies_are_far_out_and_nothing_else_is(group, add, size, seed):
    graph, truth = wander(seed, group)
    longer, is_lie = add(graph, 4, np.random.default_rng(seed), poses=truth)
    u = pose_graph.residual_norms(truth, longer)
    assert u[is_lie].min() > 10.0
    assert u[~is_lie].max() < 7.0


@adders
def test_no_pair_is_drawn_twice(group, add, size):
    graph, truth = wander(2, group)
    count = 60 // size
    longer, is_lie = add(graph, count, np.random.default_rng(3), poses=truth)
    assert len(np.unique(longer.edges[is_lie], axis=0)) == 60 // size * size
    i, j = longer.edges[is_lie].T
    assert np.all(j > i + 1)


@adders
def test_a_lie_claims_the_information_of_an_honest_closure(group, add, size):
    graph, truth = wander(4, group)
    longer, is_lie = add(graph, 3, np.random.default_rng(5), poses=truth)
    honest = {matrix.tobytes() for matrix in graph.information[~graph.is_odometry]}
    claimed = {matrix.tobytes() for matrix in longer.information[is_lie]}
    assert claimed <= honest
    assert len(claimed) > 1


@adders
def test_the_seed_decides(group, add, size):
    graph, truth = wander(6, group)
    first, again, other = (
        add(graph, 3, np.random.default_rng(seed), poses=truth)[0] for seed in (1, 1, 2)
    )
    np.testing.assert_array_equal(first.edges, again.edges)
    np.testing.assert_array_equal(first.measurement, again.measurement)
    assert not np.array_equal(first.edges[-3:], other.edges[-3:])


@adders
def test_no_lies_leave_the_graph_as_it_is(group, add, size):
    graph, truth = wander(7, group)
    longer, is_lie = add(graph, 0, np.random.default_rng(0), poses=truth)
    np.testing.assert_array_equal(longer.measurement, graph.measurement)
    assert not is_lie.any()


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


def test_the_noise_of_a_lie_is_that_of_honest_closures():
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


def test_the_noise_of_a_lie_is_correlated_as_its_information_says(group):
    rng = np.random.default_rng(6)
    root = rng.normal(size=(group.DOF, group.DOF))
    covariance = 0.01 * (root @ root.T / group.DOF + 0.2 * np.eye(group.DOF))
    steps = [[k, k + 1] for k in range(299)]
    ahead = np.tile(group.exp(np.eye(group.DOF)[0]), (299, *[1] * len(group.POSE_SHAPE)))
    information = np.tile(np.linalg.inv(covariance), (299, 1, 1))
    information = (information + np.swapaxes(information, 1, 2)) / 2.0
    graph = PoseGraph(300, steps, ahead, information, np.ones(299, dtype=bool))
    longer, is_outlier = add_random_closures(graph, 4000, rng)
    drawn = group.log(longer.measurement[is_outlier])
    # An entry's deviation is at most √(2/4000) of the largest variance; 5 of them.
    limit = 5.0 * np.sqrt(2.0 / 4000.0) * covariance.diagonal().max()
    np.testing.assert_allclose(np.cov(drawn.T), covariance, atol=limit)


def test_local_lies_stay_within_reach(group, seed):
    graph, truth = wander(seed, group)
    rng = np.random.default_rng(seed)
    longer, is_lie = add_local_closures(graph, 40, rng, reach=6, poses=truth)
    gap = np.diff(longer.edges[is_lie], axis=1)
    assert set(np.unique(gap)) == {2, 3, 4, 5, 6}


@pytest.mark.parametrize("reach", [None, 8])
def test_a_group_follows_the_way_and_says_the_same_all_along(group, reach):
    graph, truth = wander(8, group, spread=1e-6)
    rng = np.random.default_rng(9)
    longer, is_lie = add_grouped_closures(graph, 5, rng, size=7, reach=reach, poses=truth)
    edges = longer.edges[is_lie].reshape(5, 7, 2)
    np.testing.assert_array_equal(edges, edges[:, :1] + np.arange(7)[None, :, None])
    assert np.all(np.diff(edges[:, 0], axis=1) <= (graph.n if reach is None else reach))
    said = longer.measurement[is_lie]
    assert_same_poses(group, said, np.broadcast_to(group.identity(), said.shape), atol=1e-3)


def displacements(graph, poses, chosen):
    """The move of the world that each closure asks for, G = x_i ∘ z ∘ x_j⁻¹."""
    group, (i, j) = graph.group, graph.edges[chosen].T
    return group.compose(
        group.compose(poses[i], graph.measurement[chosen]), group.inverse(poses[j])
    )


def test_an_aliased_group_asks_for_one_rigid_displacement(group, seed):
    graph, truth = wander(seed, group, spread=1e-7)
    rng = np.random.default_rng(seed)
    longer, is_lie = add_aliased_closures(graph, 2, rng, size=8, poses=truth)
    moves = displacements(longer, truth, is_lie).reshape(2, 8, *group.POSE_SHAPE)
    for one in moves:
        assert_same_poses(group, one, np.broadcast_to(one[0], one.shape), atol=1e-3)
    assert not np.allclose(moves[0, 0], moves[1, 0], atol=1e-2)


def cycle_errors(graph, chosen):
    """‖Log(z_p ∘ O(j_p→j_q) ∘ z_q⁻¹ ∘ O(i_q→i_p))‖ of all pairs, from the odometry alone."""
    group, along = graph.group, dead_reckoning(graph)
    (i, j), z = graph.edges[chosen].T, graph.measurement[chosen]
    p, q = np.triu_indices(len(z), 1)
    there = group.compose(z[p], group.between(along[j[p]], along[j[q]]))
    back = group.compose(group.inverse(z[q]), group.between(along[i[q]], along[i[p]]))
    return np.linalg.norm(group.log(group.compose(there, back)), axis=1)


def test_every_cycle_of_two_aliased_closures_closes_and_those_of_other_lies_do_not(group, seed):
    graph, truth = wander(seed, group, spread=1e-6)
    found = [
        cycle_errors(*add(graph, 1, np.random.default_rng(seed), poses=truth, size=6))
        for add in (add_aliased_closures, add_grouped_closures)
    ]
    # Odometry noise of 1e-6 over at most 150 steps, with levers of at most 150 m.
    assert found[0].max() < 1e-2
    assert found[1].max() > 0.1


def test_an_aliased_group_starts_where_two_poses_are_taken_for_one(group):
    graph, truth = wander(10, group, spread=1e-7)
    rng = np.random.default_rng(11)
    longer, is_lie = add_aliased_closures(graph, 1, rng, size=6, poses=truth)
    first = longer.measurement[is_lie][0]
    assert_same_poses(group, first, group.identity(), atol=1e-5)


def test_an_aliased_group_is_found_where_two_stretches_look_alike():
    # Two straight streets and a bend between them that is nowhere like itself.
    rng = np.random.default_rng(12)
    bend = np.concatenate([np.zeros(14), rng.uniform(0.2, 0.6, 16), np.zeros(14)])
    z = np.stack([np.ones(44), np.zeros(44), bend], axis=1)
    edges = np.stack([np.arange(44), np.arange(1, 45)], axis=1)
    information = np.tile(1e12 * np.eye(3), (44, 1, 1))
    graph = PoseGraph(45, edges, z, information, np.ones(44, dtype=bool))
    longer, is_lie = add_aliased_closures(graph, 1, rng, size=10, apart=5.0)
    i, j = longer.edges[is_lie].T
    assert i.max() <= 14
    assert j.min() >= 30
    np.testing.assert_allclose(longer.measurement[is_lie], 0.0, atol=1e-4)


@pytest.mark.parametrize("fraction", [0.0, 0.3, 1.0])
def test_spoiling_replaces_the_asked_share_in_place(group, seed, fraction):
    graph, truth = wander(seed, group, closures=20)
    worse, is_lie = spoil_closures(graph, fraction, np.random.default_rng(seed), poses=truth)
    assert is_lie.sum() == round(20 * fraction)
    assert not np.any(is_lie & graph.is_odometry)
    for name in ("edges", "information", "is_odometry"):
        np.testing.assert_array_equal(getattr(worse, name), getattr(graph, name))
    np.testing.assert_array_equal(worse.measurement[~is_lie], graph.measurement[~is_lie])
    u = pose_graph.residual_norms(truth, worse)
    assert np.all(u[is_lie] > 20.0)
    assert u[~is_lie].max() < 7.0


def test_a_spoiled_closure_measures_another_pose_that_is_far_enough(group, seed):
    graph, truth = wander(seed, group, closures=20, spread=1e-7)
    rng = np.random.default_rng(seed)
    worse, is_lie = spoil_closures(graph, 0.5, rng, poses=truth, apart=3.0)
    assert errors(worse, truth, is_lie).min() >= 3.0 - 1e-4
    put = group.compose(truth[worse.edges[is_lie, 0]], worse.measurement[is_lie])
    gap = group.translation(put)[:, None] - group.translation(truth)
    assert np.linalg.norm(gap, axis=2).min(axis=1).max() < 1e-4


def test_the_noise_of_a_spoiled_closure_is_that_of_an_honest_one(group, seed):
    # Poses are 1 m apart, so that the one that a closure measures is the nearest to it.
    graph, truth = wander(seed, group, n=300, closures=150, spread=0.01)
    worse, is_lie = spoil_closures(graph, 1.0, np.random.default_rng(seed), poses=truth)
    start, z = truth[worse.edges[is_lie, 0]], worse.measurement[is_lie]
    put = group.translation(group.compose(start, z))[:, None]
    meant = np.linalg.norm(put - group.translation(truth), axis=2).argmin(axis=1)
    r = group.log(group.between(group.between(start, truth[meant]), z))
    squares = np.einsum("ka,kab,kb->k", r, worse.information[is_lie], r)
    # The mean of 150 times χ² with D degrees has the variance 2 D/150.
    assert squares.mean() == pytest.approx(group.DOF, abs=4.0 * np.sqrt(2.0 * group.DOF / 150))


def test_which_closures_are_spoiled_is_drawn():
    graph, truth = wander(0, se2, closures=20)
    masks = [
        spoil_closures(graph, 0.4, np.random.default_rng(seed), poses=truth)[1]
        for seed in (1, 1, 2)
    ]
    np.testing.assert_array_equal(masks[0], masks[1])
    assert not np.array_equal(masks[0], masks[2])


@refused(
    ({"count": -1}, "count is -1"),
    ({"count": 3, "apart": 1000.0}, "only 0 pairs at least 1e"),
    ({"count": 2000}, "count is 2000, and only"),
    ({"count": 1, "poses": np.zeros((3, 3))}, "poses: the shape"),
)
def test_what_cannot_be_drawn_is_refused(wrong, message):
    with pytest.raises(ValueError, match=message):
        spoiled(**wrong)


@pytest.mark.parametrize(
    ("name", "arguments", "told"),
    [
        ("add_local_closures", {"count": 3, "reach": 1}, "reach is 1"),
        ("add_local_closures", {"count": -2}, "count is -2"),
        ("add_local_closures", {"count": 3, "apart": 21.0}, "only 0 pairs at least 21 m"),
        ("add_grouped_closures", {"groups": -1}, "groups is -1"),
        ("add_grouped_closures", {"groups": 1, "size": 0}, "size is 0"),
        ("add_grouped_closures", {"groups": 1, "size": 200}, "only 0 groups of 200"),
        ("add_grouped_closures", {"groups": 1, "reach": 0}, "reach is 0"),
        ("add_aliased_closures", {"groups": -1}, "groups is -1"),
        ("add_aliased_closures", {"groups": 1, "size": 0}, "size is 0"),
        ("add_aliased_closures", {"groups": 1, "size": 150}, "only 0 groups of 150"),
        ("spoil_closures", {"fraction": 1.5}, "fraction is 1.5"),
        ("spoil_closures", {"fraction": float("nan")}, "fraction is nan"),
        ("spoil_closures", {"fraction": 0.5, "apart": 1e4}, "apart is 1e"),
    ],
)
def test_what_cannot_be_is_refused_by_name(group, name, arguments, told):
    graph, truth = wander(0, group)
    with pytest.raises(ValueError, match=told):
        getattr(outliers, name)(graph, rng=np.random.default_rng(0), poses=truth, **arguments)


def test_poses_of_another_shape_are_refused(group):
    graph, _ = wander(0, group)
    wrong = random_poses(group, 3, np.random.default_rng(0))
    with pytest.raises(ValueError, match="poses: the shape"):
        spoil_closures(graph, 0.5, np.random.default_rng(0), poses=wrong)
