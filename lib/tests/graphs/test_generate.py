"""Generated graphs: the truth fits, the noise is what it claims, the seed decides."""

import numpy as np
import pytest
from robust_slam.graphs import dead_reckoning, pose_graph
from robust_slam.graphs.generate import Noise, circle, manhattan, sphere
from robust_slam.groups import se2, se3
from robust_slam.groups.group import group_of

from ..worlds import assert_same_poses

LOUD = Noise(odometry=(0.3, 0.1), closure=(0.2, 0.05))


@pytest.fixture(params=[circle, manhattan, sphere])
def make(request):
    return request.param


def places(poses):
    return group_of(poses).translation(poses)


def test_the_same_seed_gives_the_same_graph_and_another_seed_another(make):
    first, again, other = (make(60, np.random.default_rng(seed))[0] for seed in (1, 1, 2))
    for name in ("edges", "measurement", "information", "is_odometry"):
        np.testing.assert_array_equal(getattr(first, name), getattr(again, name))
    assert not np.array_equal(first.measurement, other.measurement)


def test_without_noise_the_truth_costs_nothing_and_dead_reckoning_finds_it(make):
    graph, truth = make(50, np.random.default_rng(3), noise=Noise(scale=0.0))
    assert pose_graph.cost(graph, truth) < 1e-20
    assert_same_poses(graph.group, dead_reckoning(graph), truth, atol=1e-12)


@pytest.mark.parametrize("odometry", [True, False])
def test_each_component_of_the_noise_is_independent_and_has_its_own_deviation(make, odometry):
    options = {"laps": 6} if make is circle else {}
    rng = np.random.default_rng(11)
    graph, truth = make(3000, rng, closures=2500, noise=LOUD, **options)
    chosen = graph.is_odometry == odometry
    d, rest = (3, 3) if make is sphere else (2, 1)
    deviation = np.repeat(LOUD.odometry if odometry else LOUD.closure, [d, rest])
    expected = np.broadcast_to(np.diag(deviation**-2.0), graph.information[chosen].shape)
    np.testing.assert_allclose(graph.information[chosen], expected, rtol=1e-12)
    u = pose_graph.residuals(graph, truth)[chosen] / deviation
    # An entry of the covariance of k draws has at most the deviation √(2/k), the mean √(1/k).
    spread = np.sqrt(2.0 / len(u))
    np.testing.assert_allclose(np.cov(u.T), np.eye(len(deviation)), atol=5.0 * spread)
    np.testing.assert_allclose(u.mean(axis=0), 0.0, atol=4.0 * spread)


def test_the_scale_changes_the_noise_and_not_the_claim(make):
    made = (make(30, np.random.default_rng(6), noise=Noise(scale=scale)) for scale in (1.0, 0.5))
    (full, truth), (half, _) = made
    np.testing.assert_array_equal(full.information, half.information)
    expected = 0.5 * pose_graph.residuals(full, truth)
    np.testing.assert_allclose(pose_graph.residuals(half, truth), expected, atol=1e-12)


def test_odometry_comes_first_step_by_step_and_closures_are_revisits(make):
    options = {"laps": 3, "closures": 9} if make is circle else {"closures": 9}
    graph, truth = make(60, np.random.default_rng(7), **options)
    i, j = graph.edges.T
    np.testing.assert_array_equal(graph.edges[:59], [[k, k + 1] for k in range(59)])
    assert graph.is_odometry.tolist() == [True] * 59 + [False] * 9
    assert np.all(j[59:] > i[59:] + 1)
    assert len({(a, b) for a, b in graph.edges.tolist()}) == 68
    place = np.linalg.norm(places(truth)[i] - places(truth)[j], axis=1)
    assert place[59:].max() <= place[:59].max() * (1 + 1e-9)


def test_the_circle_is_a_circle_from_the_origin_to_the_left():
    _, truth = circle(40, np.random.default_rng(8), radius=3.0)
    np.testing.assert_array_equal(truth[0], np.zeros(3))
    np.testing.assert_allclose(np.hypot(truth[:, 0], truth[:, 1] - 3.0), 3.0, rtol=1e-12)
    steps = se2.between(truth[:-1], truth[1:])
    np.testing.assert_allclose(steps, np.tile(steps[0], (39, 1)), atol=1e-12)
    assert steps[0, 2] == pytest.approx(2 * np.pi / 40)


def test_the_way_round_the_sphere_stays_on_it_and_has_its_z_axis_out():
    # Pose 0 has its z axis out of the sphere, so that the centre is at (0, 0, −radius).
    _, truth = sphere(400, np.random.default_rng(13), radius=3.0)
    assert_same_poses(se3, truth[0], se3.identity(), atol=1e-15)
    spoke = places(truth) - [0.0, 0.0, -3.0]
    np.testing.assert_allclose(np.linalg.norm(spoke, axis=1), 3.0, rtol=1e-12)
    np.testing.assert_allclose(truth[:, :, 2], spoke / 3.0, atol=1e-12)
    np.testing.assert_allclose(np.linalg.det(truth[:, :, :3]), 1.0, rtol=1e-12)
    # Round the first pole the robot goes anticlockwise, with the pole on its left.
    assert np.all(se3.between(truth[:19], truth[1:20])[:, 1, 3] > 0.0)


