"""The whole back-end sees through lies, and says what it did at each stage."""

from __future__ import annotations

import numpy as np
import pytest
from robust_slam.certificates.optimality import Verdict
from robust_slam.descent import start
from robust_slam.descent.undamped import gauss_newton
from robust_slam.graphs.generate import circle, manhattan, sphere
from robust_slam.graphs.metrics import ate, precision_recall
from robust_slam.graphs.outliers import add_random_closures
from robust_slam.pipeline import solve

WORLDS = {
    "circle": lambda rng: circle(60, rng, laps=2, closures=20),
    "manhattan": lambda rng: manhattan(100, rng, closures=40),
    "sphere": lambda rng: sphere(80, rng),
}


@pytest.mark.parametrize("world", WORLDS)
def test_the_lies_are_found_and_the_map_is_the_one_without_them(world, seed):
    rng = np.random.default_rng(seed)
    graph, truth = WORLDS[world](rng)
    closures = int(np.sum(~graph.is_odometry))
    spoiled, is_lie = add_random_closures(graph, closures // 3, rng, poses=truth)
    answer = solve(spoiled)
    doubted = ~spoiled.is_odometry
    precision, recall = precision_recall(answer.kept[doubted], ~is_lie[doubted])
    assert precision == 1.0
    assert recall > 0.9
    assert answer.certificate.verdict is Verdict.CERTIFIED
    best = gauss_newton(graph, start.chordal(graph))
    assert ate(answer.poses, truth) < ate(best, truth) + 0.05


def test_each_stage_keeps_no_more_than_the_one_before():
    rng = np.random.default_rng(7)
    graph, truth = manhattan(100, rng, closures=40)
    spoiled, _ = add_random_closures(graph, 20, rng, poses=truth)
    answer = solve(spoiled)
    assert np.all(answer.kept <= answer.consistency.kept)
    assert np.all(answer.kept[spoiled.is_odometry])
    assert answer.result.weights.size == int(np.sum(answer.consistency.kept))


def test_without_lies_most_closures_are_kept():
    """Pairs share one odometry, so a bad draw of it costs many: the share varies by seed."""
    shares = []
    for seed in range(6):
        graph, truth = manhattan(100, np.random.default_rng(seed), closures=40)
        answer = solve(graph)
        shares.append(np.mean(answer.kept[~graph.is_odometry]))
        assert answer.certificate.verdict is Verdict.CERTIFIED
        assert ate(answer.poses, truth) < 1.0
    assert np.median(shares) > 0.9


def test_a_single_lie_agrees_with_itself_and_bends_the_odometry():
    """PCM compares closures with each other, GNC with the trusted odometry."""
    rng = np.random.default_rng(9)
    graph, truth = manhattan(60, rng, closures=0)
    spoiled, is_lie = add_random_closures(graph, 1, rng, poses=truth)
    answer = solve(spoiled)
    assert np.all(answer.consistency.kept)
    assert np.array_equal(answer.kept, ~is_lie)


def test_a_probability_outside_0_to_1_is_refused():
    graph, _ = circle(10, np.random.default_rng(1))
    with pytest.raises(ValueError, match="probability is 1"):
        solve(graph, 1.0)
