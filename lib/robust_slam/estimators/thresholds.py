"""The threshold on a residual norm, from how likely an inlier is to pass it."""

from __future__ import annotations

from math import sqrt

from scipy.stats import chi2


def chi_square_threshold(probability: float, dimension: int) -> float:
    """Return the norm that a whitened Gaussian residual stays below with ``probability``.

    It is the root of the χ² quantile, so it is compared with the norm u, not with u²:
    for 99 % 2.5758 in one dimension, 3.3682 in SE(2), 4.1002 in SE(3).

    Raises:
        ValueError: ``probability`` is not inside (0, 1), or ``dimension`` is below 1.

    Source: Antonante et al. 2022, who use it as ε.
    """
    if not 0.0 < probability < 1.0:
        raise ValueError(f"probability is {probability}; give a number inside (0, 1)")
    if dimension != int(dimension) or dimension < 1:
        raise ValueError(f"dimension is {dimension}; give a whole number of at least 1")
    return sqrt(float(chi2.ppf(probability, dimension)))
