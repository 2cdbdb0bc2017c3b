"""Answers to exercise threshold of 02-four-costs: each body is a cell as handed in."""

from robust_slam_autograder.lint.answers import change


def right_chi_square() -> None:
    """Right: the root of SciPy's χ² quantile."""
    from scipy.stats import chi2

    def threshold(p, d):
        return chi2.ppf(p, df=d) ** 0.5


def right_chi() -> None:
    """Right: the quantile of the χ distribution, which is that of the norm itself."""
    from scipy import stats

    def threshold(p, d):
        return float(stats.chi(d).ppf(p))


def right_gamma() -> None:
    """Right, an equivalent formula: the inverse of the incomplete gamma function."""
    import numpy as np
    from scipy.special import gammaincinv

    def threshold(p, d):
        return np.sqrt(2 * gammaincinv(d / 2, p))


def right_root() -> None:
    """Right: the distribution function of χ², solved for the norm by a root finder."""
    from scipy.optimize import brentq
    from scipy.stats import chi2

    def threshold(p, d):
        return brentq(lambda c: chi2.cdf(c * c, d) - p, 0, 50, xtol=1e-13)


wrong_square = change(
    right_chi_square, "chi2.ppf(p, df=d) ** 0.5", "chi2.ppf(p, d)", stopped_by="threshold-by-hand"
)
"""Wrong: the χ² quantile itself, a threshold on the square of the norm."""


def wrong_half_square() -> None:
    """Wrong: half the χ² quantile, a threshold on the cost u²/2, which equals the norm where the
    norm is 2. Caught by threshold-scalar.
    """
    from scipy.stats import chi2

    def threshold(p, d):
        return chi2.ppf(p, d) / 2


wrong_one_tail = change(
    right_chi,
    ("from scipy import stats", "from scipy.stats import chi2, norm"),
    ("float(stats.chi(d).ppf(p))", "norm.ppf(p) if d == 1 else chi2.ppf(p, d) ** 0.5"),
    caught_by="threshold-scalar",
)
"""Wrong in one dimension: the normal quantile at p leaves out the negative tail."""


def wrong_space_as_plane() -> None:
    """Wrong in space: counts three components for every pose. Caught by threshold-poses."""
    from scipy.stats import chi2

    def threshold(p, d):
        return chi2.ppf(p, min(d, 3)) ** 0.5 + 1e-9 * d


def wrong_by_heart() -> None:
    """Wrong for other p and d: three thresholds for 99 % known by heart, and for the rest the
    plane. Caught by threshold-other.
    """
    import math

    from scipy.stats import chi2

    def threshold(p, d):
        known = (1, 2, 3, 6)
        nearest = min(known, key=lambda n: abs(n - d))
        return math.sqrt(chi2.ppf(p, nearest)) + 1e-12 * d


wrong_other_end = change(
    right_chi_square, "chi2.ppf(p, df=d)", "chi2.isf(p, d)", stopped_by="threshold-by-hand"
)
"""Wrong: the norm that is exceeded with probability p."""

wrong_root_below_ten = change(
    right_root,
    "brentq(lambda c: chi2.cdf(c * c, d) - p, 0, 50, xtol=1e-13)",
    "brentq(lambda c: chi2.cdf(c * c, d) - p, 0, 10, xtol=1e-13)",
    caught_by="threshold-other",
)
"""Wrong for many dimensions: looks for the threshold between 0 and 10."""
