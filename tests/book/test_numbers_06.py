"""The numbers of chapter 06, against the library or a closed form."""

from __future__ import annotations

from functools import cache
from itertools import combinations
from math import log, sqrt

import numpy as np
import pytest
from robust_slam.consistency.cliques import max_clique
from robust_slam.consistency.pairwise import pairwise_distances, pcm
from robust_slam.estimators.graduation import gnc
from robust_slam.estimators.mixtures import NullHypothesis, max_mixture
from robust_slam.estimators.result import StopReason
from robust_slam.estimators.switches import (
    dcs,
    dcs_switch,
    joint_switchable,
    switch,
    switchable,
)
from robust_slam.estimators.thresholds import chi_square_threshold
from robust_slam.graphs.generate import manhattan
from robust_slam.graphs.metrics import ate
from robust_slam.graphs.odometry import dead_reckoning
from robust_slam.graphs.outliers import add_aliased_closures, add_random_closures
from robust_slam.graphs.pose_graph import PoseGraph, select
from robust_slam.pipeline import solve
from robust_slam.problems import LocationProblem, PoseGraphProblem
from scipy.optimize import brentq
from scipy.stats import chi2 as chi_square

from tests.book.prose import Chapter, Numbers, rounds_to
from tests.book.samples import three_poses

CHAPTER = Chapter("06-switches-and-consistency")
GAMMA, LINE_GAMMA = chi_square_threshold(0.99, 3), chi_square_threshold(0.99, 1)


class Page:
    """The towns of the chapter and the maps that each method makes of them."""

    def __init__(self) -> None:
        rng = np.random.default_rng(3)
        self.inliers, self.truth = manhattan(48, rng, side=4, turn=0.35, closures=8)
        self.town = add_random_closures(self.inliers, 4, rng, poses=self.truth)
        self.problem = PoseGraphProblem(self.town[0])
        self.unfolded = switchable(three_poses(2.0, 0.0), 1.0)
        self.distances = line(A, B, C, P, Q)
        self.together = cache(lambda lam: joint_switchable(self.problem, lam))
        self.in_turn = cache(lambda lam: switchable(self.problem, lam, max_iterations=500))
        self.misled = cache(self._misled)
        self.left_by_pcm = select(self.misled(10)[0], pcm(self.misled(10)[0]).kept)

    def switches(self, step) -> np.ndarray:
        return np.sqrt(step.weights[~self.town[0].is_odometry])

    def error(self, x: np.ndarray) -> float:
        return ate(x, self.truth)

    def dcs_error(self, phi: float) -> float:
        return self.error(dcs(self.problem, phi, max_iterations=500).x)

    def _misled(self, size: int):
        rng = np.random.default_rng(1)
        return add_aliased_closures(self.inliers, 1, rng, size=size, poses=self.truth, apart=1.5)

    def kept(self, kind: str, gamma: float) -> tuple[int, int]:
        """How many inlier closures and how many outliers PCM keeps."""
        graph, wrong = self.town if kind == "lone" else self.misled({"six": 6, "ten": 10}[kind])
        chosen = pcm(graph, gamma).kept & ~graph.is_odometry
        return int(np.sum(chosen & ~wrong)), int(np.sum(chosen & wrong))


@pytest.fixture(scope="module")
def page() -> Page:
    return Page()


def line(*closures: tuple[int, int, float]) -> np.ndarray:
    """Distances between closures (i, j, length) of six poses a metre apart, all sigmas 0.1."""
    edges = [(k, k + 1) for k in range(5)] + [(i, j) for i, j, _ in closures]
    measurement = np.zeros((len(edges), 3))
    measurement[:, 0] = [1.0] * 5 + [length for _, _, length in closures]
    information = np.tile(np.diag([100.0, 100.0, 1e6]), (len(edges), 1, 1))
    graph = PoseGraph(6, np.array(edges), measurement, information, np.arange(len(edges)) < 5)
    return pairwise_distances(graph)


A, B, C, P, Q = (0, 4, 4.1), (1, 5, 3.9), (1, 4, 2.9), (0, 5, 2.0), (1, 4, 0.0)


def gap() -> float:
    """How far the three ranges miss their best point, which by symmetry is the middle."""
    places = np.array([[0.0, 0.0], [4.0, 0.0], [2.0, 2.0 * sqrt(3.0)]])
    return float(np.linalg.norm(places.mean(axis=0))) - 2.1


