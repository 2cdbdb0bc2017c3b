"""The numbers of chapter 05, against the formulas written out once more."""

from __future__ import annotations

from itertools import combinations
from math import inf, sqrt
from types import SimpleNamespace

import numpy as np
import pytest
from robust_slam.estimators import graduation as library
from robust_slam.estimators import kernels
from robust_slam.estimators.graduation import gnc
from robust_slam.estimators.result import StopReason
from robust_slam.estimators.reweighting import irls
from robust_slam.estimators.thresholds import chi_square_threshold
from robust_slam.graphs.generate import manhattan
from robust_slam.graphs.metrics import ate
from robust_slam.graphs.outliers import add_random_closures
from robust_slam.problems import LocationProblem, PoseGraphProblem
from scipy.stats import chi2

from tests.book.graduation import gm_weight, listing, tls_weight
from tests.book.prose import Chapter, Numbers, rounds_to
from tests.book.samples import READINGS as FIVE
from tests.book.samples import three_poses

CHAPTER = Chapter("05-gnc")
A, B = np.array([0.0, 0.0, 0.0, 10.0]), np.array([-0.2, 0.1, 0.4, 10.0])
SEVEN = np.array([0.0, 0.0, 0.0, 0.0, 6.0, 6.0, 30.0])
THREE = three_poses(2.0, 0.0)
ROOT = sqrt(8 / 217 * 225 / 217)
AT_ONE = 4 * sqrt(2) / 5 - 1  # the weight of u = 2.5 for c = 2 and μ = 1
Row = tuple[float, np.ndarray, float]


def first_mu(u_max: float, c: float, kind: str) -> float:
    if kind == "gm":
        return 2 * u_max**2 / c**2
    return c**2 / (2 * u_max**2 - c**2)


def anneal(z: np.ndarray, kind: str, factor: float = 1.4, mu: float | None = None) -> list[Row]:
    """Return μ, weights and x of each solve, with c = 2 and unit deviations."""
    x, rows = float(z.mean()), []
    mu = first_mu(float(np.abs(z - x).max()), 2.0, kind) if mu is None else mu
    for _ in range(200):
        w = (tls_weight if kind == "tls" else gm_weight)(np.abs(z - x), 2.0, mu)
        x = float(w @ z / w.sum())
        rows.append((mu, w, x))
        if mu == 1.0 if kind == "gm" else np.all((w == 0) | (w == 1)):
            break
        mu = max(1.0, mu / factor) if kind == "gm" else mu * factor
    return rows


def backwards_on_a(mus: list[float]) -> float:
    x = 2.5
    for mu in mus:
        w = 1 / ((mu + 1) * 4 + (A - x) ** 2) ** 2
        x = float(w @ A / w.sum())
    return x


def second_minimum() -> float:
    """The minimum beside the outlier of TLS on data A at its first μ."""
    x = np.linspace(9.0, 11.0, 200_001)
    cost = library.tls_surrogate(x - A[:, None], 2.0, 8 / 217).sum(axis=0)
    return float(x[cost.argmin()])


@pytest.fixture(scope="module")
def page() -> SimpleNamespace:
    """The runs that the chapter's tables show, and its town."""
    a_tls, a_gm, b_gm, seven = (
        anneal(A, "tls"),
        anneal(A, "gm"),
        anneal(B, "gm"),
        anneal(SEVEN, "tls"),
    )
    rng = np.random.default_rng(2)
    inliers, truth = manhattan(100, rng, side=9, turn=0.25, closures=12)
    graph, is_outlier = add_random_closures(inliers, 30, rng, poses=truth)
    town, c = PoseGraphProblem(graph), chi_square_threshold(0.99, 3)
    results = irls(town, kernels.tls(c)), gnc(town, c)
    errors = [ate(result.x, truth) for result in results]
    return SimpleNamespace(**locals())


