"""Answers to exercise switch_weight of 06-switches-and-consistency: each body is a cell."""

from robust_slam_autograder.lint.answers import change


def right_square() -> None:
    """Right: the square of the best switch."""
    import numpy as np

    def switch_weight(chi2, lam):
        s = lam / (lam + np.asarray(chi2, dtype=float))
        return s * s


def right_geman_mcclure() -> None:
    """Right, an equivalent formula: Geman and McClure's weight with c² = λ."""
    import numpy as np

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
    import numpy as np

    def switch_weight(chi2, lam):
        c = np.asarray(chi2, dtype=float)
        return (lam * (lam + c) - lam * c) / (lam + c) ** 2


def wrong_switch_itself() -> None:
    """Wrong: the switch in place of its square, though it scales the residual before that is
    squared. Caught by switch_weight-table.
    """
    import numpy as np

    def switch_weight(chi2, lam):
        return lam / (lam + np.asarray(chi2, dtype=float))


wrong_norm = change(
    right_geman_mcclure,
    "np.reciprocal(np.square(1 + np.array(chi2, dtype=float) / lam))",
    "(1 + np.sqrt(np.asarray(chi2, dtype=float) / lam)) ** -2.0",
    caught_by="switch_weight-table",
)
"""Wrong: a weight of the norm, 1/(1 + u/c)² with c² = λ, and not of its square."""

wrong_lambda_is_one = change(
    right_geman_mcclure,
    "np.reciprocal(np.square(1 + np.array(chi2, dtype=float) / lam))",
    "1 / (1 + np.asarray(chi2, dtype=float)) ** 2",
    stopped_by="switch_weight-kernel",
)
"""Wrong for λ other than 1: the ratio is clipped, and λ left out."""


def wrong_slope_times_lambda() -> None:
    """Wrong for λ other than 1: the slope of χ²/(λ + χ²), where the λ above the line is
    forgotten. Caught by switch_weight-slope.
    """
    import numpy as np

    def switch_weight(chi2, lam):
        chi2 = np.asarray(chi2, dtype=float)
        near = chi2 <= 1e-9
        return np.where(near | (chi2 == lam), 1 / (1 + chi2 / lam) ** 2, lam / (lam + chi2) ** 2)


def wrong_cubed() -> None:
    """Wrong: s³, one factor too many. Caught by switch_weight-table."""
    import numpy as np

    def switch_weight(chi2, lam):
        return (lam / (lam + np.asarray(chi2, dtype=float))) ** 3


def wrong_exactly_zero() -> None:
    """Wrong: sets small weights to 0, so that the edge can never come back. Caught by
    switch_weight-far.
    """
    import numpy as np

    def switch_weight(chi2, lam):
        w = (lam / (lam + np.asarray(chi2, dtype=float))) ** 2
        return np.where(w < 1e-5, 0.0, w)


def wrong_one_at_a_time() -> None:
    """Wrong for nested lists: makes one row of all. Caught by switch_weight-shapes."""
    import numpy as np

    def switch_weight(chi2, lam):
        w = [(lam / (lam + float(one))) ** 2 for one in np.ravel(chi2)]
        return w if np.ndim(chi2) else w[0]