FORMULAS = {
    "2.25": lambda page: 9 * 0.25,
    "0.25": lambda page: 1 / (1 + 3),
    "2.5": lambda page: 1 / sqrt(0.02 + 14 * 0.01),
    "0.09": lambda page: 9 * 0.01,
    "0.81": lambda page: page.error(page.problem.initial()),
    "0.91": lambda page: switch(0.1, 1.0),
    "0.01": lambda page: switch(9.0, 1.0) ** 2,
    "0.0028 0.0022": lambda page: np.sqrt(page.unfolded.history[1].weights[2:]),
    "0.11": lambda page: page.error(page.together(10.0).x),
    "0.233": lambda page: page.switches(page.together(10.0).history[1])[:8].min(),
    "0.869": lambda page: page.switches(page.together(10.0))[:8].min(),
    "11.34": lambda page: GAMMA**2,
    "0.909": lambda page: 10 / 11,
    "0.30 0.65": lambda page: [page.dcs_error(phi) for phi in (1.0, 300.0)],
    "4.50": lambda page: log(90),
    "4.5": lambda page: NullHypothesis(0.9, 10.0, 1).offset,
    "3.02 4.29 5.69": lambda page: [NullHypothesis(0.9, 10.0, d).switch_norm for d in (1, 3, 6)],
    "3.73": lambda page: NullHypothesis(0.99, 10.0, 1).switch_norm,
    "2.11": lambda page: sqrt(2 * log(9) / 0.99),
    "0.0332": lambda page: max_mixture(LocationProblem([0.0, 0.0, 0.0, 10.0]), 0.9, 10.0, 1).x,
    "0.2": lambda page: 4.1 + 1 - 3.9 - 1,
    "0.03 0.02": lambda page: [edges * 0.01 for edges in (3, 2)],
    "3.1": lambda page: 4.1 + 1 - 2,
    "17.9 1.15": lambda page: page.distances[0, [3, 2]],
    "14.5": lambda page: page.distances[2, 3],
    "3.37": lambda page: GAMMA,
    "7.07": lambda page: 1 / sqrt(0.02),
    "2.58 2.576": lambda page: LINE_GAMMA,
    "0.282": lambda page: brentq(lambda s: 9 * s**2 - (1 - s), 0, 1),
    "0.32": lambda page: page.error(solve(page.misled(10)[0]).result.x),
    "1.09": lambda page: page.error(PoseGraphProblem(page.left_by_pcm).initial()),
    "0.209 52.6": lambda page: [gap(), 3 * (gap() / 0.05) ** 2],
    "14.8 11.9": lambda page: [2 * page.together(1.0).cost, 2 * page.in_turn(1.0).cost],
    "0.0099 3.96": lambda page: [4 / 404, 4 * 400 / 404],
    "0.0909": lambda page: switch(100.0, 10.0),
    "0.00826": lambda page: switch(100.0, 10.0) ** 2,
    "9.09": lambda page: 1000 / 110,
    "0.182": lambda page: dcs_switch(100.0, 10.0),
    "0.0331": lambda page: dcs_switch(100.0, 10.0) ** 2,
    "3.6": lambda page: 2 * 1.8,
    "2.546": lambda page: 3.6 / sqrt(2),
    "12.96": lambda page: 4 * 1.8**2,
    "11.345": lambda page: chi_square.ppf(0.99, 3),
}


class TestNumbers(Numbers):
    chapter, formulas = CHAPTER, FORMULAS
    # Data and numbers of equations; last a bound and a share of pairs, both tested below.
    given = "0.1 0.5 0.9 0.05 0.99 2.1 4.1 3.9 2.9 1.8 -1.8 -2.9 3.8 3.25 0.7 1.0"


def test_the_hand_table_of_the_switch() -> None:
    for s, total in ((1.0, 9.0), (0.5, 2.5), (0.1, 0.9), (0.0, 1.0)):
        assert 9 * s**2 + (1 - s) ** 2 == pytest.approx(total)


def test_in_turn_is_lower_at_one_price_and_together_at_another(page: Page) -> None:
    assert page.in_turn(1.0).cost < page.together(1.0).cost - 0.1
    assert (
        page.error(page.in_turn(1.0).x) > page.error(page.together(1.0).x) + 0.1
    )  # the worse map of the two
    assert page.together(3.0).cost < page.in_turn(3.0).cost - 0.1
    assert page.together(10.0).cost == pytest.approx(page.in_turn(10.0).cost, abs=1e-6)
    inliers_alone = PoseGraphProblem(page.inliers).initial()
    assert rounds_to(page.error(inliers_alone), "0.11")
    assert rounds_to(page.dcs_error(10.0), "0.11")


def test_a_low_price_loses_six_inlier_closures(page: Page) -> None:
    s = page.switches(page.together(1.0))
    assert int(np.sum(s[:8] < 0.1)) == 6
    assert s[8:].max() < 0.001


