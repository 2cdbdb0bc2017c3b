"""The robust map of a factor graph: what it rejects, how it chooses, what it tells."""

import re
from dataclasses import replace

import numpy as np
import pytest
from robust_slam.errors import Underdetermined
from robust_slam.estimators import StopReason
from robust_slam.factors import FactorGraph, FactorGraphProblem, park, solve_factors
from robust_slam.factors.equations import FactorEquations
from robust_slam.factors.evidence import evidence
from robust_slam.graphs import dead_reckoning, manhattan
from robust_slam.graphs.pose_graph import with_closures
from robust_slam.groups import se2

from ..worlds import refused
from .made import error, flight

pytestmark = pytest.mark.long


@pytest.mark.parametrize(
    "made", [park(150, 0), park(150, 1), flight(0)], ids=["park", "another park", "flight"]
)
def test_the_map_is_a_minimum_nearly_as_good_as_where_the_outliers_are_known(made):
    graph, truth, is_wrong = made
    answer = solve_factors(graph)
    problem = FactorGraphProblem(graph)
    known = problem.solve(np.where(is_wrong, 0.0, 1.0), truth)
    least = problem.solve(np.ones(is_wrong.size), truth)
    assert error(graph, answer.x, truth) < 1.3 * error(graph, known, truth)
    assert error(graph, answer.x, truth) < 0.3 * error(graph, least, truth)
    assert np.sum(answer.kept & is_wrong) <= 0.05 * is_wrong.sum()
    assert np.sum(~answer.kept & ~is_wrong) <= 0.05 * np.sum(~is_wrong)
    _, slope = FactorEquations(graph).system(answer.x, answer.kept.astype(float))
    assert np.abs(slope[1:]).max() < 1e-3


def test_of_several_ends_it_takes_the_one_of_most_evidence():
    graph, truth, is_wrong = park(150, 8, wrong_trees=0.3, wrong_fixes=0.5)
    answer = solve_factors(graph)
    assert answer.evidence["DCS"] < max(answer.evidence.values()) - 100.0
    known = FactorGraphProblem(graph).solve(np.where(is_wrong, 0.0, 1.0), truth)
    assert error(graph, answer.x, truth) < 1.1 * error(graph, known, truth)


def test_what_is_trusted_is_kept_and_a_pose_graph_is_solved_as_well():
    graph, _, is_wrong = park(40, 0)
    trusted = graph.is_trusted.copy()
    trusted[np.flatnonzero(is_wrong)[:3]] = True
    assert np.all(solve_factors(graph, trusted=trusted).kept[trusted])
    assert np.all(solve_factors(manhattan(60, 0, closures=15)[0]).kept)


def test_a_higher_probability_rejects_fewer_inliers():
    graph, _, is_wrong = park(100, 4)
    few, many = (solve_factors(graph, p).kept for p in (0.8, 0.999))
    assert np.sum(~many & ~is_wrong) < np.sum(~few & ~is_wrong)
    share = np.mean(few[~is_wrong & ~graph.is_trusted])
    assert 0.7 < share < 0.9


def test_what_is_kept_has_to_join_all_poses():
    way, _ = manhattan(20, 0, closures=0)
    cut = replace(way, is_odometry=np.arange(19) != 9)
    other = way.measurement[9] + [20.0, 0.0, 0.0]
    torn = with_closures(cut, [[9, 10]], other[None], way.information[9])
    between = se2.compose(dead_reckoning(way)[9], way.measurement[9] + [10.0, 0.0, 0.0])
    moved = se2.compose(between, se2.between(dead_reckoning(way)[10], dead_reckoning(way)[10:]))
    halfway = np.concatenate([dead_reckoning(way)[:10], moved])
    with pytest.raises(Underdetermined, match="no factor of positive weight joins pose 10 to"):
        solve_factors(FactorGraph(relative=torn), x0=halfway)


