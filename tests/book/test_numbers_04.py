"""The numbers of chapter 04, against the library or a closed form."""

from __future__ import annotations

from dataclasses import replace
from math import pi, sqrt
from types import SimpleNamespace

import numpy as np
import pytest
from robust_slam.estimators import kernels
from robust_slam.estimators.graduation import gnc
from robust_slam.estimators.result import StopReason
from robust_slam.estimators.reweighting import irls
from robust_slam.estimators.thresholds import chi_square_threshold
from robust_slam.graphs import generate, metrics, outliers
from robust_slam.graphs.odometry import dead_reckoning, spanning_tree
from robust_slam.graphs.pose_graph import PoseGraph
from robust_slam.problems import LocationProblem, PoseGraphProblem
from scipy.optimize import brentq, minimize_scalar

from tests.book.prose import Chapter, Numbers
from tests.book.samples import READINGS

CHAPTER = Chapter("04-non-convexity")
CROWD = np.append(np.zeros(20), 10.0)
PROBLEM = LocationProblem(CROWD)
PAIR = LocationProblem([0.0, 10.0])
CLOSE = LocationProblem([0.0, 1.2])
FOUR_OUTLIERS = LocationProblem(np.repeat([0.0, 10.0], [5, 4]))


def from_eight(kernel: kernels.Kernel) -> float:
    return irls(PROBLEM, kernel, x0=8.0).x


def of_readings(x0: float):
    return irls(LocationProblem(READINGS, 0.3), kernels.cauchy(1.0), x0=x0)


def pull(x: float, c: float) -> float:
    """The slope of Cauchy's cost of the crowd."""
    return float(kernels.cauchy(c).psi(x - CROWD).sum())


def least_pull(c: float) -> float:
    """The lowest slope between 9 and 10: where it is positive there is no minimum near 10."""
    return float(minimize_scalar(pull, bounds=(9.0, 10.0), args=(c,)).fun)


def tls_cost_of_the_pair(x: float, c: float) -> float:
    return float(kernels.tls(c).rho(np.array([x, x - 10.0])).sum())


@pytest.fixture(scope="module")
def page() -> SimpleNamespace:
    """The town of the chapter and the ends of all its descents."""
    rng = np.random.default_rng(4)
    town, truth = generate.manhattan(60, rng, side=7, turn=0.25, closures=14)
    graph, is_outlier = outliers.add_random_closures(town, 12, rng, poses=truth)
    c = chi_square_threshold(0.99, 3)
    closures = np.flatnonzero(~graph.is_odometry)
    problem, tls, odometry = PoseGraphProblem(graph), kernels.tls(c), dead_reckoning(graph)
    alike = np.ones(len(graph.edges), dtype=bool)
    tree = spanning_tree(replace(graph, is_odometry=alike))
    from_ls, from_odometry, from_tree, from_truth = (
        irls(problem, tls, start) for start in (None, odometry, tree, truth)
    )
    annealed = gnc(problem, c)
    restarts = []
    for k in closures:
        weights = graph.is_odometry.astype(float)
        weights[k] = 1.0
        restarts.append(irls(problem, tls, problem.solve(weights, odometry)))
    best = min(restarts, key=lambda result: result.cost)

    def kept(result) -> tuple[int, int]:
        """How many inlier closures and how many outliers a result keeps."""
        chosen, wrong = result.weights[closures] > 0.5, is_outlier[closures]
        return int(chosen[~wrong].sum()), int(chosen[wrong].sum())

    return SimpleNamespace(**locals())


