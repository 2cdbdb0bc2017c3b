"""A factor graph as a problem of the loop: its minimum, its thresholds, its frame."""

from dataclasses import replace

import numpy as np
import pytest
from robust_slam.errors import NotConverged, Underdetermined
from robust_slam.estimators import chi_square_threshold, gnc, irls, kernels, max_mixture
from robust_slam.estimators.switches import dcs, switchable
from robust_slam.factors import FactorGraph, FactorGraphProblem, Factors, park
from robust_slam.factors.equations import FactorEquations, descend
from robust_slam.factors.problem import thresholds_of
from robust_slam.graphs.pose_graph import residual_norms
from robust_slam.groups import se3
from robust_slam.problems import PoseGraphProblem

from ..worlds import assert_same_poses, curving_walk, refused, shaken
from .made import error, everything


def test_a_pose_graph_is_solved_as_by_its_own_problem(group):
    graph, _ = curving_walk(group, 0)
    ours, theirs = FactorGraphProblem(graph, steps=1), PoseGraphProblem(graph, steps=1)
    one, other = gnc(ours, x0=ours.guess), gnc(theirs, x0=theirs.guess)
    np.testing.assert_array_equal(one.kept, other.kept)
    assert_same_poses(group, one.x, other.x)
    assert one.cost == pytest.approx(other.cost)


METHODS = {
    "irls": lambda p: irls(p, kernels.geman_mcclure(p.threshold), p.guess, tol=1e-6),
    "gnc": lambda p: gnc(p, x0=p.guess),
    "dcs": lambda p: dcs(p, x0=p.guess, tol=1e-6),
    "switchable": lambda p: switchable(p, x0=p.guess, tol=1e-6),
    "max_mixture": lambda p: max_mixture(p, 0.9, 30.0, x0=p.guess, tol=1e-6),
}


@pytest.mark.parametrize("method", METHODS.values(), ids=METHODS)
def test_every_robust_method_takes_it_and_beats_least_squares(method, seed):
    graph, truth, is_wrong = park(150, seed)
    problem = FactorGraphProblem(graph, steps=1)
    result = method(problem)
    least = error(graph, FactorGraphProblem(graph).initial(), truth)
    assert error(graph, result.x, truth) < 0.2 * least
    assert np.sum(result.kept & is_wrong) <= 0.05 * is_wrong.sum()
    assert np.all(result.weights[problem.trusted] == 1.0)


def test_a_factor_has_the_threshold_of_its_dimension_or_is_odometry_or_a_prior_and_trusted(group):
    graph, x = everything(group, 0)
    thresholds, d = thresholds_of(graph), group.DIMENSION
    for kind, dimension in {"points": d, "positions": d, "ranges": 1, "priors": group.DOF}.items():
        own = chi_square_threshold(0.99, dimension)
        np.testing.assert_allclose(thresholds[graph.slices[kind]], own, rtol=1e-12)
    trusted = FactorGraphProblem(graph, x).trusted
    np.testing.assert_array_equal(trusted[graph.slices["relative"]], graph.relative.is_odometry)
    assert np.all(trusted[graph.slices["priors"]])
    assert trusted.sum() == graph.relative.is_odometry.sum() + 2


def test_a_norm_at_its_own_threshold_is_at_that_of_all(group, seed):
    graph, x = everything(group, seed)
    u = FactorEquations(graph).norms(x)
    problem = FactorGraphProblem(graph, x, np.zeros(u.size, dtype=bool), thresholds=u)
    np.testing.assert_allclose(problem.residual_norms(x), problem.threshold)
    trusting = FactorGraphProblem(graph, x, np.ones(u.size, dtype=bool), thresholds=u)
    np.testing.assert_allclose(trusting.residual_norms(x), u)


def test_what_is_minimised_has_a_kernel_of_its_own_scale_for_each_factor(group):
    graph, x = everything(group, 1, error=0.3)
    eps = np.random.default_rng(1).uniform(0.5, 3.0, len(graph.ends))
    problem = FactorGraphProblem(graph, x, np.zeros(eps.size, dtype=bool), eps)
    result = irls(problem, kernels.cauchy(problem.threshold), tol=1e-10, max_iterations=500)
    u = FactorEquations(graph).norms(result.x)
    weights = np.array([kernels.cauchy(c).weight(v) for c, v in zip(eps, u, strict=True)])
    _, slope = FactorEquations(graph).system(result.x, weights)
    assert np.abs(slope[1:]).max() < 1e-5