def test_a_right_factor_adds_evidence_and_a_wrong_one_takes_some_and_one_sighting_alone_is_none():
    graph, truth, is_wrong = park(100, 0)
    problem, equations = FactorGraphProblem(graph), FactorEquations(graph)

    def of(kept):
        x = problem.solve(kept.astype(float), truth)
        return evidence(equations, x, kept)

    right = of(~is_wrong)
    for k in np.flatnonzero(is_wrong)[::9]:
        assert of(~is_wrong | (np.arange(is_wrong.size) == k)) < right
    at = np.flatnonzero(~is_wrong & ~graph.is_trusted)[::60]
    often = [k for k in at if np.sum((graph.ends[:, 1] == graph.ends[k, 1]) & ~is_wrong) > 2]
    assert len(often) > 3
    for k in often:
        assert of(~is_wrong & (np.arange(is_wrong.size) != k)) < right
    of_one = graph.ends[:, 1] == graph.n + 3
    without = ~is_wrong & ~of_one
    with_one = without | (np.arange(is_wrong.size) == np.flatnonzero(of_one & ~is_wrong)[0])
    assert of(without) == pytest.approx(of(with_one), abs=1e-6)


def test_the_answer_tells_what_it_kept_and_what_is_lost():
    graph, _, _ = park(100, 1)
    answer = solve_factors(graph)
    assert repr(answer).startswith("<FactorAnswer: 100 poses, 40 landmarks, ")
    text = answer.summary()
    kept = answer.kept[graph.slices["points"]]
    first = ", ".join(map(str, np.flatnonzero(~kept)[:5]))
    assert f"points     {kept.sum()} of {kept.size} kept; rejected: {first}, …\n" in text
    assert "not certified" in text and "lost" not in text
    assert answer.poses.shape == (100, 3) and answer.landmarks.shape == (graph.landmarks, 2)
    assert np.array_equal(answer.rejected, np.flatnonzero(~answer.kept))
    less = answer.kept & ~np.any(graph.ends == 100, axis=1)
    assert replace(answer, kept=less).lost.tolist() == [0]
    assert "lost       1 landmark without" in replace(answer, kept=less).summary()


@pytest.mark.parametrize(
    ("claimed", "words"), [(100.0, "positions of .* rejected, half "), (1, "")]
)
def test_positions_that_claim_too_much_are_doubted(claimed, words):
    graph, _, _ = park(100, 1)
    information = claimed**2 * np.asarray(graph.positions.information)
    fixes = replace(graph.positions, information=information)
    answer = solve_factors(replace(graph, positions=fixes))
    doubts = " ".join(answer.doubts)
    assert re.search(words or "^$", doubts) and doubts in answer.summary()


def test_without_time_there_is_a_map_that_says_so():
    graph, truth, _ = park(100, 1)
    answer = solve_factors(graph, max_seconds=0.0)
    assert answer.stop is StopReason.TIME_LIMIT and len(answer.evidence) == 1
    assert "the limit ended the search" in answer.summary()
    assert answer.x.shape == truth.shape


@refused(
    ({"trees": 3}, "trees is 3 and every 5; give at least 4 and 1"),
    ({"every": 0}, "every 0"),
    ({"wrong_trees": 1.5}, "wrong_trees and wrong_fixes are shares"),
)
def test_a_park_that_cannot_be_is_refused(wrong, message):
    with pytest.raises(ValueError, match=message):
        park(50, 0, **wrong)


def test_a_park_has_the_noise_and_the_outliers_that_it_claims():
    graph, truth, is_wrong = park(2000, 0, trees=300, wrong_trees=0.25, wrong_fixes=0.5)
    u = FactorEquations(graph).norms(truth)
    for name, d in (("relative", 3), ("positions", 2), ("points", 2)):
        at = graph.slices[name]
        assert np.mean(u[at][~is_wrong[at]] ** 2) == pytest.approx(d, rel=0.15)
    assert is_wrong[graph.slices["points"]].mean() == pytest.approx(0.25, abs=1e-3)
    assert is_wrong[graph.slices["positions"]].mean() == pytest.approx(0.5, abs=1e-3)
    assert np.all(u[graph.slices["positions"]][is_wrong[graph.slices["positions"]]] > 5.0)
