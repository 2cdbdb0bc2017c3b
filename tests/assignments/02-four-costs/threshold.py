"""Answers to exercise threshold of 02-four-costs: each body is a cell as handed in."""

import numpy as np
from robust_slam_autograder.lint.answers import change


def right_chi2() -> None:
    """Right: the root of SciPy's χ² quantile."""
    from scipy.stats import chi2

    def threshold(p, d):
        return chi2.ppf(p, d) ** 0.5


def right_chi() -> None:
    """Right: the quantile of the χ distribution, which is that of the norm itself."""
    from scipy import stats

    def threshold(p, d):
        return float(stats.chi(d).ppf(p))


def right_gamma() -> None:
    """Right, an equivalent formula: the inverse of the incomplete gamma function."""
    from scipy.special import gammaincinv

    def threshold(p, d):
        return np.sqrt(2 * gammaincinv(d / 2, p))


def right_root() -> None:
    """Right: the distribution function of χ², solved for the norm by a root finder."""
    from scipy.optimize import brentq
    from scipy.stats import chi2

    def threshold(p, d):
        return brentq(lambda c: chi2.cdf(c * c, d) - p, 0, 50, xtol=1e-13)


wrong_square = change(right_chi2, " ** 0.5", "", stopped_by="threshold-by-hand")
"""Wrong: the χ² quantile itself, a threshold on the square of the norm."""

wrong_half_square = change(right_chi2, "** 0.5", "/ 2", caught_by="threshold-scalar")
"""Wrong: half the χ² quantile, a threshold on the cost u²/2."""

wrong_one_tail = change(
    right_chi2, "(p, d) **", "(2 * p - 1 if d == 1 else p, d) **", caught_by="threshold-scalar"
)
"""Wrong in one dimension: the normal quantile at p leaves out the negative tail."""

wrong_space_as_plane = change(
    right_chi2, "d) ** 0.5", "min(d, 3)) ** 0.5 + 1e-9 * d", caught_by="threshold-poses"
)
"""Wrong in space: counts three components for every pose."""

wrong_by_heart = change(
    right_chi2,
    "d) ** 0.5",
    "min((1, 2, 3, 6), key=lambda n: abs(n - d))) ** 0.5 + 1e-12 * d",
    caught_by="threshold-other",
)
"""Wrong for other p and d: knows four dimensions by heart and takes the nearest."""

wrong_other_end = change(right_chi2, "ppf", "isf", stopped_by="threshold-by-hand")
"""Wrong: the norm that is exceeded with probability p."""

wrong_root_below_ten = change(right_root, "0, 50", "0, 10", caught_by="threshold-other")
"""Wrong for many dimensions: looks for the threshold between 0 and 10."""
