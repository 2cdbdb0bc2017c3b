"""Answers to exercise gnc_gm_weight of 05-gnc: each body is a cell as handed in."""

import numpy as np
from robust_slam_autograder.lint.answers import change


def right_form() -> None:
    """Right: the square of μc²/(u² + μc²)."""

    def gnc_gm_weight(u, c, mu):
        u, scale = np.asarray(u, dtype=float), mu * c**2
        w = (scale / (u**2 + scale)) ** 2
        return w


def right_widened_kernel() -> None:
    """Right, an equivalent form: Geman and McClure's own weight with c√μ for c."""

    def gnc_gm_weight(u, c, mu):
        wide = c * np.sqrt(mu)
        return 1 / (1 + (np.asarray(u) / wide) ** 2) ** 2


def right_loop() -> None:
    """Right: plain Python, one number at a time, nested lists in and out."""

    def gnc_gm_weight(u, c, mu):
        if np.ndim(u) > 0:
            return [gnc_gm_weight(one, c, mu) for one in u]
        root = 1.0 / (1.0 + float(u) * float(u) / (mu * c * c))
        return root * root


def right_slope_over_u() -> None:
    """Right: ρ' by the quotient rule, divided by u, with the limit 1 at 0."""

    def gnc_gm_weight(u, c, mu):
        u = np.asarray(u, dtype=float)
        top, bottom = mu * c**2 * u**2, mu * c**2 + u**2
        slope = (2 * mu * c**2 * u * bottom - top * 2 * u) / bottom**2 / 2
        return np.where(u == 0, 1.0, slope / np.where(u == 0, 1.0, u))


wrong_without_the_square = change(
    right_form, "return w", "return np.sqrt(w)", stopped_by="gnc_gm_weight-by-hand"
)
"""Wrong: the root of the weight, as if it were Cauchy's."""

wrong_c_for_c_squared = change(right_form, "c**2", "c", stopped_by="gnc_gm_weight-scale")
"""Wrong for c other than 1: compares u² with μ c."""

wrong_way_of_mu = change(right_form, "mu * c**2", "c**2 / mu", stopped_by="gnc_gm_weight-mu")
"""Wrong: divides c² by μ, so that a large μ is hard."""

wrong_mu_squared = change(right_form, "mu * c**2", "(mu * c) ** 2", caught_by="gnc_gm_weight-mu")
"""Wrong: μ c for the scale, so μ comes in squared."""

wrong_misprint_surrogate = change(
    right_form, "mu * c**2", "(mu + 1) * c**2", stopped_by="gnc_gm_weight-by-hand"
)
"""Wrong: (μ+1)c² for μc², as in the lesson's surrogate."""

wrong_cut_off = change(
    right_form, "return w", "return np.where(w < 0.1, 0.0, w)", caught_by="gnc_gm_weight-scale"
)
"""Wrong: sets weights below a tenth to 0, though this cost rejects no measurement."""

wrong_one_sided = change(
    right_form, "return w", "return np.where(u < 0, 1.0, w)", stopped_by="gnc_gm_weight-derivative"
)
"""Wrong left of zero: a negative residual has the weight 1."""

wrong_flat_shape = change(
    right_form, "return w", "return w.ravel() if w.ndim else w", caught_by="gnc_gm_weight-shapes"
)
"""Wrong for arrays of two dimensions: returns one flat row."""
