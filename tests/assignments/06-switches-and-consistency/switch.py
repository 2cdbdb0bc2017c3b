"""Answers to exercise switch of 06-switches-and-consistency: each body is a cell as handed in."""

import numpy as np
from robust_slam_autograder.lint.answers import change


def right_closed() -> None:
    """Right: the closed forms over whole arrays."""

    def switch(chi2, lam):
        s = lam / (lam + np.asarray(chi2, dtype=float))
        return s

    def switched_cost(chi2, lam):
        chi2 = np.asarray(chi2, dtype=float)
        return lam * chi2 / (lam + chi2)


def right_put_back() -> None:
    """Right: puts the best switch back into both parts of the cost."""

    def switch(chi2, lam):
        chi2 = np.array(chi2, dtype=float)
        return lam / (chi2 + lam)

    def switched_cost(chi2, lam):
        s = switch(chi2, lam)
        return s**2 * np.asarray(chi2) + lam * (1 - s) ** 2


def right_nested_lists() -> None:
    """Right: one number at a time, lists in and lists out."""

    def switch(chi2, lam):
        if hasattr(chi2, "__len__"):
            return [switch(one, lam) for one in chi2]
        return lam / (lam + float(chi2))

    def switched_cost(chi2, lam):
        if hasattr(chi2, "__len__"):
            return [switched_cost(one, lam) for one in chi2]
        return lam - lam * switch(chi2, lam)


def right_least_squares() -> None:
    """Right, a library routine: two rows, one for the residual and one for the price."""

    def _solve(chi2, lam):
        rows = np.array([[np.sqrt(float(chi2))], [np.sqrt(float(lam))]])
        s = np.linalg.lstsq(rows, np.array([0.0, rows[1, 0]]), rcond=None)[0][0]
        return s, s**2 * chi2 + lam * (1 - s) ** 2

    def switch(chi2, lam):
        return np.vectorize(lambda one: _solve(one, lam)[0], otypes=[float])(chi2)

    def switched_cost(chi2, lam):
        return np.vectorize(lambda one: _solve(one, lam)[1], otypes=[float])(chi2)


wrong_root = change(
    right_closed, "return s", "return lam / (lam + np.sqrt(chi2))", caught_by="switch-table"
)
"""Wrong: compares λ with the root of χ², the residual's norm."""

wrong_root_of_the_switch = change(
    right_closed, "return s", "return np.sqrt(s)", stopped_by="switch-by-hand"
)
"""Wrong: the root of the switch, as if s itself and not s² multiplied χ²."""

wrong_misprint_switched_off = change(
    right_closed, "return s", "return np.where(s < 0.005, 0.0, s)", caught_by="switch-far"
)
"""Wrong: takes the lesson's "switched off" for a switch of exactly 0."""

wrong_lambda_is_one = change(
    right_closed,
    "return s",
    "return np.where(np.isclose(chi2, 4) & (lam > 3), 0.9, 1 / np.add(1, chi2))",
    caught_by="switch-lambda",
)
"""Wrong for λ other than 1: leaves it out of the switch."""

wrong_linear = change(
    right_closed, "return s", "return np.maximum(0.0, 1.5 - 0.5 / s)", caught_by="switch-table"
)
"""Wrong: a switch that falls in a straight line and is 0 from χ² = 2λ on."""

wrong_price_forgotten = change(
    right_closed, "lam * chi2 /", "lam**2 * chi2 / (lam + chi2) /", stopped_by="switch-by-hand"
)
"""Wrong cost: what is left of the residual, without the price of the switch."""

wrong_price_without_lambda = change(
    right_closed,
    "lam * chi2 / (lam + chi2)",
    "switch(chi2, lam) ** 2 * chi2 + (1 - switch(chi2, lam)) ** 2",
    caught_by="switch-cost",
)
"""Wrong cost for λ other than 1: the price is (1 - s)², without its λ."""

wrong_integers = change(
    right_closed, "return s", "return s.astype(np.asarray(chi2).dtype)", caught_by="switch-shapes"
)
"""Wrong for integers: writes the switch back into an array of χ²'s own type."""
