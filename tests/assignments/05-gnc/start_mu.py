"""Answers to exercise start_mu of 05-gnc: each body is a cell as handed in."""

import numpy as np
from robust_slam_autograder.lint.answers import change


def right_formulas() -> None:
    """Right: the two formulas, with the condition for TLS."""

    def start_mu(u_max, c, kind):
        if kind == "tls":
            if 2 * u_max**2 <= c**2:
                return np.inf
            return c**2 / (2 * u_max**2 - c**2)
        return 2 * u_max**2 / c**2


def right_ratio() -> None:
    """Right: both from the one ratio 2u²/c²."""

    def start_mu(u_max, c, kind):
        ratio = 2 * u_max**2 / c**2
        if kind == "gm":
            return ratio
        return 1 / (ratio - 1) if ratio > 1 else np.inf


def right_negative_means_inf() -> None:
    """Right: the formula first, and then what its sign says."""
    import math

    def start_mu(u_max, c, kind):
        u_max, c = np.float64(u_max), np.float64(c)
        if kind == "tls":
            gap = (math.sqrt(2) * u_max - c) * (math.sqrt(2) * u_max + c)
            mu = c**2 / gap
            return mu if mu > 0 else math.inf
        return np.square(math.sqrt(2) * u_max / c)


def right_search() -> None:
    """Right: SciPy finds the μ that puts the upper knee where it should be."""
    from scipy.optimize import brentq

    def start_mu(u_max, c, kind):
        goal = 2 * (u_max / c) ** 2
        if kind == "gm":
            return goal
        if goal <= 1:
            return np.inf
        return np.exp(brentq(lambda t: np.log1p(np.exp(-t)) - np.log(goal), -60, 60, xtol=1e-13))


wrong_swapped = change(right_ratio, '"gm"', '"tls"', stopped_by="start_mu-by-hand")
"""Wrong: the formula of GM for TLS and that of TLS for GM."""

wrong_misprint = change(
    right_ratio,
    ("return ratio", "return 1.0"),
    ("1 / (ratio - 1) if ratio > 1 else np.inf", "1.0"),
    stopped_by="start_mu-by-hand",
)
"""Wrong: begins at μ = 1, whatever the residuals are, as the lesson does."""

wrong_negative_mu = change(
    right_ratio, " if ratio > 1 else np.inf", "", stopped_by="start_mu-nothing"
)
"""Wrong for small residuals: the formula alone, which turns negative."""

wrong_absolute_value = change(
    right_ratio, ("(ratio - 1)", "abs(ratio - 1)"), ("> 1", "> 0.5"), caught_by="start_mu-nothing"
)
"""Wrong for small residuals: takes the sign away, and gives inf only below half of c."""

wrong_inf_inside_c = change(right_ratio, "ratio > 1", "u_max > c", caught_by="start_mu-nothing")
"""Wrong between c/√2 and c: finds nothing to reject while u is below c."""

wrong_without_the_two = change(right_ratio, "2 * u_max", "u_max", stopped_by="start_mu-by-hand")
"""Wrong: puts the upper knee at u_max itself."""

wrong_gm_at_least_one = change(
    right_ratio, "return ratio", "return max(1.0, ratio)", caught_by="start_mu-gm"
)
"""Wrong below 1: lifts GM's number to 1 here already."""

wrong_tls_at_most_one = change(
    right_ratio, "1 / (ratio - 1)", "min(1.0, 1 / (ratio - 1))", caught_by="start_mu-tls"
)
"""Wrong above 1: takes TLS's μ for a number that is always small."""

wrong_whole_numbers = change(
    right_ratio, "if kind", "ratio = type(u_max * c)(ratio)\nif kind", caught_by="start_mu-shapes"
)
"""Wrong for integers: divides them without a remainder."""
