"""The whole back-end finds the outliers and the noise, and tells how far its map is supported."""

from dataclasses import replace

import numpy as np
import pytest
from robust_slam.certificates.optimality import Verdict
from robust_slam.descent import covariance, gauss_newton, start
from robust_slam.estimators.thresholds import chi_square_threshold
from robust_slam.graphs import (
    Noise,
    PoseGraph,
    add_random_closures,
    ate,
    circle,
    manhattan,
    sphere,
)
from robust_slam.graphs.metrics import precision_recall
from robust_slam.graphs.odometry import accumulated_rotation, dead_reckoning
from robust_slam.graphs.outliers import add_grouped_closures, spoil_closures
from robust_slam.graphs.pose_graph import residual_norms, select, with_closures
from robust_slam.solver import Support, solve
from robust_slam.solver.evidence import evidence, gains, outlier_entropy
from robust_slam.solver.noise import Found, find_noise, rescaled

from .worlds import assert_same_poses, dense_jacobian, refused, turned, with_outliers


@pytest.mark.parametrize(
    ("make", "n", "options", "count"),
    [
        (circle, 60, {"laps": 2, "closures": 20}, 6),
        (manhattan, 100, {"closures": 40}, 13),
        (sphere, 80, {}, 23),
    ],
    ids=["circle", "manhattan", "sphere"],
)
def test_the_outliers_are_found_and_the_map_is_the_one_without_them(make, n, options, count, seed):
    graph, is_outlier, truth, clean = with_outliers(make, n, seed, count, **options)
    answer = solve(graph)
    doubted = ~graph.is_odometry
    precision, recall = precision_recall(answer.kept[doubted], ~is_outlier[doubted])
    assert precision == 1.0
    assert recall > 0.9
    assert answer.certificate.verdict is Verdict.CERTIFIED
    assert answer.support is Support.UNIQUE
    assert "optimal for the kept closures, support unique" in repr(answer)
    best = gauss_newton(clean, start.chordal(clean))
    assert ate(answer.poses, truth) < ate(best, truth) + 0.05
    norms = residual_norms(rescaled(graph, answer.best.tested), answer.best.poses)
    np.testing.assert_array_equal(answer.kept, graph.is_odometry | (norms <= answer.threshold))
    np.testing.assert_array_equal(answer.weights, answer.kept)
    np.testing.assert_array_equal(answer.rejected, np.flatnonzero(~answer.kept))
    assert answer.threshold == chi_square_threshold(0.99, graph.group.DOF)


def test_a_map_that_is_not_determined_has_no_evidence():
    """Beside the other edge, the first one is lost in rounding."""
    information = [np.eye(3) * 1e-20, np.eye(3) * 1e20]
    graph = PoseGraph(3, [[0, 1], [1, 2]], [[1, 0, 0]] * 2, information, [True, True])
    poses, every = dead_reckoning(graph), graph.is_odometry
    assert evidence(graph, poses, every, 0.0) == -np.inf
    assert not find_noise(graph, poses, every).enough


def test_closures_that_contradict_most_others_are_kept_where_they_fit_the_map():
    """In this town the odometry is off, and every fourth inlier contradicts the others."""
    clean, truth = manhattan(300, 0, closures=100)
    for add, count in ((add_random_closures, 100), (add_grouped_closures, 10)):
        graph, is_outlier = add(clean, count, 1, poses=truth)
        answer = solve(graph)
        assert np.sum(~graph.is_odometry & ~is_outlier & ~answer.kept) <= 2
        assert not np.any(answer.kept & is_outlier)
        assert answer.certificate.verdict is Verdict.CERTIFIED


def test_a_single_outlier_bends_no_odometry():
    graph, is_outlier, *_ = with_outliers(manhattan, 60, 9, 1, closures=0)
    answer = solve(graph)
    assert np.array_equal(answer.kept, ~is_outlier)
    assert answer.support is Support.WEAK
    assert "Odometry alone has nearly" in answer.summary()


@pytest.mark.long
def test_where_odometry_loses_its_rotation_outliers_do_not_bend_the_map():
    """A sphere of 460 poses with 92 outliers is solved from several starts and certified."""
    noise = Noise(odometry=(0.05, 0.15), closure=(0.05, 0.15))
    clean, truth = sphere(460, 0, around=20, noise=noise)
    graph, is_outlier = add_random_closures(clean, 92, 0, poses=truth)
    assert accumulated_rotation(graph, graph.is_odometry) > np.pi
    answer = solve(graph)
    assert not np.any(answer.kept & is_outlier)
    assert answer.rejected.size - 92 < 0.1 * np.sum(~clean.is_odometry)
    assert answer.certificate.verdict is Verdict.CERTIFIED


