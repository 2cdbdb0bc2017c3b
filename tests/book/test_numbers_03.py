"""The numbers of chapter 03, against the library or a closed form."""

from __future__ import annotations

from math import log, sqrt
from types import SimpleNamespace

import numpy as np
import pytest
from robust_slam.estimators import kernels
from robust_slam.estimators.result import StopReason
from robust_slam.estimators.reweighting import irls
from robust_slam.graphs.metrics import ate
from robust_slam.problems import LinearProblem, LocationProblem, PoseGraphProblem
from robust_slam_course.plots.opening import town
from scipy.optimize import brentq

from tests.book.efficiency import efficiency
from tests.book.prose import Chapter, Numbers, rounds_to
from tests.book.samples import READINGS as Z
from tests.book.samples import three_poses

CHAPTER = Chapter("03-irls")
SIGMA = 0.3
PROBLEM, CAUCHY, HUBER = LocationProblem(Z, SIGMA), kernels.cauchy(1.0), kernels.huber(1.345)
PAIR = LocationProblem([0.0, 10.0])
P = np.array([0, 1, 2, 3, 4, 5, 20.0])
LINE = LinearProblem(
    np.column_stack([np.ones(7), P]), np.array([0.1, 0.3, 1.15, 1.4, 2.05, 2.5, 0.0]), 0.2
)
GOOD_LINE = np.array([0.0, 0.5])


def gradient(x: float) -> float:
    return float(-CAUCHY.psi((Z - x) / SIGMA).sum() / SIGMA)


def next_from(x: float) -> float:
    weights = CAUCHY.weight((x - Z) / SIGMA)
    return float(weights @ Z / weights.sum())


def rate_at(result) -> float:
    """The rate of convergence: one minus the sum of slopes over that of weights."""
    u = (result.x - Z) / SIGMA
    slope = (CAUCHY.psi(u + 1e-6) - CAUCHY.psi(u - 1e-6)) / 2e-6
    return 1.0 - float(slope.sum() / result.weights.sum())


@pytest.fixture(scope="module")
def page() -> SimpleNamespace:
    """The runs of IRLS that the chapter shows."""
    result = irls(PROBLEM, CAUCHY)
    steps, first, rate = result.history, result.history[1].weights, rate_at(result)
    captured = irls(PROBLEM, CAUCHY, x0=4.9)
    beyond = irls(PROBLEM, CAUCHY, x0=7.0)
    inliers_alone = irls(LocationProblem(Z[:4], SIGMA), CAUCHY).x
    top = float(brentq(gradient, 3.5, 4.5))
    # Beyond the outlier a start is caught until its first step ends on the top between the minima.
    far_edge = float(brentq(lambda x: next_from(x) - top, 6.0, 7.0))
    tls = irls(PROBLEM, kernels.tls(3.0))
    unfolded = irls(three_poses(2.0, 0.0), CAUCHY)
    from_ls, from_good = (irls(LINE, kernels.cauchy(2.385), x0) for x0 in (None, GOOD_LINE))
    huber_line = irls(LINE, HUBER, max_iterations=1000)
    scene = town()
    inliers = ~scene.graph.is_odometry & ~scene.is_outlier
    robust_town = irls(
        PoseGraphProblem(scene.graph), kernels.cauchy(2.666), tol=1e-6, max_iterations=300
    )
    lopsided = irls(LocationProblem([0.0, 0.0, 0.0, 10.0]), CAUCHY).history
    return SimpleNamespace(**locals())


