"""A growing map withdraws and takes back closures, and ends where the batch ends."""

import copy
import pickle

import numpy as np
import pytest
from robust_slam import GrowingMap, solve
from robust_slam.descent import covariance, gauss_newton
from robust_slam.descent.normal_equations import NormalEquations
from robust_slam.descent.step import retract
from robust_slam.graphs import PoseGraph, circle, dead_reckoning, manhattan, sphere
from robust_slam.graphs.outliers import add_grouped_closures
from robust_slam.graphs.pose_graph import ROWS, from_checked, jacobians, rows_of, select
from robust_slam.groups import se2
from robust_slam.incremental.window import Window

from .worlds import assert_same_poses, random_graph, refused, with_outliers


def in_order(graph):
    """The edges by their larger pose."""
    return np.argsort(graph.edges.max(axis=1), kind="stable")


def rows(graph, chosen):
    names = ("edges", "measurement", "information", "is_odometry")
    return {name: getattr(graph, name)[chosen] for name in names}


def replayed(graph, watch=lambda growing, pose: None):
    """The map that grew by one pose after the other."""
    last = graph.edges.max(axis=1)
    growing = GrowingMap(PoseGraph(2, **rows(graph, last <= 1)))
    for pose in range(2, graph.n):
        growing.add(**rows(graph, last == pose))
        watch(growing, pose)
    return growing


def test_a_descent_that_is_under_way_is_done_before_a_map_is_kept(monkeypatch):
    for name in ("_AT_ONCE", "_PIECE"):
        monkeypatch.setattr(f"robust_slam.incremental.growing_map.{name}", 0)
    made = []

    def watch(growing, pose):
        if growing._work is not None and not made:
            made.extend([pickle.loads(pickle.dumps(growing)), growing])
            np.testing.assert_array_equal(made[0].kept, made[1].kept)

    replayed(with_outliers(manhattan, 60, 0, 8, closures=30)[0], watch)
    assert len(made) == 2 and made[0]._work is None


@pytest.mark.parametrize("again", [copy.copy, lambda grown: pickle.loads(pickle.dumps(grown))])
def test_a_robot_that_stops_goes_on_where_it_was(again):
    graph, *_ = with_outliers(manhattan, 60, 0, 8, closures=30)
    last = graph.edges.max(axis=1)
    growing = replayed(PoseGraph(40, **rows(graph, last < 40)))
    before, other = growing.kept.copy(), again(growing)
    for pose in range(40, graph.n):
        other.add(**rows(graph, last == pose))
    np.testing.assert_array_equal(growing.kept, before)
    whole = replayed(graph)
    np.testing.assert_array_equal(other.kept, whole.kept)
    assert_same_poses(graph.group, other.poses, whole.poses, atol=0.02)
    older = growing.__getstate__() | {"version": 0}
    with pytest.raises(ValueError, match=r"version 0 of its file, .* reads 2; add its edges to"):
        GrowingMap.__new__(GrowingMap).__setstate__(older)


@pytest.mark.parametrize(
    ("make", "n", "options", "count"),
    [(manhattan, 150, {"closures": 60}, 20), (sphere, 80, {}, 20)],
    ids=["manhattan", "sphere"],
)
@pytest.mark.long
def test_after_the_last_edge_the_answer_is_that_of_the_batch(make, n, options, count, seed):
    graph, is_outlier, *_ = with_outliers(make, n, seed, count, **options)
    order, wrong = in_order(graph), []
    growing = replayed(
        graph, lambda grown, pose: wrong.append(grown.kept & is_outlier[order][: grown.kept.size])
    )
    # The noise is found with random signs, one for each edge in its place.
    batch, answer = solve(PoseGraph(n, **rows(graph, order))), growing.answer()
    np.testing.assert_array_equal(answer.kept, batch.kept)
    assert_same_poses(graph.group, answer.poses, batch.poses)
    assert np.sum(growing.kept != answer.kept) <= 1
    assert not any(np.any(each) for each in wrong)
    best = gauss_newton(select(growing.graph, growing.kept), growing.poses)
    assert_same_poses(graph.group, growing.poses, best, atol=0.02)