FORMULAS = {
    "2.6": lambda page: B.mean(),
    "1.5": lambda page: page.b_gm[0][2],
    "7.5 108.5": lambda page: [10 - 2.5, 2 * 7.5**2 - 4],
    "0.0369": lambda page: page.a_tls[0][0],
    "0.19551 0.03687": lambda page: [ROOT, 8 / 217],
    "0.11954 0.01527": lambda page: page.a_tls[0][1][[0, 3]],
    "0.408": lambda page: page.a_tls[0][2],
    "0.0516": lambda page: page.a_tls[1][0],
    "0.443": lambda page: 2 * sqrt(page.a_tls[1][0] / (page.a_tls[1][0] + 1)),
    "9.03": lambda page: 2 * sqrt((page.a_tls[1][0] + 1) / page.a_tls[1][0]),
    "9.59": lambda page: 10 - page.a_tls[0][2],
    "0.816": lambda page: sqrt(2 / 3),
    "9.92": lambda page: second_minimum(),
    "0.066 0.002": lambda page: tls_weight(np.array([1.0, 10.0]), 1.0, 1 / 199),
    "0.990 0.444": lambda page: gm_weight(np.array([1.0, 10.0]), 1.0, 200.0),
    "3.125": lambda page: 2.5**2 / 2,
    "0.131 0.13": lambda page: AT_ONE,
    "0.41": lambda page: tls_weight(2.0, 2.0, 1.0),
    "0.411": lambda page: AT_ONE * 2.5**2 / 2,
    "1.536": lambda page: 2 * (1 - AT_ONE) / (1 + AT_ONE),
    "1.946": lambda page: 2 * 2.5 * sqrt(2) - (4 + 2.5**2) / 2,
    "0.001": lambda page: page.a_gm[-1][1][3],
    "3.368 2.576": lambda page: np.sqrt(chi2.ppf(0.99, [3, 1])),
    "11.345": lambda page: chi2.ppf(0.99, 3),
    "0.311 0.147": lambda page: page.errors,
    "0.9495 0.9454": lambda page: listing(20),
    "0.0184": lambda page: backwards_on_a([mu for mu, _, _ in page.a_gm]),
    "0.0035": lambda page: page.seven[0][0],
    "5.6": lambda page: min(x for _, _, x in anneal(SEVEN, "tls", 2.0)),
    "4.2 4.21": lambda page: min(x for _, _, x in page.seven),
    "0.0162": lambda page: page.seven[0][1][0],
    "3.33 6.67": lambda page: [10 / 3, 20 / 3],
    "2.83": lambda page: 2 * sqrt(2),
    "0.0870": lambda page: first_mu(5.0, 2.0, "tls"),
    "12.5": lambda page: first_mu(5.0, 2.0, "gm"),
    "7.071 0.566": lambda page: [5 * sqrt(2), 4 / (5 * sqrt(2))],
    "56.25 112.5 118.75": lambda page: [7.5**2, 2 * 7.5**2, 2 * 7.5**2 + 2.5**2],
    "0.8975": lambda page: page.a_gm[0][1][0],
    "1.417": lambda page: page.a_gm[0][2],
    "0.190": lambda page: 4 / 21,
    "100.1": lambda page: gnc(LocationProblem(B + 100), 2.0).x,
}


class TestNumbers(Numbers):
    chapter, formulas = CHAPTER, FORMULAS
    # Data that the chapter hands out, factors and μ that it chooses, equation numbers, and the
    # values along the axes that an alternative text mentions.
    given = "-0.2 0.1 0.4 1.4 0.03 0.3 0.99 0.5 3.2 1.2 1.1 2.5 3.24 3.25 3.4 0.06 2.385 0.05"


@pytest.mark.parametrize("data", [A, B, SEVEN], ids=["A", "B", "seven"])
@pytest.mark.parametrize(
    ("kind", "factor", "mu"),
    [("tls", 1.4, None), ("tls", 1.2, None), ("gm", 1.4, None), ("gm", 1.5, None)],
)
def test_the_tables_are_those_of_the_formulas(data, kind, factor, mu) -> None:
    history = gnc(LocationProblem(data), 2.0, kind, factor=factor, mu0=mu).history[1:]
    rows = anneal(data, kind, factor, mu)
    assert len(history) == len(rows)
    for step, (mu_used, weights, x) in zip(history, rows, strict=True):
        assert step.mu == pytest.approx(mu_used, rel=1e-12)
        np.testing.assert_allclose(step.weights, weights, atol=1e-9)
        assert step.x == pytest.approx(x, abs=1e-9)


