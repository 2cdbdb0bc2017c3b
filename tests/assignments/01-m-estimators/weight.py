"""Answers to exercise weight of 01-m-estimators: each body is a cell as handed in."""

import numpy as np
from robust_slam_autograder.lint.answers import change


def right_where() -> None:
    """Right: replaces 0 before it divides, and the answer there."""

    def weight(psi, u):
        u = np.asarray(u, dtype=float)
        safe = np.where(u == 0, 1.0, u)
        return np.where(u == 0, 1.0, psi(safe) / safe)


def right_masked() -> None:
    """Right: an array of ones, divided where u is not 0."""

    def weight(psi, u):
        u = np.array(u, dtype=float)
        w = np.ones_like(u)
        np.divide(psi(u), u, out=w, where=u != 0)
        return w


def right_one_by_one() -> None:
    """Right: plain Python, one number at a time; lists of lists come back."""

    def weight(psi, u):
        if hasattr(u, "__len__") and getattr(u, "shape", None) != ():
            return [weight(psi, v) for v in u]
        return 1.0 if u == 0 else float(psi(u)) / float(u)


def right_nan_replaced() -> None:
    """Right: divides with the warning off, and replaces what is no number by the limit."""

    def weight(psi, u):
        u = np.asarray(u, dtype=float)
        with np.errstate(invalid="ignore"):
            w = np.asarray(psi(u)) / u
        return np.where(np.isnan(w), 1.0, w)


def right_tiny() -> None:
    """Right to rounding: moves 0 to a number next to it, where ψ is like u."""

    def weight(psi, u):
        u = np.asarray(u, dtype=float)
        u = np.where(u == 0, 1e-100, u)
        return psi(u) / u


wrong_plain_division = change(
    right_tiny, "u = np.where(u == 0, 1e-100, u)\nreturn", "return", stopped_by="weight-zero"
)
"""Wrong: 0/0 is NaN."""

wrong_zero_at_zero = change(right_where, "1.0, psi", "0.0, psi", caught_by="weight-zero")
"""Wrong: no residual, no weight."""

wrong_padded_divisor = change(
    right_tiny,
    "np.where(u == 0, 1e-100, u)\nreturn psi(u)",
    "u + 1e-12\nreturn psi(u - 1e-12)",
    caught_by="weight-zero",
)
"""Wrong: adds a little to the divisor, so that 0 gets the weight 0."""

wrong_no_number_alone = change(
    right_where,
    "return",
    "if u.ndim == 0:\n    return np.nan_to_num(psi(u) / u)\nreturn",
    caught_by="weight-zero",
)
"""Wrong for a number alone: the mask of an array is forgotten there."""

wrong_clipped_divisor = change(
    right_where, "psi(safe) / safe", "psi(u) / np.maximum(u, 1e-12)", stopped_by="weight-negative"
)
"""Wrong left of 0: divides by the larger of u and a little."""

wrong_sign_kept = change(
    right_where, "/ safe", "/ np.where(u < -2, -u, safe)", caught_by="weight-negative"
)
"""Wrong: divides by the size of u, so that a large negative residual has a negative weight."""

wrong_divided_twice = change(right_where, "/ safe", "/ safe**2", stopped_by="weight-by-hand")
"""Wrong: ψ/u²."""

wrong_slope = change(
    right_tiny, "psi(u) / u", "(psi(u + 1e-5) - psi(u - 1e-5)) / 2e-5", stopped_by="weight-by-hand"
)
"""Wrong: the slope of ψ, which is 1 at 0 as well."""

wrong_capped_at_a_tenth = change(
    right_where, "psi(safe) / safe", "np.fmax(psi(safe) / safe, 0.1)", caught_by="weight-positive"
)
"""Wrong: keeps every weight above a tenth."""

wrong_wide_zero = change(right_tiny, "u == 0", "np.abs(u) < 1e-3", caught_by="weight-tiny")
"""Wrong: takes every u below a thousandth for 0."""

wrong_integers = change(
    right_masked,
    ("np.array(u, dtype=float)", "np.asarray(u)"),
    ("np.divide(psi(u), u, out=w, where=u != 0)", "w[u != 0] = psi(u[u != 0]) / u[u != 0]"),
    caught_by="weight-shapes",
)
"""Wrong for integers: puts the weights into an array of u's own type."""


wrong_size_of_u = change(
    right_where, "np.asarray(u, dtype=float)", "1.0 * np.abs(u)", caught_by="weight-negative"
)
"""Wrong: asks ψ at the size of u, as if it were as strong on the left as on the right."""

wrong_zero_past_fifty = change(
    right_masked, "return w", "return np.where(np.abs(u) > 50, 0, w)", caught_by="weight-positive"
)
"""Wrong for large residuals: gives all of them the weight 0."""

wrong_root_of_the_weight = change(
    right_where, "psi(safe) / safe", "np.sqrt(psi(safe) / safe)", stopped_by="weight-by-hand"
)
"""Wrong: the factor of the residual, the root of the weight that multiplies its square."""