@pytest.mark.long
def test_a_group_of_outliers_that_comes_first_is_not_kept_when_inliers_come():
    for seed in (2, 3):
        rng = np.random.default_rng(seed)
        clean, truth = circle(100, rng, laps=2, closures=40)
        graph, is_outlier = add_grouped_closures(clean, 1, rng, poses=truth)
        growing = replayed(graph)
        np.testing.assert_array_equal(growing.kept, ~is_outlier[in_order(graph)])


def there_and_back(half=25, lie=1.2):
    """A drive that returns along its way, and edges that join places, the first of them a lie."""
    ahead = [[1.0, 0.0, 0.0]] * half + [[0.0, 0.0, np.pi]] + [[1.0, 0.0, 0.0]] * half
    n = len(ahead) + 1
    odometry = PoseGraph(
        n,
        [[k, k + 1] for k in range(n - 1)],
        ahead,
        np.diag(np.array([0.1, 0.1, 0.01]) ** -2.0),
        np.ones(n - 1, dtype=bool),
    )
    closures = [[k, n - 1 - k] for k in range(6)]
    measured = [[0.0, lie if k == 0 else 0.0, np.pi] for k in range(6)]
    return odometry, closures, measured, np.diag(np.array([0.02, 0.02, 0.002]) ** -2.0)


@pytest.mark.parametrize("others", [0, 24], ids=["closures double", "among many closures"])
def test_an_outlier_that_was_kept_is_withdrawn_and_inliers_return_when_evidence_turns(others):
    odometry, closures, measured, information = there_and_back()
    growing, kept = GrowingMap(odometry, find_noise=False), []
    if others:
        near = [[k, k + 2] for k in range(others)]
        growing.add(near, [[2.0, 0.0, 0.0]] * others, odometry.information[0])
    for edge, z in zip(closures[:4], measured, strict=False):
        growing.add([edge], [z], information)
        kept.append(growing.kept[odometry.n - 1 + others :].tolist())
    assert kept[0] == [True]
    assert kept[1] == [True, False]
    assert kept[-1] == [False, True, True, True]
    assert_same_poses(se2, growing.poses, dead_reckoning(odometry), atol=1e-6)


@pytest.mark.long
def test_a_removed_closure_leaves_the_map_that_never_had_it(seed):
    graph, is_outlier, _, clean = with_outliers(manhattan, 100, seed, 10, closures=40)
    growing, never = replayed(graph), replayed(clean)
    for row in np.flatnonzero(is_outlier[in_order(graph)]):
        growing.remove(int(row))
    np.testing.assert_array_equal(growing.graph.edges, never.graph.edges)
    np.testing.assert_array_equal(growing.kept, never.kept)
    assert_same_poses(se2, growing.poses, never.poses, atol=0.02)
    inlier = int(growing.numbers[np.flatnonzero(growing.kept & ~growing.graph.is_odometry)[-1]])
    growing.remove(inlier)
    assert inlier not in growing.numbers
    fewer = GrowingMap(growing.graph)
    np.testing.assert_array_equal(growing.kept, fewer.kept)
    assert_same_poses(se2, growing.poses, fewer.poses)


def test_a_lie_that_is_removed_gives_back_the_closure_that_it_contradicted():
    odometry, closures, measured, information = there_and_back()
    growing = GrowingMap(odometry)
    lie, truth = growing.add(closures[:1], measured[:1], information), closures[1]
    growing.add([truth], measured[1:2], information)
    assert growing.kept[-2:].tolist() == [True, False]
    growing.remove(int(lie[0]))
    assert growing.kept[-1]