@pytest.mark.parametrize(("data", "first"), [(A, 0.0), (B, 0.2823912747)], ids=["A", "B"])
def test_the_lessons_start_works_where_three_agree(data: np.ndarray, first: float) -> None:
    rows = anneal(data, "tls", 1.5, 1.0)
    assert [x for _, _, x in rows] == pytest.approx([first, data[:3].mean()], abs=1e-9)


def test_the_exact_values_of_data_a(page) -> None:
    mu, weights, x = page.a_tls[0]
    assert mu == pytest.approx(8 / 217, rel=1e-14)
    assert weights[0] == pytest.approx((24 * sqrt(2) - 8) / 217, rel=1e-12)
    assert weights[3] == pytest.approx((8 * sqrt(2) - 8) / 217, rel=1e-12)
    assert x == pytest.approx(20 / 23 - 15 * sqrt(2) / 46, rel=1e-12)
    assert round(weights[0] / weights[3]) == 8


@pytest.mark.parametrize(("factor", "end"), [(1.1, 0), (1.2, 0), (1.35, 0), (1.4, 6), (2.0, 6)])
def test_the_factor_decides_the_end_of_the_seven_readings(factor: float, end: float) -> None:
    result = gnc(LocationProblem(SEVEN), 2.0, factor=factor)
    assert result.stop is StopReason.BINARY_WEIGHTS
    assert result.x == pytest.approx(end, abs=1e-9)
    assert result.cost == pytest.approx({0: 6, 6: 10}[round(end)], abs=1e-9)


def test_six_is_the_least_tls_cost_of_the_seven_readings() -> None:
    def cost(kept: tuple[int, ...]) -> float:
        chosen = SEVEN[list(kept)]
        return float(np.sum((chosen - chosen.mean()) ** 2) / 2 + 2 * (7 - len(kept)))

    sets = [kept for size in range(1, 8) for kept in combinations(range(7), size)]
    assert min(map(cost, sets)) == pytest.approx(6)


def test_starts_of_other_programs_agree_on_a_and_b_and_not_on_the_seven() -> None:
    ends = {}
    for name, data in {"A": A, "B": B, "seven": SEVEN}.items():
        worst = float(np.abs(data - data.mean()).max())
        starts = ((None, 1.4), (1 / (5 * worst**2 / 4 - 1), 2.0), (1e-4, 1.4))
        ends[name] = [anneal(data, "tls", factor, mu)[-1][2] for mu, factor in starts]
    np.testing.assert_allclose(ends["A"], 0.0, atol=1e-9)
    np.testing.assert_allclose(ends["B"], 0.1, atol=1e-9)
    np.testing.assert_allclose(ends["seven"], [6, 6, 0], atol=1e-9)


def test_the_listing_ends_in_least_squares_from_anywhere() -> None:
    for start in (0.0, 0.99, 5.0):
        assert rounds_to(listing(20, start)[0], "0.9495")
        assert listing(80, start) == pytest.approx((0.99, 1.0), abs=1e-9)


def test_outliers_that_agree_win_and_scattered_ones_do_not() -> None:
    agree = gnc(LocationProblem([0, 0, 10, 10, 10]), 2.0)
    assert (agree.x, agree.cost) == (10, 4)
    scattered = gnc(LocationProblem([0, 0, 0, 20, -35, 50, -60]), 2.0)
    assert scattered.x == 0
    assert scattered.weights.tolist() == [1, 1, 1, 0, 0, 0, 0]


def test_two_against_one_is_lost_at_mu_one_and_one_against_one_always() -> None:
    for data, mu0 in (([0, 0, 10], 1.0), ([0, 10], None), ([0, 10], 1.0)):
        assert gnc(LocationProblem(data), 2.0, mu0=mu0).stop is StopReason.ALL_REJECTED
    assert gnc(LocationProblem([0, 0, 10]), 2.0).x == 0