FORMULAS = {
    "4.95 0.99": lambda page: [Z.sum(), page.steps[0].x],
    "0.89 1.19 0.84 1.09 4.01": lambda page: np.abs(0.99 - Z),
    "2.97 3.97 2.80 3.63 13.4": lambda page: PROBLEM.residual_norms(0.99),
    "0.1020 0.0598 0.1131 0.0704 0.0056": lambda page: page.first,
    "0.060 0.113": lambda page: page.first[1:3],
    "0.0102 -0.0120 0.0170 -0.0070 0.0278": lambda page: page.first * Z,
    "0.3509 0.0360": lambda page: [page.first.sum(), page.first @ Z],
    "0.1026": lambda page: page.steps[1].x,
    "2.8": lambda page: PROBLEM.residual_norms(0.99)[2],
    "0.887": lambda page: page.steps[0].x - page.steps[1].x,
    "0.33": lambda page: 0.028 / 0.084,
    "0.028": lambda page: page.first[4] * Z[4],
    "0.084": lambda page: 0.078 + 0.0056,
    "0.0100": lambda page: page.steps[3].x,
    "-0.000241": lambda page: page.result.x,
    "0.00359": lambda page: page.result.weights[4],
    "5.000241": lambda page: 5 - page.result.x,
    "16.7": lambda page: (5 - page.result.x) / SIGMA,
    "0.001": lambda page: 1 / (1 + sqrt(999) ** 2),
    "31.6 0.158": lambda page: [sqrt(999), 5 / sqrt(999)],
    "0.338": lambda page: page.rate,
    "3.22": lambda page: page.result.cost,
    "0.69": lambda page: page.result.weights[:4].min(),
    "0.0625": lambda page: irls(PROBLEM, kernels.huber(1.0)).x,
    "-0.0125 0.125": lambda page: [page.tls.x, page.tls.history[1].x],
    "-0.00846 0.00822": lambda page: [page.inliers_alone, page.result.x - page.inliers_alone],
    "0.0273": lambda page: SIGMA**2 / page.result.weights.sum(),
    "0.165": lambda page: SIGMA / sqrt(page.result.weights.sum()),
    "0.134 0.150": lambda page: [SIGMA / sqrt(5), SIGMA / 2],
    "76.2": lambda page: 100 * efficiency(CAUCHY),
    "0.762": lambda page: efficiency(CAUCHY),
    "0.172": lambda page: SIGMA / 2 / sqrt(efficiency(CAUCHY)),
    "1.9989": lambda page: page.unfolded.x[2],
    "0.000625": lambda page: page.unfolded.weights[3],
    "0.17 0.15": lambda page: [
        ate(poses, page.scene.truth) for poses in (page.scene.robust, page.robust_town.x)
    ],
    "0.10": lambda page: page.scene.weights[page.inliers].min(),
    "2.666": lambda page: brentq(lambda c: efficiency(kernels.cauchy(c), 3) - 0.95, 1.0, 5.0),
    "0.81": lambda page: page.robust_town.weights[page.inliers].min(),
    "0.0002": lambda page: page.robust_town.weights[page.scene.is_outlier][0],
    "4.92": lambda page: page.captured.x,
    "11.2": lambda page: page.captured.cost,
    "0.937": lambda page: page.captured.weights[4],
    "0.004": lambda page: page.captured.weights[:4].max(),
    "4.07 4.0716": lambda page: page.top,
    "6.5330": lambda page: page.far_edge,
    "3.75": lambda page: page.beyond.history[1].x,
    "0.0395": lambda page: irls(LocationProblem(Z, 1.0), CAUCHY, x0=0.0).x,
    "0.969 0.003": lambda page: [page.from_ls.weights[6], page.from_good.weights[6]],
    "22.64 18.17": lambda page: [page.from_ls.cost, page.from_good.cost],
    "1.363": lambda page: page.huber_line.x[0],
    "0.0616": lambda page: -page.huber_line.x[1],
    "2.5 0.405028": lambda page: [step.x for step in page.lopsided[:2]],
    "7.25 57.25": lambda page: 1 / page.lopsided[1].weights[[0, 3]],
    "3.148148": lambda page: irls(PAIR, CAUCHY, x0=4.0).history[1].x,
}


class TestNumbers(Numbers):
    chapter, formulas = CHAPTER, FORMULAS
    # Data, starts, section numbers of other texts, what the lesson prints; last a weight in an
    # explanation and an upper bound, tested below.
    given = "0.1 -0.2 0.15 -0.1 5.0 0.3 4.9 4.0 4.15 3.12 1.345 0.01 0.13"


def end_from(start: float) -> int:
    return round(irls(PROBLEM, CAUCHY, x0=start, max_iterations=1000).x)


