"""Every decimal number that chapter 01 prints, against balances of pulls solved another way."""

from __future__ import annotations

from collections.abc import Callable
from math import sqrt

import numpy as np
import pytest
from robust_slam.estimators import kernels
from robust_slam.estimators.reweighting import irls
from robust_slam.problems import LinearProblem, LocationProblem
from scipy.optimize import brentq, least_squares, minimize, root
from scipy.special import huber
from scipy.stats import chi2

from tests.book.efficiency import efficiency
from tests.book.prose import chapter_text, decimals, rounds_to, unchecked

TEXT = chapter_text("01-m-estimators.ipynb")

SQUARED, HUBER, CAUCHY = kernels.squared(), kernels.huber(1.0), kernels.cauchy(1.0)
Psi = Callable[[np.ndarray], np.ndarray]

# Data that the chapter hands out, thresholds, defaults and section numbers of other programs and
# texts, exponents, places on an axis, and readings of a figure.
GIVEN = {
    "0.1",
    "-0.1",
    "0.15",
    "-0.2",
    "0.2",
    "0.3",
    "0.03",
    "1.345",
    "1.5",
    "3.12",
    "14.9",
    "15.1",
}


# The wall: ten places, a lie of so many metres at place 8.
P = np.arange(10.0)
NOISE = np.array([0.1, -0.2, 0.15, 0.05, -0.15, 0.2, -0.1, 0.1, 0.0, -0.1])
ROWS = np.column_stack([np.ones(10), P])


def wall(psi: Psi, height: float) -> tuple[float, float]:
    """Return the error at the door and the lie's pull, where forces and torques cancel."""
    y = 1 + P / 4 + NOISE + height * (P == 8)

    def pulls(line: np.ndarray) -> np.ndarray:
        return psi((y - ROWS @ line) / 0.2)

    found = root(lambda line: ROWS.T @ pulls(line), [1.0, 0.25])
    assert np.allclose(found.fun, 0.0, atol=1e-7)
    return float(found.x @ [1, 8] - 3), float(pulls(found.x)[8])


def at_rest(z: np.ndarray, psi: Psi, sigma: np.ndarray | float, lo: float, hi: float) -> float:
    """Return the x between lo and hi at which the pulls on it cancel."""
    return float(brentq(lambda x: np.sum(psi((z - x) / sigma) / sigma), lo, hi, xtol=1e-15))


def lever(place: float, k: float) -> float:
    """Return the slope at which the torques of five honest readings and of the lie cancel."""
    arms, y = np.append(np.arange(1.0, 6.0), place), np.append(np.arange(1.0, 6.0) / 2, 0.0)
    pull = kernels.huber(k).psi
    return float(brentq(lambda b: arms @ pull((y - b * arms) / 0.3), 0, 0.5, xtol=1e-14))


THOUSAND = np.append(np.zeros(1000), 100.0)
HONEST = np.array([0.1, -0.2, 0.15, -0.1])
FIVE = np.append(HONEST, 5.0)
CLOSURE, DEVIATIONS = np.array([0.3, -0.2, 0.03]), np.array([0.1, 0.1, 0.01])
U = float(np.linalg.norm(CLOSURE / DEVIATIONS))
POINTS = np.array([[0.1, -0.2], [-0.1, 0.1], [0.2, 0.0], [-0.2, 0.1], [6.0, 1.0]])
WIDE_HUBER = kernels.huber(1.345)
CRUDE, GENTLE = wall(SQUARED.psi, 3.0), wall(kernels.cauchy(2.385).psi, 3.0)


def centre(points: np.ndarray) -> np.ndarray:
    """Return the point of least Huber cost, one norm a reading, by scipy's own Huber function."""

    def cost(x: np.ndarray) -> float:
        return float(huber(1.0, np.linalg.norm(points - x, axis=1)).sum())

    return np.asarray(minimize(cost, [0.0, 0.0], tol=1e-10).x)


def turned_entries() -> np.ndarray:
    """Return Huber's estimate of each turned coordinate apart, turned back."""
    turn = np.array([[1, -1], [1, 1]]) / sqrt(2)
    apart = [at_rest(z, HUBER.psi, 1.0, -5, 7) for z in (POINTS @ turn.T).T]
    return np.asarray(turn.T @ apart)