def test_the_first_solve_forgets_the_start_unless_it_is_skipped() -> None:
    sharp = LocationProblem(FIVE, 0.3)
    assert irls(sharp, kernels.tls(2.5758), x0=4.9).x == 5
    assert gnc(sharp, 2.5758).x == pytest.approx(-0.0125, abs=1e-12)
    assert gnc(LocationProblem(FIVE), 1.0, x0=5.0, mu0=1.0).x == 5


def test_how_many_solves_each_family_takes(page) -> None:
    assert [len(run) for run in (page.a_tls, page.a_gm, page.b_gm)] == [2, 11, 11]
    assert page.seven[0][0] == pytest.approx(1 / 287)


def test_nothing_to_reject_where_the_formula_is_not_positive() -> None:
    assert library.start_mu(sqrt(2) - 1e-9, 2.0) == inf
    assert gnc(LocationProblem([0.0, 1.0]), 2.0).stop is StopReason.NOTHING_TO_REJECT


def test_the_town_keeps_what_the_text_says(page) -> None:
    kept = [~page.graph.is_odometry & (result.weights > 0.5) for result in page.results]
    assert [np.sum(one & ~page.is_outlier) for one in kept] == [4, 12]
    assert [np.sum(one & page.is_outlier) for one in kept] == [0, 0]
    assert round(100 * 30 / 42) == 71


def test_strides_spare_solves_and_end_in_the_same_weights(page) -> None:
    counts = []
    for problem, c in ((page.town, page.c), (LocationProblem(SEVEN), 2.0)):
        runs = [gnc(problem, c, adaptive=adaptive) for adaptive in (True, False)]
        np.testing.assert_array_equal(runs[0].weights, runs[1].weights)
        counts += [len(run.history) - 1 for run in runs]
    assert counts == [14, 18, 8, 14]
    assert "14 solves in place of 18, the seven readings 8 in place of 14" in CHAPTER.text


def best_cost(z: np.ndarray, c: float) -> float:
    """The least TLS cost, by trying every run of neighbours as the kept ones."""
    z = np.sort(z)
    runs = combinations(range(z.size + 1), 2)
    kept = (z[i:j] for i, j in runs)
    return min(float(((k - k.mean()) ** 2).sum() + c**2 * (z.size - k.size)) / 2 for k in kept)


@pytest.mark.long
def test_how_often_each_is_near_the_truth_and_finds_the_best_answer() -> None:
    rng, near, found = np.random.default_rng(5), {}, {}
    for wrong in (2, 6, 10, 14, 16):
        near[wrong], found[wrong] = np.zeros(4, dtype=int), np.zeros(4, dtype=int)
        misled = 0
        for _ in range(100):
            data = np.append(rng.standard_normal(20 - wrong), rng.uniform(-50, 50, wrong))
            problem, tls = LocationProblem(data), kernels.tls(2.5758)
            starts = irls(problem, tls), irls(problem, tls, float(np.median(data)))
            runs = (*starts, irls(problem, kernels.cauchy(2.385)), gnc(problem, 2.5758))
            close = np.array([abs(run.x) < 1 for run in runs])
            best = np.array([run.cost < best_cost(data, 2.5758) + 1e-6 for run in runs])
            near[wrong] += close
            found[wrong] += best
            misled += best[3] and not close[3]
    assert near[10].tolist() == [65, 100, 100, 100]
    assert all(min(near[wrong][1:]) >= 99 for wrong in (2, 6, 10))
    assert near[16].tolist() == [39, 71, 77, 79]
    assert [found[wrong][3] for wrong in (2, 6, 10, 16)] == [100, 100, 100, 89]
    assert found[16][1] == 69
    assert misled >= 10
    assert "in 65 of 100 problems" in CHAPTER.text and "in all 100" in CHAPTER.text
    assert "in 79 problems, Cauchy in 77 and TLS from the median in 71" in CHAPTER.text
    assert "in 89 of 100 with $80\\,\\%$, against 69 from the median" in CHAPTER.text


def test_the_chain_is_two_long_again() -> None:
    lengths = [step.x[2] for step in gnc(THREE, 3.0).history]
    assert lengths[:2] == pytest.approx([18 / 17, 1.937885], abs=1e-6)
    assert lengths[-1] == pytest.approx(2.0, abs=1e-12)