def test_on_the_sphere_ahead_is_the_way_that_the_robot_goes():
    # Two turns by 3000 poses, far from the poles: the chord from the pose before to the pose
    # behind is the tangent up to the square of a step, (2π/1500)² < 2e-5.
    _, truth = sphere(3000, np.random.default_rng(18), around=1500)
    chord = places(truth)[2:] - places(truth)[:-2]
    chord /= np.linalg.norm(chord, axis=1, keepdims=True)
    cosine = np.sum(chord * truth[1:-1, :, 0], axis=1)
    np.testing.assert_allclose(cosine[300:-300], 1.0, atol=2e-5)


@pytest.mark.parametrize(("n", "around"), [(100, 10), (60, 20), (90, 7)])
def test_neighbours_on_the_sphere_are_as_far_apart_as_their_angles_say(n, around):
    # The cosine between the directions at colatitudes a and b is
    # cos a cos b + sin a sin b cos(difference of longitudes); the chord is r √(2 − 2 cos).
    graph, truth = sphere(n, np.random.default_rng(14), around=around, radius=2.0)
    i, j = graph.edges.T
    a, b = np.pi * (i + 0.5) / n, np.pi * (j + 0.5) / n
    cosine = np.cos(a) * np.cos(b) + np.sin(a) * np.sin(b) * np.cos(2 * np.pi * (j - i) / around)
    gap = np.linalg.norm(places(truth)[i] - places(truth)[j], axis=1)
    np.testing.assert_allclose(gap, 2.0 * np.sqrt(2.0 - 2.0 * cosine), rtol=1e-9)


def test_fewer_closures_are_drawn_from_them_all():
    made = (sphere(50, np.random.default_rng(seed), around=8, closures=5) for seed in range(40))
    draws = [graph.edges[49:] for graph, _ in made]
    assert all(len(np.unique(edges, axis=0)) == 5 for edges in draws)
    # One of the 42 is left out by all 40 draws of 5 with probability (37/42)^40 = 0.6 %.
    found = np.unique(np.concatenate(draws), axis=0)
    assert len(found) > 36
    np.testing.assert_array_equal(np.diff(found), 8)


@pytest.mark.parametrize("n", [3, 4, 5, 9, 10])
def test_a_short_way_round_the_sphere_is_a_graph_too(n):
    graph, truth = sphere(n, np.random.default_rng(17), noise=Noise(scale=0.0))
    assert np.sum(graph.is_odometry) == n - 1
    assert pose_graph.cost(graph, truth) < 1e-20


@pytest.mark.parametrize("seed", range(5))
def test_the_walk_keeps_to_the_streets_of_the_town(seed):
    _, truth = manhattan(80, np.random.default_rng(seed), block=2.0, side=3)
    np.testing.assert_array_equal(truth[0, :2], [0.0, 0.0])
    assert set(np.unique(truth[:, :2])) <= {0.0, 2.0, 4.0, 6.0}
    steps = se2.between(truth[:-1], truth[1:])
    np.testing.assert_allclose(steps[:, :2], np.tile([2.0, 0.0], (79, 1)), atol=1e-12)
    quarter_turns = steps[:, 2] / (np.pi / 2)
    np.testing.assert_allclose(quarter_turns, np.round(quarter_turns), atol=1e-12)
    assert np.abs(quarter_turns).max() < 1.5


def test_a_walk_that_never_turns_of_itself_goes_round_the_town():
    _, truth = manhattan(12, np.random.default_rng(1), side=3, turn=0.0, closures=0)
    on_the_edge = np.any((truth[:, :2] == 0.0) | (truth[:, :2] == 3.0), axis=1)
    assert np.all(on_the_edge)
    assert len(np.unique(truth[:, :2], axis=0)) == 12


@pytest.mark.parametrize("neighbours", [1, 3, 5])
def test_a_pose_of_the_sphere_has_neighbours_on_the_next_ring(neighbours):
    graph, _ = sphere(120, np.random.default_rng(0), around=12, neighbours=neighbours)
    first, after = graph.edges[~graph.is_odometry].T
    inside = first < 120 - 12 - neighbours
    assert np.all(np.bincount(first[inside]) == neighbours)
    assert set((after - first).tolist()) == set(range(12 - neighbours // 2, 13 + neighbours // 2))


@pytest.mark.parametrize(
    ("make", "wrong", "message"),
    [
        (circle, {"n": 2}, "n is 2"),
        (circle, {"laps": 0}, "laps 0"),
        (circle, {"radius": 0.0}, "radius is 0.0"),
        (circle, {"closures": 2}, "closures is 2, and 1 pairs"),
        (circle, {"noise": Noise(odometry=(0.1, 0.1, 0.1))}, "noise.odometry: the shape"),
        (circle, {"noise": Noise(closure=(1.0, -1.0))}, "noise.closure is"),
        (sphere, {"noise": Noise(odometry=(0.1, 0.0))}, "noise.odometry is"),
        (sphere, {"n": 2}, "n is 2"),
        (sphere, {"around": 2}, "around is 2"),
        (sphere, {"radius": 0.0}, "radius is 0.0"),
        (sphere, {"closures": 17}, "closures is 17, and 16 pairs"),
        (sphere, {"closures": -1}, "closures is -1"),
        (sphere, {"neighbours": 2}, "neighbours is 2"),
        (manhattan, {"n": 2}, "n is 2"),
        (manhattan, {"turn": 1.5}, "turn is 1.5"),
        (manhattan, {"side": 0}, "side is 0"),
        (manhattan, {"block": -1.0}, "block is -1.0"),
    ],
)
def test_bad_input_is_refused_by_name(make, wrong, message):
    with pytest.raises(ValueError, match=message):
        make(**({"n": 20, "rng": np.random.default_rng(0)} | wrong))