def test_the_outlier_is_11_to_20_times_lighter_than_the_inliers(page) -> None:
    ratios = page.first[:4] / page.first[4]
    assert (round(ratios.min()), round(ratios.max())) == (11, 20)


def test_the_first_step_repairs_nine_tenths(page) -> None:
    start, one = (step.x - page.result.x for step in page.steps[:2])
    assert rounds_to(1 - one / start, "0.9")


def test_three_digits_take_a_little_over_six_steps(page) -> None:
    assert 6.0 < log(1e-3) / log(page.rate) < 6.5


def test_the_distances_shrink_by_the_predicted_rate(page) -> None:
    moves = np.diff([step.x for step in page.steps])
    assert moves[12] / moves[11] == pytest.approx(page.rate, abs=1e-5)


@pytest.mark.parametrize("run", ["result", "captured", "from_ls", "from_good", "unfolded"])
def test_the_cost_never_rises(page, run: str) -> None:
    assert np.all(np.diff([step.cost for step in getattr(page, run).history]) <= 1e-12)


@pytest.mark.parametrize(
    ("start", "end"),
    [
        *[(-50.0, 0), (4.0, 0), (4.0716, 0), (4.0717, 5), (4.15, 5), (4.9, 5)],
        *[(6.533, 5), (6.5331, 0), (7.0, 0), (100.0, 0)],
    ],
)
def test_only_starts_near_the_outlier_are_caught(start: float, end: int) -> None:
    assert end_from(start) == end


def test_the_top_is_the_watershed(page) -> None:
    assert end_from(page.top + 1e-3) == 5


@pytest.mark.parametrize("start", [-5.0, 0.0, 0.99, 4.9, 9.0])
def test_with_a_wide_sigma_there_is_one_minimum(start: float) -> None:
    result = irls(LocationProblem(Z, 1.0), CAUCHY, x0=start, max_iterations=1000)
    assert result.x == pytest.approx(0.0394518615, abs=1e-9)


def test_half_of_the_inlier_closures_fall_to_a_third(page) -> None:
    assert np.sum(page.scene.weights[page.inliers] <= 1 / 3) == 6
    assert "half of the twelve inlier closures fall to a third" in CHAPTER.text


def test_tls_rejects_all_and_says_so(page) -> None:
    result = irls(PROBLEM, kernels.tls(1.0))
    assert result.stop is StopReason.ALL_REJECTED
    assert result.x == page.steps[0].x
    assert not result.weights.any()


def test_cauchy_does_not_label_and_tls_does(page) -> None:
    assert np.all((page.result.weights > 0.0) & (page.result.weights < 1.0))
    assert page.tls.weights.tolist() == [1, 1, 1, 1, 0]


def test_two_inliers_of_the_line_fall_below_the_printed_bound(page) -> None:
    assert int(np.sum(page.from_ls.weights[:6] < 0.13)) == 2
    assert np.all(page.from_good.weights[:6] > 0.7)


def test_huber_has_one_answer_on_the_line_and_it_is_wrong(page) -> None:
    from_good = irls(LINE, HUBER, GOOD_LINE, max_iterations=1000)
    np.testing.assert_allclose(page.huber_line.x, from_good.x, atol=1e-6)
    assert page.huber_line.x[1] < 0.0
    assert page.huber_line.weights[6] == 1.0
    assert int(np.sum(page.huber_line.weights[:6] < 0.3)) == 4


def test_unfolding_takes_five_steps(page) -> None:
    assert rounds_to(float(page.unfolded.history[0].x[2]), f"{18 / 17:.9f}")
    assert rounds_to(float(page.unfolded.history[5].x[2]), "1.9989")


def test_the_exercises_by_hand(page) -> None:
    zeros_and_ten = LocationProblem([0.0, 0.0, 0.0, 10.0])
    assert page.lopsided[1].x == pytest.approx(145 / 358, abs=1e-12)
    assert irls(zeros_and_ten, kernels.huber(1.0)).x == pytest.approx(1 / 3, abs=1e-9)
    assert irls(PAIR, CAUCHY, x0=5.0).x == 5.0
    assert irls(PAIR, CAUCHY, x0=5.0).cost > irls(PAIR, CAUCHY, x0=4.0).cost