@pytest.mark.parametrize(
    "factors",
    [(0.1,) * 4, (1 / 3,) * 4, (3,) * 4, (10,) * 4, (60,) * 4, (1, 10, 1, 10), (3, 3, 1, 1)],
    ids=str,
)
@pytest.mark.long
def test_claims_that_are_wrong_are_found_and_change_neither_outliers_nor_map(factors):
    graph, is_outlier, truth, clean = with_outliers(manhattan, 100, 0, 20, closures=200)
    misclaimed = rescaled(graph, np.array(factors, dtype=float))
    answer = solve(misclaimed)
    assert not np.any(answer.kept & is_outlier)
    assert np.sum(~answer.kept & ~is_outlier) <= 0.03 * 200
    np.testing.assert_allclose(answer.noise * factors, 1.0, rtol=0.35)
    assert ate(answer.poses, truth) < ate(gauss_newton(clean, truth), truth) + 0.02
    if max(factors) > 3 or min(factors) < 1 / 3:
        assert "differs from the claims" in answer.summary()
    kept = solve(misclaimed, find_noise=False)
    np.testing.assert_array_equal(kept.noise, np.ones(4))


def test_noise_is_that_of_the_draws():
    deviations = Noise(odometry=(0.05, 0.02), closure=(0.2, 0.01))
    graph, truth = manhattan(300, 3, closures=300, noise=deviations)
    found = find_noise(graph, gauss_newton(graph, truth), np.ones(len(graph.edges), dtype=bool))
    np.testing.assert_allclose(found.factors, 1.0, rtol=0.15)
    assert found.redundancy.sum() == pytest.approx(3 * (len(graph.edges) - graph.n + 1), rel=0.05)
    tree = select(graph, graph.is_odometry)
    alone = find_noise(tree, dead_reckoning(tree), tree.is_odometry)
    assert not alone.enough and np.array_equal(alone.factors, np.ones(4))


def test_the_noise_of_an_answer_is_settled_also_where_kinds_of_few_edges_share_a_factor(seed):
    graph, poses = manhattan(60, seed, closures=15)
    every, scale = np.ones(len(graph.edges), dtype=bool), np.ones(4)
    for _ in range(4):
        scaled = rescaled(graph, scale)
        poses = gauss_newton(scaled, poses)
        found = find_noise(scaled, poses, every, scale)
        expected, scale = scale * found.expected, scale * found.factors
    np.testing.assert_allclose(found.factors, 1.0, atol=1e-3)
    np.testing.assert_array_equal(scale[:2], scale[2:])
    np.testing.assert_allclose(solve(graph).noise, expected, rtol=0.005)


def test_the_expected_variance_is_that_of_its_redundancy():
    found = Found(np.array([1.0, 2.0, 1.0, 3.0]), np.array([22.0, 18.0, 8.0, 42.0]))
    shares = np.array([22 / 20, 60 / 58, 30 / 28, 42 / 40])
    np.testing.assert_allclose(found.expected, found.factors * np.sqrt(shares))


def test_evidence_is_the_integral_over_all_poses():
    graph, _ = manhattan(20, 1, closures=3)
    poses, kept = gauss_newton(graph, dead_reckoning(graph)), np.ones(len(graph.edges), dtype=bool)
    rows = dense_jacobian(graph, poses)[:, :, 1:].reshape(len(kept), 3, -1)
    hessian = np.sum(np.swapaxes(rows, 1, 2) @ graph.information @ rows, axis=0)
    squares = np.sum(residual_norms(graph, poses) ** 2)
    logs = np.linalg.slogdet(graph.information)[1].sum() - np.linalg.slogdet(hessian)[1]
    closures = np.sum(~graph.is_odometry)
    entropy = outlier_entropy(graph)
    expected = closures * (entropy - 1.5 * np.log(2 * np.pi)) + 0.5 * (logs - squares)
    assert evidence(graph, poses, kept, entropy) == pytest.approx(expected)
    assert evidence(graph, dead_reckoning(graph), graph.is_odometry, entropy) == pytest.approx(0.0)


