"""Answers to exercise rho_cauchy of 02-four-costs: each body is a cell as handed in."""

import numpy as np
from robust_slam_autograder.lint.answers import change


def right_array() -> None:
    """Right: the formulas as the chapter writes them."""

    def rho_cauchy(u, c):
        return c**2 / 2 * np.log1p(np.square(u) / c**2)

    def psi_cauchy(u, c):
        return np.asarray(u) / (1 + np.square(u) / c**2)

    def w_cauchy(u, c):
        return 1 / (1 + np.square(u) / c**2)


def right_plain_loops() -> None:
    """Right: the math module, one number at a time, nested lists for nested lists."""
    import math

    def cauchy_each(rule, u):
        try:
            return [cauchy_each(rule, item) for item in u]
        except TypeError:
            return rule(u)

    def rho_cauchy(u, c):
        return cauchy_each(lambda v: c * c / 2 * math.log1p((v / c) ** 2), u)

    def psi_cauchy(u, c):
        return cauchy_each(lambda v: v * c * c / (c * c + v * v), u)

    def w_cauchy(u, c):
        return cauchy_each(lambda v: c * c / (c * c + v * v), u)


def right_hypotenuse() -> None:
    """Right, an equivalent formula: c² times the log of the hypotenuse of 1 and u/c."""

    def w_cauchy(u, c):
        return np.cos(np.arctan(np.asarray(u) / c)) ** 2

    def psi_cauchy(u, c):
        return np.multiply(u, w_cauchy(u, c))

    def rho_cauchy(u, c):
        return c * c * np.log(np.hypot(1, np.asarray(u) / c))


def right_library() -> None:
    """Right: SciPy's negative log density of the Cauchy distribution, less its value at 0."""
    from scipy.stats import cauchy

    def rho_cauchy(u, c):
        t = np.asarray(u) / c
        return c**2 / 2 * (cauchy.logpdf(0) - cauchy.logpdf(t))

    def psi_cauchy(u, c):
        return np.asarray(u) * cauchy.pdf(np.asarray(u) / c) * np.pi

    def w_cauchy(u, c):
        return cauchy.pdf(np.asarray(u) / c) * np.pi


wrong_misprint = change(
    right_array,
    "c**2 / 2 * np.log1p(np.square(u) / c**2)",
    "c**2 * np.log1p(np.abs(u) / c)",
    stopped_by="rho_cauchy-by-hand",
)
"""Wrong: the lesson's 2.40 at u = 10 is ln(1 + u), without the square and without the ½."""

wrong_residual_not_squared = change(
    right_array, "log1p(np.square(u) / c**2)", "log1p(np.abs(u) / c)", caught_by="rho_cauchy-cost"
)
"""Wrong: takes the logarithm of 1 + |u|/c, which agrees with 1 + u²/c² at u = c alone."""

wrong_scale_missing = change(right_array, "c**2 / 2 *", "0.5 *", caught_by="rho_cauchy-cost")
"""Wrong for c other than 1: leaves out the c² before the logarithm."""

wrong_chain_rule = change(
    right_array, "np.asarray(u)", "c**2 * np.asarray(u)", caught_by="rho_cauchy-influence"
)
"""Wrong influence: forgets the inner derivative's 1/c², so that the c² does not cancel."""

wrong_weight_without_scale = change(
    right_array,
    "return 1 / (1 + np.square(u) / c**2)",
    "return 1 / (1 + np.square(u) / c)",
    stopped_by="rho_cauchy-weight",
)
"""Wrong weight for large c: compares u² with c where it should be c²."""

wrong_nan_at_zero = change(
    right_array,
    "return 1 / (1 + np.square(u) / c**2)",
    "return psi_cauchy(u, c) / np.asarray(u)",
    caught_by="rho_cauchy-weight",
)
"""Wrong weight at 0: divides the influence by u as it stands, 0/0."""

wrong_influence_without_sign = change(
    right_array, "np.asarray(u)", "np.abs(u)", caught_by="rho_cauchy-negative"
)
"""Wrong left of zero: takes |u| and loses the direction of the pull."""

wrong_lists = change(
    right_plain_loops, "cauchy_each(rule, item)", "rule(item)", caught_by="rho_cauchy-shapes"
)
"""Wrong for nested lists: goes through the outer list only."""