FORMULAS = {
    "0.476": lambda page: from_eight(kernels.squared()),
    "9.524": lambda page: 10.0 - 10.0 / 21.0,
    "24.95": lambda page: tls_cost_of_the_pair(4.99, 5.0),
    "0.417 0.4": lambda page: 5.0 - sqrt(25.0 - 2.0**2),
    "9.583 9.6": lambda page: 5.0 + sqrt(25.0 - 2.0**2),
    "7.071": lambda page: sqrt(50.0),
    "0.00495": lambda page: from_eight(kernels.cauchy(1.0)),
    "0.2441": lambda page: brentq(least_pull, 0.2, 0.3),
    "4.92": lambda page: of_readings(4.9).x,
    "3.75": lambda page: of_readings(7.0).history[1].x,
    "3.368": lambda page: page.c,
    "147.5": lambda page: page.from_ls.cost,
    "91.9": lambda page: page.from_truth.cost,
    "0.33 2.63 3.34": lambda page: [
        metrics.ate(poses, page.truth)
        for poses in (page.odometry, page.problem.initial(), page.tree)
    ],
    "125.3": lambda page: page.best.cost,
    "91.4": lambda page: page.annealed.cost,
    "3.948 3.9": lambda page: 2 * pi**2 / 5,
    "0.625": lambda page: 180 / (4 * 72),
    "0.6": lambda page: irls(CLOSE, kernels.tls(1.0)).x,
    "6.2": lambda page: 5 * pi**2 / 8,
    "0.197": lambda page: 2 * pi**2 / 100,
    "3.6": lambda page: 360 / 100,
    "0.36": lambda page: irls(CLOSE, kernels.tls(1.0)).cost,
    "9.457": lambda page: irls(FOUR_OUTLIERS, kernels.cauchy(2.0), 8.0).x,
}


class TestNumbers(Numbers):
    chapter, formulas = CHAPTER, FORMULAS
    # Data that the chapter hands out, starts, thresholds to try, sections of other texts.
    given = "0.1 -0.2 0.15 -0.1 0.3 2.5 1.2 0.2 4.99"


@pytest.mark.parametrize(
    ("c", "end"),
    [(1.99, 8.0), (2.0, 10.0), (7.99, 10.0), (8.0, 0.0), (9.523, 0.0), (9.524, 10 / 21)],
)
def test_the_ends_from_eight(c: float, end: float) -> None:
    assert from_eight(kernels.tls(c)) == pytest.approx(end, abs=1e-12)


def test_on_the_plateau_no_reading_is_kept() -> None:
    result = irls(PROBLEM, kernels.tls(1.0), x0=8.0)
    assert result.stop is StopReason.ALL_REJECTED
    assert result.cost == 21 / 2


@pytest.mark.parametrize(
    ("c", "ends"),
    [(2.0, {0, 10}), (4.99, {0, 10}), (5.0, {0, 5, 10}), (9.99, {0, 5, 10}), (10.0, {5})],
)
def test_the_minima_of_the_pair_with_tls(c: float, ends: set[int]) -> None:
    found = [irls(PAIR, kernels.tls(c), x0) for x0 in (0.0, 5.0, 10.0)]
    assert {round(r.x) for r in found if r.stop is StopReason.CONVERGED} == ends


def test_one_outlier_against_n_falls_at_some_threshold_from_n_is_5_on() -> None:
    for n in range(1, 9):
        problem = LocationProblem(np.append(np.zeros(n), 10.0))
        ends = [irls(problem, kernels.tls(c), 8.0).x for c in np.linspace(0.5, 10.0, 1901)]
        assert (min(ends) == 0.0) == (n > 4)


@pytest.mark.parametrize("c", [0.2, 0.3, 0.5, 1.0, 2.0])
def test_cauchy_has_a_second_minimum_only_for_small_c(c: float) -> None:
    assert (least_pull(c) < 0.0) == (c < 0.2441)


def test_five_readings_in_two_groups() -> None:
    problem, tls = LocationProblem([0, 0, 10, 10, 10]), kernels.tls(2.0)
    costs = {x0: irls(problem, tls, x0).cost for x0 in (1.0, 5.0, 6.0, 9.0)}
    assert costs == {1.0: 6.0, 5.0: 10.0, 6.0: 10.0, 9.0: 4.0}
    assert irls(problem, tls).x == 6.0