@pytest.mark.parametrize("make", [manhattan, sphere])
def test_a_gain_is_the_evidence_that_the_map_of_the_others_lacks(make):
    graph, truth = make(40, 1, closures=8)
    every, entropy = np.ones(len(graph.edges), dtype=bool), outlier_entropy(graph)

    def best(kept):
        poses = gauss_newton(select(graph, kept), truth)
        return poses, evidence(graph, poses, kept, entropy)

    poses, whole = best(every)
    asked = ~graph.is_odometry & (np.arange(len(every)) % 2 == 0)
    lacking = [whole - best(np.arange(len(every)) != k)[1] for k in np.flatnonzero(asked)]
    np.testing.assert_allclose(gains(graph, poses, every, asked, entropy), lacking, atol=0.05)


def test_little_evidence_leaves_parts_that_rest_on_one_place():
    """Five inliers are left of 45; beside seed 2's an outlier is kept, which they contradict."""
    support = {}
    for seed in (2, 3):
        of_graph, of_outliers = np.random.default_rng(seed).spawn(2)
        clean, truth = manhattan(200, of_graph, closures=45, noise=Noise((0.05, 0.05)))
        graph, is_outlier = spoil_closures(clean, 0.9, of_outliers, poses=truth)
        answer = solve(graph)
        assert 20.0 < answer.best.evidence < 30.0
        support[seed] = answer.support, int(np.sum(answer.kept & is_outlier))
    assert support == {2: (Support.WEAK, 1), 3: (Support.WEAK, 0)}
    assert len(answer.lone) == 2 and "rest on one place" in answer.summary()


@pytest.mark.parametrize("claim", [1 / 3, 1.0, 5.0])
def test_a_rival_of_comparable_evidence_is_named(claim):
    """A straight drive comes back to its start, and two groups disagree on which side."""
    n, each, sigma = 60, 20, np.array([0.1, 0.1, 0.02])
    rng = np.random.default_rng(0)
    sides = [[n - 1.0 - 2 * k, side, 0.0] for side in (5.0, -5.2) for k in range(each)]
    measured = np.array([[1.0, 0.0, 0.0]] * (n - 1) + sides)
    graph = PoseGraph(
        n,
        [[i, i + 1] for i in range(n - 1)] + [[k, n - 1 - k] for k in range(each)] * 2,
        measured + sigma * rng.normal(size=measured.shape),
        [np.diag((claim * sigma) ** -2)] * len(measured),
        np.arange(len(measured)) < n - 1,
    )
    answer = solve(graph)
    assert np.all(answer.noise * claim > 0.7) and np.all(answer.noise * claim < 1.7)
    assert answer.support is Support.AMBIGUOUS
    assert np.all(answer.rival[graph.is_odometry])
    groups = [set(np.flatnonzero(mask[n - 1 :])) for mask in (answer.kept, answer.rival)]
    assert groups == [set(range(each)), set(range(each, 2 * each))]
    assert "would give another map of comparable evidence" in answer.summary()


def test_an_option_that_is_gone_is_named_with_what_to_take():
    graph = PoseGraph(2, [[0, 1]], [[1, 0, 0]], [np.eye(3)], [True])
    for options, message in (
        ({"quick": True}, "argument 'quick'; .* leave it out, or take rs.estimators.gnc"),
        ({"seconds": 1.0}, "argument 'seconds'$"),
    ):
        with pytest.raises(TypeError, match=message):
            solve(graph, **options)


@pytest.mark.parametrize("digits", [None, 3])
@pytest.mark.parametrize("what", ["odometry", "closures", "all"])
@pytest.mark.parametrize("mirrored", [True, False])
def test_edges_that_stand_twice_count_once(digits, what, mirrored):
    graph, *_ = with_outliers(manhattan, 60, 3, 8, closures=40)
    repeated = {"odometry": graph.is_odometry, "closures": ~graph.is_odometry}.get(what)
    rows = np.flatnonzero(np.ones(len(graph.edges)) if repeated is None else repeated)
    copies = turned(graph, rows) if mirrored else graph
    z = copies.measurement[rows] if digits is None else copies.measurement[rows].round(digits)
    twice = with_closures(graph, copies.edges[rows], z, copies.information[rows])
    once, answer = solve(graph), solve(twice)
    np.testing.assert_array_equal(answer.kept[: len(graph.edges)], once.kept)
    np.testing.assert_array_equal(answer.kept[len(graph.edges) :], once.kept[rows])
    np.testing.assert_array_equal(answer.noise, once.noise)
    np.testing.assert_allclose(answer.poses, once.poses, atol=1e-9)
    assert f"{rows.size} edges repeat another" in answer.summary()
    spread = [covariance(one.precise, one.poses, 59, one.weights) for one in (answer, once)]
    np.testing.assert_allclose(*spread, rtol=1e-2)


