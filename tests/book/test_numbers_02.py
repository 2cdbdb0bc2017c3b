"""Every decimal number that chapter 02 prints, against the library or a closed form."""

from __future__ import annotations

from collections.abc import Callable
from math import e, log, sqrt

import numpy as np
import pytest
from robust_slam.estimators import kernels
from robust_slam.estimators.reweighting import irls
from robust_slam.estimators.thresholds import chi_square_threshold
from robust_slam.problems import LocationProblem
from scipy.optimize import brentq
from scipy.stats import chi2

from tests.book.efficiency import efficiency
from tests.book.prose import chapter_text, decimals, rounds_to, unchecked

TEXT = chapter_text("02-four-costs.ipynb")

SQUARED, HUBER, CAUCHY, TLS = (
    kernels.squared(),
    kernels.huber(1.0),
    kernels.cauchy(1.0),
    kernels.tls(1.0),
)
GEMAN_MCCLURE = kernels.geman_mcclure(1.0)
FOUR = (SQUARED, HUBER, CAUCHY, TLS)

# Data that the chapter hands out, section numbers of other texts, and p = 0.99.
GIVEN = {"0.1", "-0.2", "0.15", "-0.1", "0.3", "0.8", "1.2", "0.99", "3.12"}


def curvature(kernel: kernels.Kernel, u: float) -> float:
    return float(kernel.psi(u + 1e-6) - kernel.psi(u - 1e-6)) / 2e-6


def thrown_away(c: float, d: int) -> float:
    """Percent of honest d-vectors whose norm is beyond c."""
    return 100.0 * float(chi2.sf(c**2, d))


def constant(make: Callable[[float], kernels.Kernel], d: int) -> float:
    """The threshold with an efficiency of 95 %."""
    return float(brentq(lambda c: efficiency(make(c), d) - 0.95, 0.3, 9.0))


def door(sigma: float) -> float:
    z = np.array([2.03, 1.97, 2.04, 1.98, 3.00])
    kernel = kernels.tls(chi_square_threshold(0.99, 1))
    return irls(LocationProblem(z, sigma), kernel, x0=float(np.median(z))).x


SCALAR, PLANAR, SPATIAL = (chi_square_threshold(0.99, d) for d in (1, 3, 6))
Z = [0.1, -0.2, 0.15, -0.1, 5.0]

CLAIMS = {
    "9.5": float(HUBER.rho(10.0)),
    "0.346574": float(CAUCHY.rho(1.0)),
    "2.307560": float(CAUCHY.rho(10.0)),
    "6.658211": float(CAUCHY.rho(10.0) / CAUCHY.rho(1.0)),
    "0.0099010": float(CAUCHY.weight(10.0)),
    "0.324760": float(GEMAN_MCCLURE.psi(1 / sqrt(3))),
    "0.577350": GEMAN_MCCLURE.convex_until,
    "0.577": GEMAN_MCCLURE.convex_until,
    "0.133849": curvature(CAUCHY, 0.8),
    "-0.073905": curvature(CAUCHY, 1.2),
    "12.5": float(SQUARED.rho(5.0)),
    "4.5": float(HUBER.rho(5.0)),
    "1.629048": float(CAUCHY.rho(5.0)),
    "0.5": float(TLS.rho(5.0)),
    "0.2": float(HUBER.weight(5.0)),
    "0.038462": float(CAUCHY.weight(5.0)),
    "1.310832": sqrt(e - 1),
    "2.527658": sqrt(e**2 - 1),
    "2.5758": SCALAR,
    "3.3682": PLANAR,
    "4.1002": SPATIAL,
    "11.344867": PLANAR**2,
    "16.8119": SPATIAL**2,
    "8.4059": SPATIAL**2 / 2,
    "31.7": thrown_away(1.0, 1),
    "80.1": thrown_away(1.0, 3),
    "35.6": thrown_away(SCALAR, 6),
    "19.8": thrown_away(SCALAR / 2, 1),
    "1.345": constant(kernels.huber, 1),
    "1.628": constant(kernels.huber, 3),
    "1.869": constant(kernels.huber, 6),
    "2.385": constant(kernels.cauchy, 1),
    "2.666": constant(kernels.cauchy, 3),
    "2.862": constant(kernels.cauchy, 6),
    "3.787": constant(kernels.geman_mcclure, 1),
    "4.337": constant(kernels.geman_mcclure, 3),
    "4.846": constant(kernels.geman_mcclure, 6),
    "91.6": 100 * efficiency(kernels.tls(SCALAR), 1),
    "95.5": 100 * efficiency(kernels.tls(PLANAR), 3),
    "90.3": 100 * efficiency(HUBER),
    "76.2": 100 * efficiency(CAUCHY),
    "2.005": door(0.05),
    "2.204": door(1.0),
    "0.0625": irls(LocationProblem(Z, 0.3), HUBER).x,
    "-0.0125": float(np.mean(Z[:4])),
    "3.1304875": float(kernels.huber(1.345).rho(3.0)),
    "0.448333": float(kernels.huber(1.345).weight(3.0)),
}


@pytest.mark.parametrize("printed", CLAIMS)
def test_a_printed_number_is_the_computed_one(printed: str) -> None:
    assert rounds_to(CLAIMS[printed], printed), CLAIMS[printed]


def test_every_printed_number_is_checked() -> None:
    assert not unchecked(TEXT, CLAIMS, GIVEN)


def test_every_checked_number_is_still_printed() -> None:
    assert not (set(CLAIMS) | GIVEN) - decimals(TEXT)


def test_the_table_of_ratios_and_weights() -> None:
    ratios = [float(k.rho(10.0) / k.rho(1.0)) for k in FOUR]
    weights = [float(k.weight(10.0)) for k in FOUR]
    np.testing.assert_allclose(ratios, [100, 19, log(101) / log(2), 1], rtol=1e-12)
    np.testing.assert_allclose(weights, [1, 0.1, 1 / 101, 0], rtol=1e-12)
    bold = ["**100**", "**19**", "**6.658211**", "**1**", "**0.1**", "**0.0099010**", "**0**"]
    assert not [number for number in bold if number not in TEXT]


def test_the_pull_has_its_top_where_the_text_says() -> None:
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


@pytest.mark.parametrize("lie", [5.0, 5e3, 5e6])
def test_huber_does_not_forget_a_lie(lie: float) -> None:
    result = irls(LocationProblem([*Z[:4], lie], 0.3), HUBER)
    assert result.x == pytest.approx((sum(Z[:4]) + 0.3) / 4, abs=1e-9)


def test_in_millimetres_one_reading_is_left() -> None:
    z = 1000 * np.array([2.03, 1.97, 2.04, 1.98, 3.00])
    result = irls(LocationProblem(z), kernels.tls(SCALAR), x0=float(np.median(z)))
    assert result.weights.tolist() == [1, 0, 0, 0, 0]


def test_cauchy_by_hand() -> None:
    assert CAUCHY.weight(1.0) == 1 / 2
    assert GEMAN_MCCLURE.weight(1.0) == 1 / 4
    np.testing.assert_allclose(CAUCHY.psi([3.0, 7.0]), [3 / 10, 7 / 50])
    np.testing.assert_allclose(CAUCHY.weight([3.0, 7.0]), [1 / 10, 1 / 50])
