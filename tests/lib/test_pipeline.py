"""The whole back-end finds the outliers, and records what it did at each stage."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from robust_slam.certificates.optimality import Verdict
from robust_slam.descent import gauss_newton, start
from robust_slam.estimators.thresholds import chi_square_threshold
from robust_slam.graphs import (
    Noise,
    add_random_closures,
    ate,
    circle,
    manhattan,
    precision_recall,
    sphere,
)
from robust_slam.graphs.odometry import accumulated_rotation
from robust_slam.graphs.outliers import add_grouped_closures
from robust_slam.graphs.pose_graph import residual_norms
from robust_slam.pipeline import solve

from tests.lib.worlds import with_outliers


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
    best = gauss_newton(clean, start.chordal(clean))
    assert ate(answer.poses, truth) < ate(best, truth) + 0.05


def _squares(answer, poses):
    """The cost of truncated least squares, over all edges."""
    norms = residual_norms(answer.graph, poses)
    limit = chi_square_threshold(0.99, answer.graph.group.DOF)
    return np.sum(np.where(answer.graph.is_odometry, norms, np.minimum(norms, limit)) ** 2)


@pytest.mark.parametrize("kind", ["tls", "gm"])
def test_a_closure_is_kept_if_its_residual_passes_whatever_the_stages_said(kind, seed):
    graph, *_ = with_outliers(manhattan, 100, seed, 20, closures=40)
    answer = solve(graph, kind=kind)
    passes = residual_norms(graph, answer.final.x) <= chi_square_threshold(0.99, 3)
    np.testing.assert_array_equal(answer.kept, graph.is_odometry | passes)
    np.testing.assert_array_equal(answer.weights, answer.kept)
    assert answer.result.weights.size == int(np.sum(answer.consistency.kept))
    assert _squares(answer, answer.final.x) <= _squares(answer, answer.result.x)
    before = answer.consistency.kept.copy()
    before[before] = answer.result.kept
    np.testing.assert_array_equal(answer.returned, np.flatnonzero(answer.kept & ~before))


def test_closures_that_pcm_rejects_return_where_they_fit_the_map():
    """In this town the odometry is off, and every fourth inlier contradicts the others."""
    clean, truth = manhattan(300, 0, closures=100)
    for add, count in ((add_random_closures, 100), (add_grouped_closures, 10)):
        graph, is_outlier = add(clean, count, 1, poses=truth)
        inliers = ~graph.is_odometry & ~is_outlier
        answer = solve(graph)
        assert np.sum(inliers & ~answer.consistency.kept) > 20
        assert np.sum(inliers & ~answer.kept) <= 2
        assert not np.any(answer.kept & is_outlier)
        assert answer.certificate.verdict is Verdict.CERTIFIED


def test_a_single_outlier_agrees_with_itself_and_bends_the_odometry():
    """PCM compares closures with each other, GNC with the trusted odometry."""
    graph, is_outlier, *_ = with_outliers(manhattan, 60, 9, 1, closures=0)
    answer = solve(graph)
    assert np.all(answer.consistency.kept)
    assert np.array_equal(answer.kept, ~is_outlier)


@pytest.mark.long
def test_where_odometry_loses_its_rotation_outliers_do_not_bend_the_start() -> None:
    # PCM cannot tell these outliers: the odometry between their ends is too uncertain.
    noise = Noise(odometry=(0.05, 0.15), closure=(0.05, 0.15))
    clean, truth = sphere(800, 0, around=20, noise=noise)
    graph, is_outlier = add_random_closures(clean, 160, 0, poses=truth)
    assert accumulated_rotation(graph, graph.is_odometry) > np.pi
    answer = solve(graph)
    assert np.sum(answer.consistency.kept & is_outlier) > 50
    assert not np.any(answer.kept & is_outlier)
    assert answer.rejected.size - 160 < 0.1 * np.sum(~clean.is_odometry)
    assert answer.certificate.verdict is Verdict.CERTIFIED


@pytest.mark.parametrize("factor", [20.0, 60.0])
def test_where_deviations_are_claimed_far_too_large_thresholds_follow_the_noise(factor):
    graph, is_outlier, *_ = with_outliers(manhattan, 100, 0, 1, closures=200)
    loose = replace(graph, information=graph.information / factor**2)
    answer, right = solve(loose), solve(graph)
    assert not np.any(answer.kept & is_outlier)
    assert np.all(answer.kept >= right.kept)
    assert answer.noise * factor == pytest.approx(right.noise, rel=0.2)
    assert answer.threshold < chi_square_threshold(0.99, 3) == right.threshold
    passes = residual_norms(loose, answer.final.x) <= answer.threshold
    np.testing.assert_array_equal(answer.kept, graph.is_odometry | passes)
    assert "of the deviations that the information matrices claim" in answer.summary()


def test_more_rejected_than_kept_is_told():
    graph, *_ = with_outliers(manhattan, 100, 0, 60, closures=40)
    assert "of 100 closures were rejected" in solve(graph).summary()
    graph, *_ = with_outliers(manhattan, 100, 0, 10, closures=40)
    assert "were rejected" not in solve(graph).summary()