CLAIMS = {
    "0.73": CRUDE[0],
    "11.327": CRUDE[1],
    "0.01": GENTLE[0],
    "0.371": GENTLE[1],
    "0.5": float(SQUARED.rho(1.0)),
    "60.5": float(SQUARED.rho(11.0)),
    "40.5": float(SQUARED.rho(9.0)),
    "10.5": float(SQUARED.rho(11.0) - SQUARED.rho(10.0)),
    "0.0999001": at_rest(THOUSAND, SQUARED.psi, 1.0, 0, 1),
    "0.0999": at_rest(THOUSAND, SQUARED.psi, 1.0, 0, 1),
    "0.001": at_rest(THOUSAND, HUBER.psi, 1.0, 0, 1),
    "0.00001": at_rest(THOUSAND, CAUCHY.psi, 1.0, 0, 0.5),
    "0.00000999900110": at_rest(THOUSAND, CAUCHY.psi, 1.0, 0, 0.5),
    "49.5": float(SQUARED.rho(10.0) - SQUARED.rho(1.0)),
    "9.5": float(HUBER.rho(10.0)),
    "4.690416": U,
    "1.628": brentq(lambda k: efficiency(kernels.huber(k), 3) - 0.95, 0.3, 9.0),
    "0.347091": 1.628 / U,
    "61.3": 100 * float(chi2.sf(1.345**2, 3)),
    "17.9": 100 * float(chi2.sf(1.345**2, 1)),
    "0.361801": float(np.linalg.norm(CLOSURE)),
    "1.756282": float(np.linalg.norm([0.3, -0.2, np.degrees(0.03)])),
    "0.074": wall(WIDE_HUBER.psi, 3.0)[0],
    "0.015": -wall(lambda u: u * (np.abs(u) <= 2.576), 3.0)[0],
    "0.4": 0.4 if wall(SQUARED.psi, 0.4)[1] > 1.345 > wall(SQUARED.psi, 0.2)[1] else 0.0,
    "-0.05": float(HONEST.sum()),
    "0.0625": at_rest(FIVE, HUBER.psi, 0.3, -1, 1),
    "-0.0125": float(HONEST.mean()),
    "0.075": at_rest(FIVE, HUBER.psi, 0.3, -1, 1) - float(HONEST.mean()),
    "-0.008459": at_rest(HONEST, CAUCHY.psi, 0.3, -0.1, 0.1),
    "0.25": at_rest(POINTS[:, 0], HUBER.psi, 1.0, -1, 1),
    "0.354": float(turned_entries()[0]),
    "0.247": float(centre(POINTS)[0]),
    "0.041": float(centre(POINTS)[1]),
    "0.95": at_rest(np.repeat([0.0, 50.0], [20, 19]), HUBER.psi, 1.0, -1, 2),
    "49.0476": at_rest(np.repeat([0.0, 50.0], [20, 21]), HUBER.psi, 1.0, 10, 50),
    "0.0055": 0.5 - lever(1.0, 1.0),
    "0.44": lever(11.0, 1.0),
    "0.23": lever(14.9, 1.0),
    "0.02": lever(15.1, 1.0),
    "0.473": lever(14.9, 0.1),
    "0.002": lever(15.1, 0.1),
    "2.4": float(np.mean([0, 0, 0, 0, 12])),
}
READ_OFF = {"0.48"}  # a level of a curve, tested below


@pytest.mark.parametrize("printed", CLAIMS)
def test_a_printed_number_is_the_computed_one(printed: str) -> None:
    assert rounds_to(CLAIMS[printed], printed), CLAIMS[printed]


def test_every_printed_number_is_checked() -> None:
    assert not unchecked(TEXT, CLAIMS, GIVEN | READ_OFF)


def test_every_checked_number_is_still_printed() -> None:
    assert not (set(CLAIMS) | GIVEN | READ_OFF) - decimals(TEXT)


def test_cost_and_pull_have_the_printed_ratios() -> None:
    assert float(SQUARED.rho(10.0) / SQUARED.rho(1.0)) == 100
    assert float(SQUARED.psi(10.0) / SQUARED.psi(1.0)) == 10
    assert "| ratio | **100** | **10** |" in TEXT


@pytest.mark.parametrize(("kernel", "printed"), [(SQUARED, "2e-22"), (HUBER, "7e-05")])
def test_densities_at_ten(kernel: kernels.Kernel, printed: str) -> None:
    density = float(np.exp(-kernel.rho(10.0)))
    assert density == pytest.approx(float(printed), rel=0.1)


def test_beyond_forty_centimetres_huber_does_not_see_where_the_lie_is() -> None:
    at = [wall(WIDE_HUBER.psi, height) for height in (0.4, 0.6, 1.5, 3.0)]
    np.testing.assert_allclose(at, [at[0]] * 4, atol=1e-9)
    assert at[0][1] == 1.345


def test_seven_honest_readings_hold_the_rod_against_the_lie() -> None:
    y = 1 + P / 4 + NOISE + 3.0 * (P == 8)
    pulls = (y - ROWS @ np.linalg.lstsq(ROWS, y, rcond=None)[0]) / 0.2
    assert int(np.sum(pulls < 0)) == 7


