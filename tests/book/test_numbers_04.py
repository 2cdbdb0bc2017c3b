"""Every decimal number that chapter 04 prints, against the library or a closed form."""

from __future__ import annotations

from math import pi, sqrt

import numpy as np
import pytest
from robust_slam.estimators import kernels
from robust_slam.estimators.graduation import gnc
from robust_slam.estimators.result import Result, StopReason
from robust_slam.estimators.reweighting import irls
from robust_slam.estimators.thresholds import chi_square_threshold
from robust_slam.graphs import generate, metrics, outliers
from robust_slam.graphs.odometry import dead_reckoning
from robust_slam.graphs.pose_graph import PoseGraph
from robust_slam.problems import LocationProblem, PoseGraphProblem
from scipy.optimize import brentq, minimize_scalar

from tests.book.prose import chapter_text, decimals, rounds_to, unchecked

TEXT = chapter_text("04-non-convexity.ipynb")

CROWD = np.append(np.zeros(20), 10.0)
PROBLEM = LocationProblem(CROWD)
PAIR = LocationProblem([0.0, 10.0])
FIVE = LocationProblem([0.1, -0.2, 0.15, -0.1, 5.0], 0.3)
CLOSE = LocationProblem([0.0, 1.2])

# Data that the chapter hands out, starts, thresholds to try, sections of other texts.
GIVEN = {"0.1", "-0.2", "0.15", "-0.1", "0.3", "2.5", "1.2", "0.2", "4.99"}


def from_eight(kernel: kernels.Kernel) -> float:
    return irls(PROBLEM, kernel, x0=8.0).x


def pull(x: float, c: float) -> float:
    """The slope of Cauchy's cost of the crowd."""
    return float(kernels.cauchy(c).psi(x - CROWD).sum())


def least_pull(c: float) -> float:
    """The lowest slope between 9 and 10: where it is positive there is no minimum near 10."""
    return float(minimize_scalar(pull, bounds=(9.0, 10.0), args=(c,)).fun)


def tls_cost_of_the_pair(x: float, c: float) -> float:
    return float(kernels.tls(c).rho(np.array([x, x - 10.0])).sum())


def pair_minimum(c: float, side: int) -> float:
    return 5.0 + side * sqrt(25.0 - c**2)


class Town:
    """The map of the chapter and the ends of all its descents."""

    def __init__(self) -> None:
        rng = np.random.default_rng(4)
        town, self.truth = generate.manhattan(60, rng, side=7, turn=0.25, closures=14)
        graph, self.is_lie = outliers.add_random_closures(town, 12, rng, poses=self.truth)
        self.c = chi_square_threshold(0.99, 3)
        self.closures = np.flatnonzero(~graph.is_odometry)
        self.problem, tls = PoseGraphProblem(graph), kernels.tls(self.c)
        odometry = dead_reckoning(graph)
        self.from_ls = irls(self.problem, tls)
        self.from_odometry = irls(self.problem, tls, odometry)
        self.from_truth = irls(self.problem, tls, self.truth)
        self.gnc = gnc(self.problem, self.c)
        self.restarts = []
        for k in self.closures:
            weights = graph.is_odometry.astype(float)
            weights[k] = 1.0
            self.restarts.append(irls(self.problem, tls, self.problem.solve(weights, odometry)))
        self.best = min(self.restarts, key=lambda result: result.cost)

    def kept(self, result: Result[np.ndarray]) -> tuple[int, int]:
        """How many honest closures and how many lies a result keeps."""
        kept, lie = result.weights[self.closures] > 0.5, self.is_lie[self.closures]
        return int(kept[~lie].sum()), int(kept[lie].sum())


TOWN = Town()
JUMP = irls(FIVE, kernels.cauchy(1.0), x0=7.0)
FOUR_LIES = LocationProblem(np.repeat([0.0, 10.0], [5, 4]))