@pytest.mark.parametrize(("c", "is_minimum"), [(4.9, False), (5.0, False), (5.01, True)])
def test_the_middle_of_the_pair_is_a_strict_minimum_beyond_5_only(
    c: float, is_minimum: bool
) -> None:
    beside = min(tls_cost_of_the_pair(x, c) for x in (4.999, 5.001))
    assert (beside > tls_cost_of_the_pair(5.0, c)) == is_minimum
    assert "| $5 < c < 7.071$ |" in CHAPTER.text


def test_no_reading_leads_to_the_mean_of_a_close_pair() -> None:
    ends = {x0: irls(CLOSE, kernels.tls(1.0), x0) for x0 in (0.0, 1.2, 0.2, 1.0, 0.19, 1.01)}
    assert [round(r.x, 9) for r in ends.values()] == [0.0, 1.2, 0.6, 0.6, 0.0, 1.2]
    assert ends[0.0].cost == ends[1.2].cost == 0.5


def test_the_town_has_a_minimum_that_no_restart_finds(page) -> None:
    for start in (page.from_ls, page.from_odometry, page.from_tree):
        assert page.kept(start) == (0, 0)
    assert page.from_odometry.cost == pytest.approx(26 * page.c**2 / 2, abs=1e-9)
    assert page.kept(page.from_truth) == (14, 0)
    assert page.kept(page.best) == (5, 0)
    assert page.kept(page.annealed) == (13, 0)
    other = gnc(page.problem, page.c, x0=page.odometry)
    assert page.kept(other) == (13, 0)
    assert other.cost == pytest.approx(page.annealed.cost, abs=1e-3)
    above = [r for r in page.restarts if r.cost > page.from_ls.cost + 1e-6]
    assert [page.kept(r) for r in above] == [(0, 1)] * 5
    still = [r for r in page.restarts if abs(r.cost - page.from_ls.cost) < 1e-6]
    assert len(still) == 7
    assert metrics.ate(page.annealed.x, page.truth) < metrics.ate(page.from_ls.x, page.truth) / 2


def ring(n: int) -> PoseGraphProblem:
    edges = np.column_stack([np.arange(n), (np.arange(n) + 1) % n])
    information = np.tile(np.eye(3), (n, 1, 1))
    return PoseGraphProblem(
        PoseGraph(n, edges, np.zeros((n, 3)), information, np.arange(n) < n - 1)
    )


@pytest.mark.parametrize("n", [5, 100])
def test_a_twisted_ring_stays_twisted(n: int) -> None:
    problem, twist = ring(n), np.zeros((n, 3))
    twist[:, 2] = 2 * pi * np.arange(n) / n
    bent = twist.copy()
    bent[:, 2] += 0.1 * np.random.default_rng(1).standard_normal(n)
    misfit = problem.residual_norms(problem.solve(np.ones(n), bent))
    np.testing.assert_allclose(misfit, 2 * pi / n, atol=1e-9)
    assert 0.5 * np.sum(misfit**2) == pytest.approx(2 * pi**2 / n, abs=1e-9)


def test_more_than_a_third_of_random_headings_end_twisted() -> None:
    problem, rng = ring(5), np.random.default_rng(0)
    twisted = 0
    for _ in range(300):
        poses = np.column_stack([np.zeros((5, 2)), rng.uniform(-pi, pi, 5)])
        twisted += np.sum(problem.residual_norms(problem.solve(np.ones(5), poses)) ** 2) > 1.0
    assert 100 < twisted < 150


def test_four_outliers_that_agree_give_tls_the_wrong_start() -> None:
    end = irls(FOUR_OUTLIERS, kernels.tls(2.0), 9.456533)
    assert (end.x, end.cost) == (10.0, 10.0)
    assert irls(FOUR_OUTLIERS, kernels.tls(2.0), 0.0).cost == 8.0
