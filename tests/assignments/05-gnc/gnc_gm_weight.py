"""Answers to exercise gnc_gm_weight of 05-gnc: each body is a cell as handed in."""

from robust_slam_autograder.lint.answers import change


def right_formula() -> None:
    """Right: the square of μc²/(u² + μc²)."""
    import numpy as np

    def gnc_gm_weight(u, c, mu):
        u = np.asarray(u, dtype=float)
        return (mu * c**2 / (u**2 + mu * c**2)) ** 2


def right_widened_kernel() -> None:
    """Right, an equivalent form: Geman and McClure's own weight with c√μ for c."""
    import numpy as np

    def gnc_gm_weight(u, c, mu):
        wide = c * np.sqrt(mu)
        return 1 / (1 + (np.asarray(u) / wide) ** 2) ** 2


def right_loop() -> None:
    """Right: plain Python, one number at a time, nested lists in and out."""
    import numpy as np

    def gnc_gm_weight(u, c, mu):
        if np.ndim(u) > 0:
            return [gnc_gm_weight(one, c, mu) for one in u]
        root = 1.0 / (1.0 + float(u) * float(u) / (mu * c * c))
        return root * root


def right_slope_over_u() -> None:
    """Right: ρ' by the quotient rule, divided by u, with the limit 1 at 0."""
    import numpy as np

    def gnc_gm_weight(u, c, mu):
        u = np.asarray(u, dtype=float)
        top, bottom = mu * c**2 * u**2, mu * c**2 + u**2
        slope = (2 * mu * c**2 * u * bottom - top * 2 * u) / bottom**2 / 2
        return np.where(u == 0, 1.0, slope / np.where(u == 0, 1.0, u))


def wrong_without_the_square() -> None:
    """Wrong: the root of the weight, as if it were Cauchy's. Stopped by the visible case
    gnc_gm_weight-by-hand.
    """
    import numpy as np

    def gnc_gm_weight(u, c, mu):
        return mu * c**2 / (np.asarray(u, dtype=float) ** 2 + mu * c**2)


def wrong_c_for_c_squared() -> None:
    """Wrong for c other than 1: compares u² with μ c. Stopped by the visible case
    gnc_gm_weight-scale.
    """
    import numpy as np

    def gnc_gm_weight(u, c, mu):
        return (mu * c / (np.asarray(u, dtype=float) ** 2 + mu * c)) ** 2


def wrong_way_of_mu() -> None:
    """Wrong: divides c² by μ, so that a large μ is hard. Stopped by the visible case
    gnc_gm_weight-mu.
    """
    import numpy as np

    def gnc_gm_weight(u, c, mu):
        return 1 / (1 + mu * (np.asarray(u, dtype=float) / c) ** 2) ** 2


def wrong_mu_squared() -> None:
    """Wrong: μ c for the scale, so μ comes in squared. Caught by gnc_gm_weight-mu."""
    import numpy as np

    def gnc_gm_weight(u, c, mu):
        return 1 / (1 + (np.asarray(u, dtype=float) / (c * mu)) ** 2) ** 2


def wrong_misprint_surrogate() -> None:
    """Wrong: (μ+1)c² stands for μc², as in the lesson's surrogate. Stopped by the visible case
    gnc_gm_weight-by-hand.
    """
    import numpy as np

    def gnc_gm_weight(u, c, mu):
        scale = (mu + 1) * c**2
        return (scale / (np.asarray(u, dtype=float) ** 2 + scale)) ** 2


def wrong_cut_off() -> None:
    """Wrong: sets weights below a tenth to 0, though this cost lets nobody go. Caught by
    gnc_gm_weight-scale.
    """
    import numpy as np

    def gnc_gm_weight(u, c, mu):
        weights = (mu * c**2 / (np.asarray(u, dtype=float) ** 2 + mu * c**2)) ** 2
        return np.where(weights < 0.1, 0.0, weights)


wrong_one_sided = change(
    right_formula,
    "(mu * c**2 / (u**2 + mu * c**2)) ** 2",
    "np.where(u < 0, 1.0, (mu * c**2 / (u**2 + mu * c**2)) ** 2)",
    stopped_by="gnc_gm_weight-derivative",
)
"""Wrong left of zero: a negative residual gets the weight of its square with its sign."""


def wrong_flat_shape() -> None:
    """Wrong for arrays of two dimensions: returns one flat row. Caught by gnc_gm_weight-shapes."""
    import numpy as np

    def gnc_gm_weight(u, c, mu):
        weights = (1 + np.asarray(u, dtype=float) ** 2 / (mu * c**2)) ** -2.0
        return weights.ravel() if weights.ndim else weights