def test_an_edge_of_a_pose_graph_has_a_threshold_of_its_own(group):
    graph, truth = curving_walk(group, 1)
    right = residual_norms(graph, truth) < 5.0
    thresholds = np.full(len(graph.edges), chi_square_threshold(0.99, group.DOF))
    kept = gnc(FactorGraphProblem(graph, thresholds=thresholds, steps=1)).kept
    np.testing.assert_array_equal(kept, right)
    closures = np.flatnonzero(right & ~graph.is_odometry)
    thresholds[closures] = 1e-3
    kept = gnc(FactorGraphProblem(graph, thresholds=thresholds, steps=1)).kept
    assert not np.any(kept[closures]) and np.all(kept[graph.is_odometry])


def test_without_a_prior_pose_0_is_held_and_with_one_nothing_is_at_the_least_squares(group):
    graph, x = everything(group, 0, error=0.3)
    loose = replace(graph, priors=None, positions=None)
    problem = FactorGraphProblem(loose, x)
    np.testing.assert_array_equal(problem.initial()[0], x[0])
    moved = FactorGraphProblem(graph, x).initial()
    assert np.abs(moved[0] - x[0]).max() > 1e-3
    _, slope = FactorEquations(graph).system(moved, np.ones(len(graph.ends)))
    assert np.abs(slope).max() < 1e-4
    only = Factors([2], x[2:3], np.eye(group.DOF))
    alone = FactorGraphProblem(replace(loose, priors=only)).initial()
    assert_same_poses(group, alone[2:3], x[2:3], atol=1e-7)


def test_what_no_factor_determines_stays_where_it_is(group):
    graph, x = everything(group, 2, error=0.1)
    weights = np.ones(len(graph.ends))
    weights[np.any(graph.ends == graph.n, axis=1)] = 0.0
    moved = FactorGraphProblem(graph, x).solve(weights, x)
    np.testing.assert_array_equal(moved[graph.n], x[graph.n])
    assert np.abs(moved[graph.n + 1] - x[graph.n + 1]).max() > 1e-4


def test_a_map_whose_fixes_are_all_rejected_does_not_drift(seed):
    graph, _, is_wrong = park(80, seed)
    for left in range(2):
        weights = np.where(is_wrong, 0.0, 1.0)
        weights[graph.slices["positions"]][left:] = 0.0
        problem = FactorGraphProblem(graph)
        moved = problem.solve(weights, problem.guess)
        assert np.abs(moved[0] - problem.guess[0]).max() < (1e-6, 10.0)[left]
        _, slope = FactorEquations(graph).system(moved, weights)
        assert np.abs(slope[1:]).max() < 1e-4


def test_the_first_map_is_in_the_frame_of_the_prior_or_of_most_fixes(group):
    graph, x = everything(group, 3, error=0.0, n=12)
    place = group.translation(x[:12]).copy()
    place[[2, 5, 7]] += 30.0
    fixes = Factors(np.arange(12), place, np.eye(group.DIMENSION))
    for positions, priors in ((fixes, None), (None, graph.priors)):
        first = FactorGraphProblem(replace(graph, positions=positions, priors=priors)).guess
        assert_same_poses(group, first, x, atol=1e-3)


def test_ranges_alone_place_a_landmark_although_some_are_wrong(group):
    graph, x = everything(group, 4, error=0.0, n=30)
    beacon = x[30]
    place = group.translation(x[:30])
    distance = np.linalg.norm(place - group.translation(beacon), axis=1)
    distance[::5] += 3.0
    ends = np.stack([np.full(30, 30), np.arange(30)], axis=1)
    ranges = Factors(ends, distance, 100.0)
    alone = FactorGraph(graph.relative, landmarks=1, priors=graph.priors, ranges=ranges)
    problem = FactorGraphProblem(alone, steps=1)
    off = alone.positions_of(problem.guess)[0] - group.translation(beacon)
    assert np.linalg.norm(off) < 1.0 < np.linalg.norm(place[0] - group.translation(beacon))
    found = gnc(problem, x0=problem.guess)
    there = alone.positions_of(found.x)[0]
    np.testing.assert_allclose(there, group.translation(beacon), atol=1e-6)
    assert np.flatnonzero(~found.kept[alone.slices["ranges"]]).tolist() == list(range(0, 30, 5))


