"""The numbers of chapter 02, against the library or a closed form."""

from __future__ import annotations

from collections.abc import Callable
from math import e, log, sqrt
from types import SimpleNamespace

import numpy as np
import pytest
from robust_slam.estimators import kernels
from robust_slam.estimators.reweighting import irls
from robust_slam.estimators.thresholds import chi_square_threshold
from robust_slam.problems import LocationProblem
from scipy.optimize import brentq, minimize_scalar
from scipy.stats import chi2, median_abs_deviation, norm

from tests.book.efficiency import efficiency
from tests.book.prose import Chapter, Numbers

CHAPTER = Chapter("02-four-costs")
FOUR = [kernels.KERNELS[name](1.0) for name in ("squared", "huber", "cauchy", "tls")]
SQUARED, HUBER, CAUCHY, TLS = FOUR
GEMAN_MCCLURE = kernels.geman_mcclure(1.0)


def curvature(kernel: kernels.Kernel, u: float) -> float:
    return float(kernel.psi(u + 1e-6) - kernel.psi(u - 1e-6)) / 2e-6


def gamma(d: int) -> float:
    return chi_square_threshold(0.99, d)


def rejected(c: float, d: int) -> float:
    """Percent of inliers of d numbers whose norm is beyond c."""
    return 100.0 * float(chi2.sf(c**2, d))


def constants(make: Callable[[float], kernels.Kernel]) -> list[float]:
    """The thresholds with an efficiency of 95 %, for 1, 3 and 6 numbers."""

    def constant(d: int) -> float:
        return float(brentq(lambda c: efficiency(make(c), d) - 0.95, 0.3, 9.0))

    return [constant(d) for d in (1, 3, 6)]


def biweight(c: float) -> SimpleNamespace:
    """Tukey's biweight, as far as ``efficiency`` needs it."""
    return SimpleNamespace(scale=c, psi=lambda u: u * max(1 - (u / c) ** 2, 0.0) ** 2)


DOOR = np.array([2.03, 1.97, 2.04, 1.98, 3.00])


def door(sigma: float) -> float:
    start = float(np.median(DOOR))
    return irls(LocationProblem(DOOR, sigma), kernels.tls(gamma(1)), x0=start).x


FORMULAS = {
    "9.5": lambda page: HUBER.rho(10.0),
    "0.347 2.308": lambda page: CAUCHY.rho([1.0, 10.0]),
    "6.658": lambda page: CAUCHY.rho(10.0) / CAUCHY.rho(1.0),
    "0.0099": lambda page: CAUCHY.weight(10.0),
    "0.325": lambda page: GEMAN_MCCLURE.psi(1 / sqrt(3)),
    "0.577": lambda page: GEMAN_MCCLURE.convex_until,
    "0.134 -0.074": lambda page: [curvature(CAUCHY, u) for u in (0.8, 1.2)],
    "12.5 4.5 1.629 0.5": lambda page: [kernel.rho(5.0) for kernel in FOUR],
    "0.2 0.0385": lambda page: [kernel.weight(5.0) for kernel in (HUBER, CAUCHY)],
    "1.311 2.528": lambda page: [sqrt(e - 1), sqrt(e**2 - 1)],
    "2.576 3.368 4.100": lambda page: [gamma(d) for d in (1, 3, 6)],
    "11.345 16.81": lambda page: [gamma(d) ** 2 for d in (3, 6)],
    "8.406": lambda page: gamma(6) ** 2 / 2,
    "31.7 80.1": lambda page: [rejected(1.0, d) for d in (1, 3)],
    "35.6": lambda page: rejected(gamma(1), 6),
    "19.8": lambda page: rejected(gamma(1) / 2, 1),
    "1.345 1.628 1.869": lambda page: constants(kernels.huber),
    "2.385 2.666 2.862": lambda page: constants(kernels.cauchy),
    "3.787 4.337 4.846": lambda page: constants(kernels.geman_mcclure),
    "91.6 95.5": lambda page: [100 * efficiency(kernels.tls(gamma(d)), d) for d in (1, 3)],
    "90.3 76.2": lambda page: [100 * efficiency(kernel) for kernel in (HUBER, CAUCHY)],
    "4.685": lambda page: brentq(lambda c: efficiency(biweight(c)) - 0.95, 2.0, 9.0),
    "0.446": lambda page: np.std(DOOR, ddof=1),
    "0.6745 1.483": lambda page: [norm.ppf(0.75), 1 / norm.ppf(0.75)],
    "0.0741": lambda page: median_abs_deviation(DOOR, scale="normal"),
    "2.005 2.204": lambda page: [door(sigma) for sigma in (0.05, 1.0)],
    "3.130": lambda page: kernels.huber(1.345).rho(3.0),
    "0.448": lambda page: kernels.huber(1.345).weight(3.0),
}


