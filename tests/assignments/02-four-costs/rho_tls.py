"""Answers to exercise rho_tls of 02-four-costs: each body is a cell as handed in."""

from robust_slam_autograder.lint.answers import change


def right_minimum() -> None:
    """Right: the smaller of two squares, halved."""
    import numpy as np

    def rho_tls(u, c):
        return np.minimum(np.square(u), c**2) / 2

    def w_tls(u, c):
        return np.where(np.abs(u) <= c, 1, 0)


def right_without_half() -> None:
    """Right on the lesson's scale: no ½ in either piece; the weight as a truth value."""
    import numpy as np

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
    import numpy as np

    def rho_tls(u, c):
        return np.clip(u, -c, c) ** 2 / 2

    def w_tls(u, c):
        return np.heaviside(c - np.abs(u), 1.0)


def right_masks() -> None:
    """Right: boolean masks on a float copy, any shape."""
    import numpy as np

    def rho_tls(u, c):
        cost = np.array(u, dtype=float) ** 2 / 2
        return np.where(cost > c**2 / 2, c**2 / 2, cost)

    def w_tls(u, c):
        weight = np.ones(np.shape(u))
        weight[np.square(u) > c * c] = 0.0
        return weight


def wrong_sign() -> None:
    """Wrong left of zero: u ≤ c without the absolute value keeps every large negative residual.
    Caught by rho_tls-negative.
    """
    import numpy as np

    def rho_tls(u, c):
        u = np.asarray(u, dtype=float)
        return np.where(u <= c, u**2, c**2) / 2

    def w_tls(u, c):
        return np.where(np.asarray(u) <= c, 1.0, 0.0)


def wrong_misprint() -> None:
    """Wrong: the lesson's line as it is printed, u² if u ≤ c, on its scale and without the
    absolute value. Caught by rho_tls-negative.
    """
    import numpy as np

    def rho_tls(u, c):
        u = np.asarray(u, dtype=float)
        return np.where(u <= c, u**2, c**2)

    def w_tls(u, c):
        return np.where(np.asarray(u) <= c, 1.0, 0.0)


wrong_threshold_not_squared = change(
    right_without_half,
    ("return np.minimum(np.square(u), c**2)", "return np.minimum(np.square(u), c) / 2"),
    ("return np.abs(u) <= c", "return np.where(np.abs(u) <= c, 1.0, 0.0)"),
    caught_by="rho_tls-cost",
)
"""Wrong for c other than 1: caps the cost at c where it should be c²."""

wrong_half_on_one_piece = change(
    right_without_half,
    ("np.minimum(np.square(u), c**2)", "np.where(np.abs(u) <= c, np.square(u) / 2, c**2)"),
    ("return np.abs(u) <= c", "return np.where(np.abs(u) <= c, 1.0, 0.0)"),
    stopped_by="rho_tls-by-hand",
)
"""Wrong: the ½ stands on the inner piece only, so the cost jumps at c."""

wrong_weight_two = change(
    right_without_half,
    "np.abs(u) <= c",
    "np.where(np.abs(u) <= c, 2.0, 0.0)",
    stopped_by="rho_tls-by-hand",
)
"""Wrong weight: ρ'/u of the cost without the ½, which is 2 at 0."""

wrong_soft_weight = change(
    right_minimum,
    "np.where(np.abs(u) <= c, 1, 0)",
    "np.clip(2 - np.abs(u) / c, 0.0, 1.0)",
    caught_by="rho_tls-weight",
)
"""Wrong weight: lets it fall slowly to 0 towards 2c, where TLS cuts at c."""

wrong_open_threshold = change(
    right_minimum,
    "np.where(np.abs(u) <= c, 1, 0)",
    "np.where(np.abs(u) < c, 1.0, 0.0)",
    caught_by="rho_tls-knee",
)
"""Wrong at the threshold itself: drops the measurement at |u| = c."""


def wrong_one_row_only() -> None:
    """Wrong for tables: compares row by row, as if u had one dimension. Caught by
    rho_tls-shapes.
    """

    def rho_tls(u, c):
        if hasattr(u, "__len__"):
            return [min(v * v, c * c) / 2 for v in u]
        return min(u * u, c * c) / 2

    def w_tls(u, c):
        if hasattr(u, "__len__"):
            return [1.0 if abs(v) <= c else 0.0 for v in u]
        return 1.0 if abs(u) <= c else 0.0