def test_poses_that_no_factor_joins_and_a_descent_that_does_not_end_say_what_to_do(monkeypatch):
    graph, _, _ = park(50, 0)
    problem = FactorGraphProblem(graph)
    weights = np.zeros(len(graph.ends))
    with pytest.raises(Underdetermined, match=r"joins pose 1 to pose 0 \(49 poses are loose\)"):
        problem.solve(weights, problem.guess)
    monkeypatch.setattr("robust_slam.factors.problem.STEP_LIMIT", 1)
    with pytest.raises(NotConverged, match=r"after 1 steps .*x0=problem.guess"):
        FactorGraphProblem(graph).initial()


@pytest.mark.long
def test_a_small_step_is_no_rest_where_it_was_damped():
    graph, x = everything(se3, 27)
    start = shaken(se3, x, 1.5, np.random.default_rng(27))
    start[graph.n :, :, :3] = np.eye(3)
    ones = np.ones(len(graph.ends))
    assert descend(FactorEquations(graph), start, ones, 1e-2, 300).here.cost < 300.0


DRIVE = park(50, 0)[0]
PAIR = np.array([[0, 50], [1, 50]])


@refused(
    (("priors", [50], np.zeros((1, 3)), np.eye(3)), "priors.nodes: entry 0 is 50; poses"),
    (("priors", [-1], np.zeros((1, 3)), np.eye(3)), "entry 0 is -1; poses are 0 to 49, landm"),
    (("priors", [[0]], np.zeros((1, 3)), np.eye(3)), r"nodes: the shape is \(1, 1\); giv"),
    (("positions", [0], [[1.0]], np.eye(2)), "positions.measurement: the shape is"),
    (("positions", [0.5], [[1.0, 2.0]], np.eye(2)), "the entries are float64; give num"),
    (("points", PAIR[:, ::-1], np.zeros((2, 2)), np.eye(2)), r"entry 0 is \[50, 0\]; pos"),
    (("points", PAIR, np.zeros((2, 2)), -np.eye(2)), "points.information: entry 0 is not"),
    (("points", PAIR, np.zeros((2, 2)), np.eye(3)), "points.information: the shape is"),
    (("ranges", [[0, 0]], [1.0], 1.0), "ranges.nodes: entry 0 joins a node to itself"),
    (("ranges", PAIR, [1.0, -1.0], 1.0), "ranges.measurement: entry 1 is negative"),
    (("landmarks", -1), "landmarks is -1"),
    (("landmarks", 90), r"landmarks: landmark \d+, node \d+, is in no factor \(\d+ are in none\)"),
)
def test_a_bad_factor_or_number_is_refused_by_name(wrong, message):
    kind, *given = wrong
    with pytest.raises(ValueError, match=message):
        replace(DRIVE, **{kind: Factors(*given) if given[1:] else given[0]})


def test_without_landmarks_a_message_tells_how_to_have_some():
    drive = DRIVE.relative
    message = "poses are 0 to 49, for landmarks give their number, lan"
    with pytest.raises(ValueError, match=message):
        FactorGraph(drive, points=Factors(PAIR, np.zeros((2, 2)), np.eye(2)))
    assert FactorGraph(drive).landmarks == 0


def test_a_prior_that_mirrors_and_what_is_no_graph_are_refused():
    graph, _ = everything(se3, 0)
    mirror = Factors([0], np.diag([1.0, 1.0, -1.0, 0.0])[None, :3], np.eye(6))
    with pytest.raises(ValueError, match=r"priors.measurement: .* 0 is not a rotation matrix"):
        replace(graph, priors=mirror)
    with pytest.raises(TypeError, match="graph is a list"):
        FactorGraphProblem([])


@refused(
    ({"guess": np.zeros((3, 3))}, "guess: the shape"),
    ({"trusted": [True]}, "trusted: the shape"),
    ({"thresholds": [1.0]}, "thresholds: the shape"),
    ({"thresholds": np.zeros(len(DRIVE.ends))}, "thresholds: entry 0 is not above 0"),
    ({"steps": 0}, "max_iterations is 0"),
)
def test_a_bad_problem_is_refused_by_name(wrong, message):
    with pytest.raises(ValueError, match=message):
        FactorGraphProblem(DRIVE, **wrong)