class TestNumbers(Numbers):
    chapter, formulas = CHAPTER, FORMULAS
    # Data that the chapter hands out, section numbers of other texts, and p = 0.99.
    given = "0.1 0.8 1.2 0.99 3.12"


def test_the_table_of_ratios_and_weights() -> None:
    ratios = [float(k.rho(10.0) / k.rho(1.0)) for k in FOUR]
    weights = [float(k.weight(10.0)) for k in FOUR]
    np.testing.assert_allclose(ratios, [100, 19, log(101) / log(2), 1], rtol=1e-12)
    np.testing.assert_allclose(weights, [1, 0.1, 1 / 101, 0], rtol=1e-12)
    bold = ["**100**", "**19**", "**6.658**", "**1**", "**0.1**", "**0.0099**", "**0**"]
    assert not [number for number in bold if number not in CHAPTER.text]


@pytest.mark.parametrize("d", [1, 3, 6])
def test_the_efficiency_of_tls_is_the_kept_share_of_the_squared_norm(d: int) -> None:
    kept = chi2.expect(lambda square: square, args=(d,), ub=gamma(d) ** 2)
    assert kept / d == pytest.approx(efficiency(kernels.tls(gamma(d)), d), abs=1e-6)


def test_the_pull_is_largest_where_the_text_says() -> None:
    u = np.linspace(0, 50, 500_001)
    tops = {k.name: float(k.psi(u).max()) for k in (HUBER, CAUCHY, GEMAN_MCCLURE, TLS)}
    assert tops["huber"] == 1.0 == float(HUBER.psi(1e9))
    assert tops["cauchy"] == pytest.approx(0.5, abs=1e-9) == float(CAUCHY.psi(1.0))
    assert tops["geman-mcclure"] == pytest.approx(3 * sqrt(3) / 16, abs=1e-8)
    assert tops["tls"] == 1.0


def test_cauchy_is_still_convex_at_the_printed_place() -> None:
    assert curvature(CAUCHY, 1 / sqrt(2)) == pytest.approx(2 / 9, abs=1e-6)
    assert curvature(CAUCHY, sqrt(3)) == pytest.approx(-1 / 8, abs=1e-6)
    assert CAUCHY.convex_until == 1.0


def test_the_crossings_are_where_the_costs_are_equal() -> None:
    with_half, without_half = sqrt(e - 1), sqrt(e**2 - 1)
    assert float(CAUCHY.rho(with_half)) == pytest.approx(float(TLS.rho(with_half)))
    assert float(CAUCHY.rho(without_half)) == pytest.approx(2 * float(TLS.rho(without_half)))


def test_in_millimetres_one_reading_is_left() -> None:
    z = 1000 * DOOR
    result = irls(LocationProblem(z), kernels.tls(gamma(1)), x0=float(np.median(z)))
    assert result.weights.tolist() == [1, 0, 0, 0, 0]


def test_cauchy_by_hand() -> None:
    assert CAUCHY.weight(1.0) == 1 / 2
    assert GEMAN_MCCLURE.weight(1.0) == 1 / 4
    np.testing.assert_allclose(CAUCHY.psi([3.0, 7.0]), [3 / 10, 7 / 50])
    np.testing.assert_allclose(CAUCHY.weight([3.0, 7.0]), [1 / 10, 1 / 50])


PENALTIES = {
    "huber": ("\\tfrac{k^2}{2}(\\tfrac1w - 1)", lambda w: 1 / w - 1),
    "cauchy": ("\\tfrac{c^2}{2}(w - 1 - \\ln w)", lambda w: w - 1 - log(w)),
    "geman-mcclure": ("\\tfrac{c^2}{2}(\\sqrt w - 1)^2", lambda w: (sqrt(w) - 1) ** 2),
    "tls": ("\\tfrac{c^2}{2}(1 - w)", lambda w: 1 - w),
}


@pytest.mark.parametrize("u", [0.5, 1.5, 2.5, 7.0])
@pytest.mark.parametrize("name", PENALTIES)
def test_the_cost_is_the_lowest_sum_of_weighted_square_and_penalty(name: str, u: float) -> None:
    printed, penalty = PENALTIES[name]
    kernel, scale = kernels.KERNELS[name](1.7), 1.7**2 / 2
    best = minimize_scalar(
        lambda w: w * u**2 / 2 + scale * penalty(w), bounds=(1e-12, 1), options={"xatol": 1e-12}
    )
    assert f"${printed}$" in CHAPTER.text
    assert best.fun == pytest.approx(float(kernel.rho(u)), abs=1e-6)
    assert best.x == pytest.approx(float(kernel.weight(u)), abs=1e-4)