@pytest.mark.parametrize("metres", [1e9, 1e27])
def test_what_no_map_can_hold_is_rejected_or_named(metres):
    graph, _ = manhattan(60, 3, closures=40)
    far = with_closures(graph, [[10, 40]], [[metres, 0.0, 0.0]], graph.information[-1])
    answer = solve(far)
    np.testing.assert_array_equal(np.flatnonzero(~answer.kept), [len(graph.edges)])
    assert answer.support is Support.UNIQUE and np.isfinite(answer.best.evidence)
    measurement = graph.measurement.copy()
    measurement[30, 0] = metres
    with pytest.raises(ValueError, match="edge 30, which joins poses 30 and 31, measures 1e"):
        solve(replace(graph, measurement=measurement))


def test_more_rejected_than_kept_is_told():
    graph, *_ = with_outliers(manhattan, 100, 0, 60, closures=40)
    assert "of 100 closures were rejected" in solve(graph).summary()
    graph, *_ = with_outliers(manhattan, 100, 0, 10, closures=40)
    assert "were rejected" not in solve(graph).summary()


def test_units_do_not_matter():
    graph, *_ = with_outliers(manhattan, 60, 2, 8, closures=20)
    millimetres = graph.measurement * [1000.0, 1000.0, 1.0]
    scale = np.array([1e-3, 1e-3, 1.0])
    claims = graph.information * np.outer(scale, scale)
    small = replace(graph, measurement=millimetres, information=claims)
    np.testing.assert_array_equal(solve(small).kept, solve(graph).kept)


def test_exact_measurements_leave_the_noise_within_what_arrays_hold():
    steps, skips = ([[k, k + size] for k in range(30 - size)] for size in (1, 2))
    measured = [[1.0, 0.0, 0.0]] * len(steps) + [[2.0, 0.0, 0.0]] * len(skips)
    is_odometry = [True] * len(steps) + [False] * len(skips)
    edges = np.array(steps + skips)
    graph = PoseGraph(30, edges, measured, [np.eye(3)] * len(edges), is_odometry)
    answer = solve(graph)
    assert np.all(answer.kept)
    assert np.all(answer.noise >= 1e-3)


def test_what_is_known_besides_is_used_and_the_answer_tells_how_certain_a_pose_is():
    graph, is_outlier, truth, _ = with_outliers(manhattan, 60, 0, 8, closures=20)
    usual = solve(graph)
    given = covariance(usual.precise, usual.poses, [20, 40], usual.weights)
    np.testing.assert_array_equal(usual.covariance([20, 40]), given)
    away = graph.group.compose([50.0, 9.0, 1.0], truth)
    assert_same_poses(graph.group, solve(graph, start=away).poses, usual.poses, atol=1e-6)
    assert solve(graph, threshold=2.0).threshold == 2.0
    right = int(np.flatnonzero(~graph.is_odometry & ~is_outlier)[0])
    wrong = int(np.flatnonzero(is_outlier)[0])
    prior = np.full(len(graph.edges), 0.5)
    prior[[right, wrong]] = 0.0, 1.0
    told = solve(graph, prior=prior)
    assert usual.kept[[right, wrong]].tolist() == [True, False]
    assert told.kept[[right, wrong]].tolist() == [False, True]
    assert told.kept.size == len(graph.edges)


@refused(
    ({"start": np.zeros((3, 3))}, "start: the shape"),
    ({"threshold": 0.0}, "threshold is 0.0; give a finite number above 0"),
    ({"prior": [0.5]}, "prior: the shape"),
    ({"prior": np.where(np.arange(37) == 30, 0.7, 0.5)}, "prior: edge 30 has 0.7; give 0, 0.5 or"),
    ({"prior": np.zeros(37)}, "edges: pose 1 is not joined"),
)
def test_what_cannot_be_known_is_refused(wrong, message):
    with pytest.raises(ValueError, match=message):
        solve(manhattan(30, 0, closures=8)[0], **wrong)
