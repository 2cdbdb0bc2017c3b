"""Answers to exercise rho_tls of 02-four-costs: each body is a cell as handed in."""

import numpy as np
from robust_slam_autograder.lint.answers import change


def right_minimum() -> None:
    """Right: the smaller of two squares, halved."""

    def rho_tls(u, c):
        return np.minimum(np.square(u), c**2) / 2

    def w_tls(u, c):
        return np.where(np.abs(u) <= c, 1, 0)


def right_without_half() -> None:
    """Right on the lesson's scale: no ½ in either piece; the weight as a truth value."""

    def rho_tls(u, c):
        return np.minimum(np.square(u), c**2)

    def w_tls(u, c):
        return np.abs(u) <= c


def right_plain_loops() -> None:
    """Right: plain Python, nested lists for nested lists."""

    def rho_tls(u, c):
        if hasattr(u, "__len__"):
            return [rho_tls(v, c) for v in u]
        return 0.5 * u * u if -c <= u <= c else 0.5 * c * c

    def w_tls(u, c):
        if hasattr(u, "__len__"):
            return [w_tls(v, c) for v in u]
        return 1.0 if -c <= u <= c else 0.0


def right_clip() -> None:
    """Right, an equivalent formula: the square of the clipped residual; a step for the weight."""

    def rho_tls(u, c):
        return np.clip(u, -c, c) ** 2 / 2

    def w_tls(u, c):
        return np.heaviside(c - np.abs(u), 1.0)


def right_masks() -> None:
    """Right: boolean masks on a float copy, any shape."""

    def rho_tls(u, c):
        cost = np.array(u, dtype=float) ** 2 / 2
        return np.where(cost > c**2 / 2, c**2 / 2, cost)

    def w_tls(u, c):
        weight = np.ones(np.shape(u))
        weight[np.square(u) > c * c] = 0.0
        return weight


wrong_sign = change(
    right_clip,
    ("np.clip(u, -c, c)", "np.minimum(u, c)"),
    ("np.abs(u)", "np.asarray(u)"),
    caught_by="rho_tls-negative",
)
"""Wrong left of zero: u ≤ c without the absolute value keeps every large negative residual."""

wrong_misprint = change(
    right_without_half,
    ("np.minimum(np.square(u), c**2)", "np.minimum(u, c) ** 2"),
    ("np.abs(u)", "np.asarray(u)"),
    caught_by="rho_tls-negative",
)
"""Wrong: the lesson's line as it is printed, u² if u ≤ c, without the absolute value."""

wrong_threshold_not_squared = change(right_minimum, "c**2", "c", caught_by="rho_tls-cost")
"""Wrong for c other than 1: caps the cost at c where it should be c²."""

wrong_half_on_one_piece = change(
    right_minimum,
    "np.minimum(np.square(u), c**2) / 2",
    "np.where(np.abs(u) <= c, np.square(u) / 2, c**2)",
    stopped_by="rho_tls-by-hand",
)
"""Wrong: the ½ is on the inner piece only, so the cost jumps at c."""

wrong_weight_two = change(right_minimum, "c, 1, 0", "c, 2, 0", stopped_by="rho_tls-by-hand")
"""Wrong weight: ρ'/u of the cost without the ½, which is 2 at 0."""

wrong_soft_weight = change(
    right_minimum,
    "np.where(np.abs(u) <= c, 1, 0)",
    "np.clip(2 - np.abs(u) / c, 0.0, 1.0)",
    caught_by="rho_tls-weight",
)
"""Wrong weight: lets it fall slowly to 0 towards 2c, where TLS cuts at c."""

wrong_open_threshold = change(right_minimum, "<=", "<", caught_by="rho_tls-knee")
"""Wrong at the threshold itself: drops the measurement at |u| = c."""

wrong_one_row_only = change(
    right_plain_loops, "[rho_tls(v, c)", "[min(v * v, c * c) / 2", caught_by="rho_tls-shapes"
)
"""Wrong for tables: compares row by row, as if u had one dimension."""