def test_a_step_in_the_window_is_the_step_over_all_poses(group, seed):
    poses, graph = random_graph(seed, group, n=9, m=18, residual=0.05)
    early = np.all(graph.edges < 7, axis=1)
    kept = early & (np.arange(18) % 5 != 4) | (graph.is_odometry & early)
    before = PoseGraph(7, **rows(graph, early))
    window = Window(before, poses[:7], kept[early])
    order = np.concatenate([np.flatnonzero(early), np.flatnonzero(~early)])
    whole, later = rows_of(graph, order), np.ones(18, dtype=bool)
    later[np.flatnonzero(kept[order] & ~whole.is_odometry)[:2]] = False
    equations = NormalEquations(select(whole, later))
    here = equations.at(poses, np.ones(int(later.sum())))
    expected = retract(graph, poses, here.step()[0])
    assert_same_poses(group, window.stepped(whole, poses, later)[0], expected, atol=1e-7)
    at = np.array([2, 8])
    asked = from_checked(
        9,
        {name: getattr(whole, name)[:2] for name in ROWS} | {"edges": np.array([[0, 2], [0, 8]])},
    )
    found, (_, by) = window.predicted(whole, poses, later, asked), jacobians(asked, poses)
    expected = by @ covariance(select(whole, later), poses, at) @ np.swapaxes(by, 1, 2)
    np.testing.assert_allclose([found[0, :, 0], found[1, :, 1]], expected, rtol=1e-6)


def small():
    return GrowingMap(PoseGraph(3, [[0, 1], [1, 2]], [[1, 0, 0]] * 2, [np.eye(3)] * 2, [True] * 2))


@refused(
    ({"edges": [[0, 9]]}, r"edge 0 is \[0, 9\]"),
    ({"edges": [[0, 3]]}, r"edge 0 is \[0, 3\], and no odometry leads to pose 3; add odometry"),
    ({"edges": [[2, 2]]}, "edge 0 joins pose 2 to itself"),
    ({"edges": [0, 2]}, r"edges: the shape is \(2,\)"),
    ({"measurement": [[np.nan, 0, 0]]}, r"measurement: the entry at \(0, 0\) is not finite"),
    ({"measurement": [[1, 0]]}, r"measurement: the shape is \(1, 2\)"),
    ({"information": -np.eye(3)}, "edge 0 is not positive definite"),
    ({"information": np.eye(6)}, r"information: the shape is \(6, 6\)"),
    ({"is_odometry": [1]}, "give booleans"),
)
def test_edges_that_are_refused_change_nothing(wrong, message):
    growing = small()
    given = {"edges": [[0, 2]], "measurement": [[2, 0, 0]], "information": np.eye(3)}
    with pytest.raises(ValueError, match=message):
        growing.add(**(given | wrong))
    assert growing.add(**given).tolist() == [2]
    assert growing.kept.tolist() == [True] * 3 and len(growing.poses) == 3


def test_an_edge_that_cannot_be_removed_is_named_and_odometry_that_is_given_twice_moves_the_map():
    growing = small()
    (closure,) = growing.add([[0, 2]], [[2, 0, 0]], np.eye(3)).tolist()
    growing.remove(closure)
    for edge, message in (
        (closure, "edge 2 was removed before"),
        (7, "there is no edge 7; edges are 0 to 2"),
        (1, r"edge 1 \(1-2\) is the odometry that leads to pose 2; add odometry"),
    ):
        with pytest.raises(ValueError, match=message):
            growing.remove(edge)
    assert growing.numbers.tolist() == [0, 1]
    growing = small()
    growing.add([[0, 1]], [[2, 0, 0]], np.eye(3), [True])
    np.testing.assert_allclose(growing.poses[:, 0], [0.0, 1.5, 2.5], atol=1e-9)
    growing.remove(0)
    np.testing.assert_allclose(growing.poses[:, 0], [0.0, 2.0, 3.0], atol=1e-9)
