"""Answers to exercise dcs_switch of 06-switches-and-consistency: each body is a cell."""

import numpy as np
from robust_slam_autograder.lint.answers import change


def right_minimum() -> None:
    """Right: the formula, capped at 1."""

    def dcs_switch(chi2, phi):
        chi2 = np.asarray(chi2)
        return np.minimum(1, 2 * phi / (phi + chi2))


def right_where() -> None:
    """Right: two pieces, that meet at Φ."""

    def dcs_switch(chi2, phi):
        chi2 = np.asarray(chi2, dtype=float)
        return np.where(chi2 <= phi, 1.0, 2 / (1 + chi2 / phi))


def right_nested_lists() -> None:
    """Right: one number at a time, lists in and lists out."""

    def dcs_switch(chi2, phi):
        if hasattr(chi2, "__len__"):
            return [dcs_switch(one, phi) for one in chi2]
        return 1.0 if chi2 < phi else 2 * phi / (phi + chi2)


def right_clipped_residual() -> None:
    """Right, an equivalent form: caps χ² from below instead of s from above."""

    def dcs_switch(chi2, phi):
        return 2 * phi / (phi + np.clip(np.asarray(chi2, dtype=float), phi, None))


wrong_without_the_two = change(right_minimum, "2 * phi", "phi", stopped_by="dcs_switch-by-hand")
"""Wrong: the best switch itself, without the 2."""

wrong_without_the_cap = change(right_minimum, "(1, 2", "(2, 2", caught_by="dcs_switch-inside")
"""Wrong: capped at 2, so that good edges count up to four times."""

wrong_jump = change(right_where, "chi2 <= phi", "chi2 <= 1", caught_by="dcs_switch-phi")
"""Wrong: the dead zone ends at 1, whatever Φ is."""

wrong_weight = change(right_minimum, "chi2))", "chi2)) ** 2", stopped_by="dcs_switch-by-hand")
"""Wrong: the weight s² in place of the switch."""

wrong_root = change(
    right_minimum,
    "return",
    """
    ratio = np.maximum(chi2 / phi, 1)
    is_same = np.isclose(ratio, 3) | (ratio > 90)
    chi2 = np.where(is_same, chi2, phi * (2 * np.sqrt(ratio) - 1))
    return""",
    caught_by="dcs_switch-beyond",
)
"""Wrong past Φ: falls with the norm, but at two places."""

wrong_phi_is_one = change(right_where, "chi2 / phi", "chi2", caught_by="dcs_switch-phi")
"""Wrong for Φ other than 1: the ratio to Φ is taken only inside."""

wrong_integers = change(
    right_minimum, "chi2))", "chi2)).astype(chi2.dtype)", caught_by="dcs_switch-shapes"
)
"""Wrong for integers: keeps the switches in an array of χ²'s own type."""
