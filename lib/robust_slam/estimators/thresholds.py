"""The threshold on a residual norm, from the probability that an inlier passes it."""

from math import sqrt

from scipy.special import gammaincinv

from robust_slam.graphs.pose_graph import PoseGraph


def chi_square_threshold(probability: float, dimension: int) -> float:
    """Return the norm that a whitened Gaussian residual exceeds with 1 − ``probability``.

    It is the square root of the χ² quantile, so it is compared with the norm u, not with
    u². ``dimension`` is that of the residual: 3 in SE(2), 6 in SE(3).

    Raises:
        ValueError: ``probability`` is not inside (0, 1), or ``dimension`` is below 1.

    Source: Antonante et al. 2022, where it is the inlier threshold ε.

    >>> [round(chi_square_threshold(0.99, d), 4) for d in (1, 3, 6)]
    [2.5758, 3.3682, 4.1002]
    """
    if not 0.0 < probability < 1.0:
        raise ValueError(f"probability is {probability}; give a number inside (0, 1)")
    if dimension != int(dimension) or dimension < 1:
        raise ValueError(f"dimension is {dimension}; give a whole number of at least 1")
    return sqrt(2.0 * float(gammaincinv(dimension / 2, probability)))


def threshold_of(problem: object, probability: float) -> float:
    """Return ``chi_square_threshold`` of the ``dimension_of`` a problem, or its error.

    Source: Antonante et al. 2022.
    """
    return chi_square_threshold(probability, dimension_of(problem))


def dimension_of(problem: object) -> int:
    """Return the dimension of the residuals: 3 or 6 on a pose graph, else 1 where not given.

    ``problem`` is on a pose graph if it is one or has one as ``graph``. Another problem may
    give its ``dimension``.

    Source: derived here.
    """
    graph = getattr(problem, "graph", problem)
    if isinstance(graph, PoseGraph):
        return graph.group.DOF
    return int(getattr(problem, "dimension", 1))
