"""Answers to exercise max_mixture_mode of 06-switches-and-consistency: each body is a cell."""

import numpy as np
from robust_slam_autograder.lint.answers import change


def right_logs() -> None:
    """Right: the two log densities over whole arrays."""

    def max_mixture_mode(r, sigma_in, sigma_out, pi_in):
        r = np.asarray(r, dtype=float)
        inner = np.log(pi_in / sigma_in) - (r / sigma_in) ** 2 / 2
        outer = np.log((1 - pi_in) / sigma_out) - (r / sigma_out) ** 2 / 2
        return np.where(outer > inner, 1, 0)


def right_densities() -> None:
    """Right, a library routine: SciPy's normal densities, and the larger of the two."""
    from scipy.stats import norm

    def max_mixture_mode(r, sigma_in, sigma_out, pi_in):
        modes = [
            norm.logpdf(r, scale=sigma_in) + np.log(pi_in),
            norm.logpdf(r, scale=sigma_out) + np.log1p(-pi_in),
        ]
        return np.argmax(modes, axis=0)


def right_knee() -> None:
    """Right, an equivalent form: the residual where the mode switches, if there is one."""

    def max_mixture_mode(r, sigma_in, sigma_out, pi_in):
        log_ratio = np.log(pi_in * sigma_out / ((1 - pi_in) * sigma_in))
        square = 2 * log_ratio / (1 / sigma_in**2 - 1 / sigma_out**2)
        return np.where(np.square(r) > square, 1, 0)


def right_nested_lists() -> None:
    """Right: plain Python, true or false, lists in and lists out."""
    import math

    def max_mixture_mode(r, sigma_in, sigma_out, pi_in):
        if hasattr(r, "__len__"):
            return [max_mixture_mode(one, sigma_in, sigma_out, pi_in) for one in r]
        inlier = math.log(pi_in) - math.log(sigma_in) - 0.5 * (r / sigma_in) ** 2
        outlier = math.log(1 - pi_in) - math.log(sigma_out) - 0.5 * (r / sigma_out) ** 2
        return outlier > inlier


wrong_only_exponents = change(
    right_logs,
    "outer > inner",
    "abs(r) / sigma_out < abs(r) / sigma_in",
    stopped_by="max_mixture_mode-by-hand",
)
"""Wrong: compares the exponents alone, so that the broad mode always wins, 0 aside."""

wrong_no_normalisers = change(
    right_logs,
    ("pi_in / sigma_in", "pi_in"),
    ("(1 - pi_in) / sigma_out", "1 - pi_in"),
    caught_by="max_mixture_mode-switch",
)
"""Wrong: leaves out the factors 1/σ before the exponentials: it switches at 2.1069."""

wrong_flat_outliers = change(
    right_logs,
    "outer > inner",
    "(r / sigma_in) ** 2 / 2 > np.log(pi_in / (1 - pi_in))",
    caught_by="max_mixture_mode-switch",
)
"""Wrong: neither 1/σ nor the outlier's exponential: it switches at 2.0963."""

wrong_variances = change(
    right_logs,
    ("pi_in / sigma_in", "pi_in / sigma_in**2"),
    ("(1 - pi_in) / sigma_out", "(1 - pi_in) / sigma_out**2"),
    caught_by="max_mixture_mode-switch",
)
"""Wrong: divides by the variance σ² before the exponential, and not by σ."""

wrong_equal_chances = change(
    right_logs, "r = np.a", "pi_in = 0.5\nr = np.a", caught_by="max_mixture_mode-random"
)
"""Wrong: leaves the probabilities out, as if both modes were as likely."""

wrong_fixed_knee = change(
    right_logs, "outer > inner", "abs(r) > 3.01505 * sigma_in", caught_by="max_mixture_mode-random"
)
"""Wrong: knows the example's switch at 3.015 sigmas by heart."""

wrong_root_of_negative = change(
    right_knee,
    "np.square(r) > square",
    "np.abs(r) > (np.sqrt(square) if square > 0 else 8.5 * sigma_in)",
    caught_by="max_mixture_mode-everywhere",
)
"""Wrong when inliers are rare: the switch is the root of a negative number."""

wrong_sign = change(
    right_knee,
    "np.square(r) > square",
    "np.asarray(r) > np.sqrt(max(0.0, square))",
    caught_by="max_mixture_mode-signs",
)
"""Wrong for negative residuals: compares r, and not its size, with the switch."""
