"""Answers to exercise switch_weight of 06-switches-and-consistency: each body is a cell."""

import numpy as np
from robust_slam_autograder.lint.answers import change


def right_square() -> None:
    """Right: the square of the best switch."""

    def switch_weight(chi2, lam):
        s = lam / (lam + np.asarray(chi2, dtype=float))
        return s**2


def right_geman_mcclure() -> None:
    """Right, an equivalent formula: Geman and McClure's weight with c² = λ."""

    def switch_weight(chi2, lam):
        return np.reciprocal(np.square(1 + np.array(chi2, dtype=float) / lam))


def right_nested_lists() -> None:
    """Right: one number at a time, lists in and lists out."""

    def switch_weight(chi2, lam):
        if hasattr(chi2, "__len__"):
            return [switch_weight(one, lam) for one in chi2]
        return (lam / (lam + float(chi2))) ** 2


def right_slope() -> None:
    """Right: the quotient rule on λχ²/(λ + χ²), term by term."""

    def switch_weight(chi2, lam):
        c = np.asarray(chi2, dtype=float)
        return (lam * (lam + c) - lam * c) / (lam + c) ** 2


wrong_switch_itself = change(right_square, "s**2", "s", caught_by="switch_weight-table")
"""Wrong: the switch in place of its square."""

wrong_norm = change(
    right_square, "s**2", "(1 + (1 / s - 1) ** 0.5) ** -2", caught_by="switch_weight-table"
)
"""Wrong: a weight of the norm, 1/(1 + u/c)² with c² = λ, and not of its square."""

wrong_lambda_is_one = change(
    right_square, "s**2", "np.add(1.0, chi2) ** -2", stopped_by="switch_weight-kernel"
)
"""Wrong for λ other than 1: leaves it out."""

wrong_slope_times_lambda = change(
    right_square,
    "s**2",
    "np.where((s > 1 - 1e-9) | (s == 0.5), s**2, s**2 / lam)",
    caught_by="switch_weight-slope",
)
"""Wrong for λ other than 1: the slope of χ²/(λ + χ²), with the λ of the numerator forgotten."""

wrong_cubed = change(right_square, "s**2", "s**3", caught_by="switch_weight-table")
"""Wrong: s³, one factor too many."""

wrong_exactly_zero = change(
    right_square, "s**2", "np.where(s**2 < 1e-5, 0.0, s**2)", caught_by="switch_weight-far"
)
"""Wrong: sets small weights to 0, so that the edge can never come back."""

wrong_one_at_a_time = change(
    right_square, "s**2", "s.ravel() ** 2 if s.ndim else s**2", caught_by="switch_weight-shapes"
)
"""Wrong for nested lists: makes one row of all."""