def test_tls_lets_go_between_two_heights_of_the_slider() -> None:
    def fitted(height: float) -> float:
        y = 1 + P / 4 + NOISE + height * (P == 8)
        problem = LinearProblem(ROWS, y, 0.2)
        start = irls(problem, WIDE_HUBER, max_iterations=500).x
        return float(irls(problem, kernels.tls(2.576), start).weights[8])

    assert [fitted(height) for height in (0.4, 0.6)] == [1.0, 0.0]


def test_cauchy_pulls_hardest_inside_the_slider() -> None:
    pulls = [wall(kernels.cauchy(2.385).psi, height)[1] for height in (0.4, 0.6, 0.8, 3.0)]
    assert max(pulls) == pulls[1]
    assert pulls[3] < 0.4


@pytest.mark.parametrize("m", [1, 5, 19])
def test_huber_is_shifted_by_m_k_sigma_over_n(m: int) -> None:
    z, k, sigma = np.repeat([0.0, 1e4], [20, m]), 1.345, 0.2
    x = at_rest(z, kernels.huber(k).psi, sigma, -1, 1)
    assert x == pytest.approx(m * k * sigma / 20)


def test_with_as_many_lies_every_place_between_is_at_rest() -> None:
    z = np.repeat([0.0, 50.0], [20, 20])
    assert [float(HUBER.psi(z - x).sum()) for x in (1.0, 25.0, 49.0)] == [0.0, 0.0, 0.0]
    assert irls(LocationProblem(z), CAUCHY, x0=25.0).x == pytest.approx(25.0)


def test_the_square_ends_where_its_figure_says() -> None:
    assert round(float(np.mean(np.repeat([0.0, 50.0], [20, 25])))) == 28


def test_the_formula_of_the_lever_holds_up_to_eleven() -> None:
    assert [0.5 - lever(place, 1.0) for place in (1.0, 10.0, 11.0)] == pytest.approx(
        [0.3 * place / 55 for place in (1.0, 10.0, 11.0)]
    )
    assert 0.5 - lever(12.0, 1.0) > 1.01 * 0.3 * 12 / 55


@pytest.mark.parametrize("k", [0.01, 0.1, 1.0])
def test_beyond_fifteen_the_line_lies_on_the_lie(k: float) -> None:
    assert lever(15.1, k) * 15.1 / 0.3 < k


@pytest.mark.parametrize("place", [10.0, 15.0, 30.0])
def test_cauchy_stays_where_its_figure_says_if_it_starts_at_the_truth(place: float) -> None:
    arms, y = np.append(np.arange(1.0, 6.0), place), np.append(np.arange(1.0, 6.0) / 2, 0.0)
    problem = LinearProblem(arms[:, None], y, 0.3)
    found = irls(problem, kernels.cauchy(2.385), np.array([0.5]), max_iterations=1000).x[0]
    assert rounds_to(float(found), "0.48")


@pytest.mark.parametrize(
    ("loss", "psi"),
    [
        ("linear", lambda f: f),
        ("huber", lambda f: np.clip(f, -1, 1)),
        ("soft_l1", lambda f: f / np.sqrt(1 + f**2)),
        ("cauchy", lambda f: f / (1 + f**2)),
        ("arctan", lambda f: f / (1 + f**4)),
    ],
)
@pytest.mark.parametrize("f", [-3.0, -0.4, 0.7, 5.0])
def test_the_pulls_of_scipys_losses(loss: str, psi: Psi, f: float) -> None:
    def cost(x: float) -> float:
        return float(least_squares(lambda _: [x], 0.0, loss=loss, max_nfev=1).cost)

    assert (cost(f + 1e-5) - cost(f - 1e-5)) / 2e-5 == pytest.approx(float(psi(f)), abs=1e-6)


def test_a_loss_on_each_entry_depends_on_the_axes_and_on_the_norm_does_not() -> None:
    assert at_rest(POINTS[:, 1], HUBER.psi, 1.0, -1, 1) == pytest.approx(0.2)
    assert turned_entries()[1] == pytest.approx(0.0, abs=1e-12)
    turn = np.array([[1, -1], [1, 1]]) / sqrt(2)
    np.testing.assert_allclose(turn.T @ centre(POINTS @ turn.T), centre(POINTS), atol=1e-5)


def test_at_a_million_least_squares_goes_to_999() -> None:
    assert round(float(np.mean(np.append(np.zeros(1000), 1e6)))) == 999


def test_the_exercises_by_hand() -> None:
    for m, huber_says, squared_says in ((1, 0.25, 2.4), (2, 0.5, 4.0)):
        z = np.repeat([0.0, 12.0], [4, m])
        assert at_rest(z, HUBER.psi, 1.0, -1, 5) == pytest.approx(huber_says)
        assert float(np.mean(z)) == pytest.approx(squared_says)
    arms, lie = np.arange(1.0, 5.0), 7.0
    error = float(brentq(lambda e: arms @ HUBER.psi(e * arms) - lie, 0, 5))
    assert error == pytest.approx(7 / 30)
    assert arms.sum() < 11