def test_the_first_step_at_the_right_price_turns_the_outliers_off(page: Page) -> None:
    s = page.switches(page.together(10.0).history[1])
    assert s[8:].max() < 0.001
    assert np.sum(s[:8] < 0.7) == 4


def test_a_high_price_is_worse_than_least_squares(page: Page) -> None:
    assert page.switches(page.together(10000.0)).min() > 0.7
    assert page.error(page.together(10000.0).x) > page.error(page.problem.initial())


@pytest.mark.parametrize(
    ("kind", "gamma", "inliers", "outliers"),
    [
        ("lone", 3.37, 8, 0),
        ("lone", 1.0, 2, 0),
        ("lone", 25.0, 8, 1),
        ("six", 3.37, 8, 0),
        ("six", 1.0, 0, 3),
        ("ten", 3.37, 0, 10),
        ("ten", 2.0, 6, 0),
        ("ten", 25.0, 8, 10),
    ],
)
def test_what_the_threshold_keeps(
    page: Page, kind: str, gamma: float, inliers: int, outliers: int
) -> None:
    assert page.kept(kind, gamma) == (inliers, outliers)


def test_what_each_method_makes_of_ten_outliers_that_agree(page: Page) -> None:
    graph, _ = page.misled(10)
    problem = PoseGraphProblem(graph)
    answer = solve(graph)
    assert np.sum(answer.result.kept) == np.sum(graph.is_odometry)
    assert ate(answer.result.x, dead_reckoning(graph)) < 1e-6
    assert np.array_equal(answer.kept, ~page.misled(10)[1])
    assert rounds_to(page.error(answer.poses), "0.11")
    fewer, wrong = page.misled(9)
    kept = solve(fewer).kept & ~fewer.is_odometry
    assert (np.sum(kept & wrong), np.sum(kept & ~wrong)) == (8, 0)
    assert solve(fewer).returned.size == 0
    left_over = gnc(PoseGraphProblem(page.left_by_pcm), GAMMA)
    assert left_over.stop is StopReason.NOTHING_TO_REJECT
    for right in (gnc(problem, GAMMA), switchable(problem, 10.0)):
        assert rounds_to(page.error(right.x), "0.11")
    assert page.error(switchable(problem, 100.0, max_iterations=500).x) > 0.8


def test_the_closures_on_the_line(page: Page) -> None:
    assert page.distances[0, 1] == pytest.approx(1.0)
    assert page.distances[3, 4] == pytest.approx(0.0, abs=1e-9)
    assert max_clique(line(A, B, P, Q) <= LINE_GAMMA).members.size == 2
    assert max_clique(np.less_equal(page.distances, LINE_GAMMA)).members.tolist() == [0, 1, 2]


def test_one_town_of_inliers_in_nine_loses_a_closure() -> None:
    lost, beyond = [], []
    for seed in range(100):
        rng = np.random.default_rng(1000 + seed)
        graph, _ = manhattan(48, rng, side=4, turn=0.35, closures=8)
        far = pairwise_distances(graph)
        lost.append(8 - len(max_clique(far <= GAMMA).members))
        beyond.append(np.mean(far[np.triu_indices(8, 1)] > GAMMA))
    assert np.count_nonzero(lost) == 11
    assert max(lost) == 3
    assert rounds_to(100 * float(np.mean(beyond)), "1.0")


def test_four_readings_agree_in_pairs_and_not_together() -> None:
    z = np.array([-1.8, -1.8, 1.8, 1.8])
    assert all(abs(a - b) / sqrt(2) < LINE_GAMMA for a, b in combinations(z, 2))
    assert np.sum((z - z.mean()) ** 2) > chi_square.ppf(0.99, 3)


def test_without_normalisers_the_answer_is_least_squares() -> None:
    z = np.array([0.0, 0.0, 0.0, 10.0])
    for knee in (sqrt(2 * log(9) / 0.99), sqrt(2 * log(9)), 0.0):
        assert np.all(np.abs(z - z.mean()) > knee)


def test_a_broad_mode_may_win_everywhere() -> None:
    assert NullHypothesis(0.05, 10.0, 1).switch_norm == 0.0


def test_exercise_2_is_in_balance() -> None:
    doubted = LocationProblem([0.0, 0.0, 3.0], [2.0, 2.0, 1.0], [True, True, False])
    result = switchable(doubted, 4.0, max_iterations=1000)
    assert result.x == pytest.approx(1.0, abs=1e-6)
    assert doubted.initial() == pytest.approx(2.0)