CLAIMS = {
    "0.476190": from_eight(kernels.squared()),
    "9.523810": 10.0 - 10.0 / 21.0,
    "24.95": tls_cost_of_the_pair(4.99, 5.0),
    "0.4174243": pair_minimum(2.0, -1),
    "9.5825757": pair_minimum(2.0, 1),
    "0.4": pair_minimum(2.0, -1),
    "9.6": pair_minimum(2.0, 1),
    "7.071068": sqrt(50.0),
    "0.004953": from_eight(kernels.cauchy(1.0)),
    "0.2441": brentq(least_pull, 0.2, 0.3),
    "4.922391": irls(FIVE, kernels.cauchy(1.0), x0=4.9).x,
    "4.92": irls(FIVE, kernels.cauchy(1.0), x0=4.9).x,
    "3.7507": JUMP.history[1].x,
    "3.75": JUMP.history[1].x,
    "3.3682": TOWN.c,
    "147.48": TOWN.from_ls.cost,
    "91.90": TOWN.from_truth.cost,
    "125.26": TOWN.best.cost,
    "91.38": TOWN.gnc.cost,
    "3.947842": 2 * pi**2 / 5,
    "3.9": 2 * pi**2 / 5,
    "0.625": 180 / (4 * 72),
    "0.6": irls(CLOSE, kernels.tls(1.0)).x,
    "6.2": 5 * pi**2 / 8,
    "0.197392": 2 * pi**2 / 100,
    "3.6": 360 / 100,
    "0.36": irls(CLOSE, kernels.tls(1.0)).cost,
    "9.456533": irls(FOUR_LIES, kernels.cauchy(2.0), 8.0).x,
}


@pytest.mark.parametrize("printed", CLAIMS)
def test_a_printed_number_is_the_computed_one(printed: str) -> None:
    assert rounds_to(float(CLAIMS[printed]), printed), CLAIMS[printed]


def test_every_printed_number_is_checked() -> None:
    assert not unchecked(TEXT, CLAIMS, GIVEN)


def test_every_checked_number_is_still_printed() -> None:
    assert not (set(CLAIMS) | GIVEN) - decimals(TEXT)


@pytest.mark.parametrize(
    ("c", "end"),
    [(1.99, 8.0), (2.0, 10.0), (7.99, 10.0), (8.0, 0.0), (9.523, 0.0), (9.524, 10 / 21)],
)
def test_the_ends_from_eight(c: float, end: float) -> None:
    assert from_eight(kernels.tls(c)) == pytest.approx(end, abs=1e-12)


def test_on_the_plateau_nobody_is_kept() -> None:
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


def test_a_lie_alone_against_n_falls_at_some_threshold_from_n_is_5_on() -> None:
    for n in range(1, 9):
        problem = LocationProblem(np.append(np.zeros(n), 10.0))
        ends = [irls(problem, kernels.tls(c), 8.0).x for c in np.linspace(0.5, 10.0, 1901)]
        assert (min(ends) == 0.0) == (n > 4)


def test_cauchy_has_a_second_minimum_only_for_small_c() -> None:
    for c in (0.3, 0.5, 1.0, 2.0):
        assert least_pull(c) > 0.0
    assert least_pull(0.2) < 0.0


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
    assert "| $5 < c < 7.071068$ |" in TEXT


def test_no_reading_leads_to_the_mean_of_a_close_pair() -> None:
    ends = {x0: irls(CLOSE, kernels.tls(1.0), x0) for x0 in (0.0, 1.2, 0.2, 1.0, 0.19, 1.01)}
    assert [round(r.x, 9) for r in ends.values()] == [0.0, 1.2, 0.6, 0.6, 0.0, 1.2]
    assert ends[0.0].cost == ends[1.2].cost == 0.5


def test_the_town_has_a_valley_that_no_restart_finds() -> None:
    assert TOWN.kept(TOWN.from_ls) == TOWN.kept(TOWN.from_odometry) == (0, 0)
    assert TOWN.from_odometry.cost == pytest.approx(26 * TOWN.c**2 / 2, abs=1e-9)
    assert TOWN.kept(TOWN.from_truth) == (14, 0)
    assert TOWN.kept(TOWN.best) == (5, 0)
    assert TOWN.kept(TOWN.gnc) == (13, 0)
    above = [r for r in TOWN.restarts if r.cost > TOWN.from_ls.cost + 1e-6]
    assert [TOWN.kept(r) for r in above] == [(0, 1)] * 5
    still = [r for r in TOWN.restarts if abs(r.cost - TOWN.from_ls.cost) < 1e-6]
    assert len(still) == 7
    assert metrics.ate(TOWN.gnc.x, TOWN.truth) < metrics.ate(TOWN.from_ls.x, TOWN.truth) / 2


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


def test_four_lies_that_agree_hand_tls_the_wrong_start() -> None:
    end = irls(FOUR_LIES, kernels.tls(2.0), CLAIMS["9.456533"])
    assert (end.x, end.cost) == (10.0, 10.0)
    assert irls(FOUR_LIES, kernels.tls(2.0), 0.0).cost == 8.0
