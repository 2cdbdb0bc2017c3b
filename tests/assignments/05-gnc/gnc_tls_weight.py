"""Answers to exercise gnc_tls_weight of 05-gnc: each body is a cell as handed in."""

import numpy as np
from robust_slam_autograder.lint.answers import change


def right_pieces() -> None:
    """Right: the three pieces as in the statement."""

    def gnc_tls_weight(u, c, mu):
        size = np.maximum(np.abs(u), 1e-300)
        low, high = c**2 * mu / (mu + 1), c**2 * (mu + 1) / mu
        between = c * np.sqrt(mu * (mu + 1)) / size - mu
        return np.where(size**2 <= low, 1.0, np.where(size**2 >= high, 0.0, between))


def right_clip() -> None:
    """Right: the middle piece alone, clipped to what a weight can be; 1/0 is infinite."""

    def gnc_tls_weight(u, c, mu):
        with np.errstate(divide="ignore"):
            w = c * np.sqrt(mu**2 + mu) / np.abs(np.asarray(u, dtype=float)) - mu
        return np.clip(w, 0.0, 1.0)


def right_loop() -> None:
    """Right: plain Python, one number at a time, nested lists in and out."""
    from math import sqrt

    def gnc_tls_weight(u, c, mu):
        if np.ndim(u) > 0:
            return [gnc_tls_weight(one, c, mu) for one in u]
        square = float(u) ** 2
        if square * (mu + 1) <= c**2 * mu:
            return 1.0
        if square * mu >= c**2 * (mu + 1):
            return 0.0
        return c * sqrt(mu * (mu + 1)) / sqrt(square) - mu


def right_outlier_process() -> None:
    """Right, an equivalent form: SciPy minimises w u²/2 plus the price of w over 0 ≤ w ≤ 1."""
    from scipy.optimize import brentq

    def gnc_tls_weight(u, c, mu):
        def best(size):
            def slope(w):
                return size**2 - c**2 * mu * (mu + 1) / (mu + w) ** 2

            if slope(1.0) <= 0:
                return 1.0
            return 0.0 if slope(0.0) >= 0 else brentq(slope, 0.0, 1.0, xtol=1e-15)

        u = np.asarray(u, dtype=float)
        return np.array([best(abs(one)) for one in u.ravel()]).reshape(u.shape)


wrong_misprint_surrogate = change(
    right_clip,
    "np.clip(w, 0.0, 1.0)",
    "c**4 * mu * (mu + 1) / ((mu + 1) * c**2 + np.square(u)) ** 2",
    stopped_by="gnc_tls_weight-by-hand",
)
"""Wrong: the weight of the lesson's printed surrogate, which never becomes TLS."""

wrong_no_middle_piece = change(
    right_clip, "np.clip(w, 0.0, 1.0)", "1 - (np.abs(u) > c)", stopped_by="gnc_tls_weight-by-hand"
)
"""Wrong: 1 inside c and 0 past it, as if μ were infinite."""

wrong_c_for_c_squared = change(
    right_pieces,
    "low, high = c**2 * mu / (mu + 1), c**2",
    "low, high = c * mu / (mu + 1), c",
    stopped_by="gnc_tls_weight-middle",
)
"""Wrong for c other than 1: the knees are at c μ/(μ+1) and c (μ+1)/μ."""

wrong_c_squared_in_the_middle = change(
    right_pieces, "= c * np", "= c**2 * np", stopped_by="gnc_tls_weight-middle"
)
"""Wrong for c other than 1: c² over |u| in the middle piece."""

wrong_knees_of_u = change(
    right_pieces,
    "c**2 * mu / (mu + 1), c**2 * (mu + 1) / mu",
    "(c * mu / (mu + 1)) ** 2, (c * (mu + 1) / mu) ** 2",
    stopped_by="gnc_tls_weight-knees",
)
"""Wrong: compares |u| with c μ/(μ+1), where the condition is on u²."""

wrong_straight_middle = change(
    right_pieces,
    "return",
    "line = np.interp(size, np.sqrt([low, high]), [1, 0])\n"
    "between = between if mu == 1 else line\n"
    "return",
    caught_by="gnc_tls_weight-middle",
)
"""Wrong: the weight falls in a straight line between the knees, but for the example's μ."""

wrong_one_sided = change(
    right_pieces, "np.abs(u), 1e-300", "u, 1e-300", caught_by="gnc_tls_weight-negative"
)
"""Wrong left of zero: every negative residual is an inlier."""

wrong_zero_over_zero = change(
    right_pieces, "return", "return np.divide(u, u) *", caught_by="gnc_tls_weight-zero"
)
"""Wrong at 0: divides ρ' = u by u there, and NaN comes out."""

wrong_way_of_mu = change(
    right_pieces, "size = np", "mu = 1 / mu\nsize = np", stopped_by="gnc_tls_weight-hard"
)
"""Wrong: takes 1/μ for μ, so that a large μ is soft; at μ = 1 the two agree."""

wrong_flat_shape = change(
    right_clip, "w, 0.0", "w.ravel() if np.ndim(u) else w, 0.0", caught_by="gnc_tls_weight-shapes"
)
"""Wrong for arrays of two dimensions: returns one flat row."""
