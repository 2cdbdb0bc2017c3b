"""Max-mixtures: a measurement has two modes, and the more likely one counts.

The density is p(z|x) ∝ max_i π_i N(μ, Λ_i⁻¹) in place of the sum of the modes, so the cost
of an edge is, up to a constant, min_i [½ eᵀ Λ_i e − log(π_i |Λ_i|^½)], with e its residual.
The logarithm is the normaliser of the mode: without it a broad mode would always win. Here
the constant is such that the inlier mode costs 0 at zero residual; the outlier mode then
costs at least log(π_in |Λ_in|^½) − log(π_out |Λ_out|^½), which may be negative.

The maximum keeps the problem a least-squares problem: once the modes are chosen, every
cost is quadratic in the residual. The logarithm of a sum of modes is not.

Source: Olson and Agarwal 2013, "Inference on networks of mixtures for robust robot
mapping", the max-mixture density and its null hypothesis, two modes with the same mean.
"""

from dataclasses import dataclass
from math import log, sqrt
from typing import TypeVar

import numpy as np

from robust_slam._arrays import Array, positive
from robust_slam.estimators.loop import Problem, Stateless, reweight
from robust_slam.estimators.result import Result
from robust_slam.estimators.thresholds import dimension_of
from robust_slam.graphs.pose_graph import PoseGraph

X = TypeVar("X")


@dataclass(frozen=True)
class NullHypothesis(Stateless):
    """The rule for two modes with the same mean: a narrow inlier and a broad outlier mode.

    The inlier mode has the probability ``pi_in`` and the deviations that whiten u; the
    outlier mode has the rest, and deviations ``ratio`` times as large. ``dimension`` is
    that of the residual: 1 for a number, 3 in SE(2), 6 in SE(3). Each edge costs
    min(u²/2, u²/(2 ratio²) + offset) and weighs 1 or 1/ratio².

    Raises:
        ValueError: ``pi_in`` is not inside (0, 1), ``ratio`` is not above 1, or
            ``dimension`` is below 1.

    Source: Olson and Agarwal 2013, the null-hypothesis mixture.
    """

    pi_in: float
    ratio: float
    dimension: int

    def __post_init__(self) -> None:
        if not 0.0 < self.pi_in < 1.0:
            raise ValueError(f"pi_in is {self.pi_in}; give a probability inside (0, 1)")
        if not positive("ratio", self.ratio) > 1.0:
            raise ValueError(f"ratio is {self.ratio}; outliers spread wider, so give more than 1")
        if self.dimension != int(self.dimension) or self.dimension < 1:
            raise ValueError(f"dimension is {self.dimension}; give a whole number of at least 1")

    @property
    def offset(self) -> float:
        """The cost of the outlier mode at u = 0: log(π_in ratio^D / π_out), maybe negative.

        Source: derived here; |Λ|^½ of the outlier mode is that of the inlier mode divided
        by ratio^D.
        """
        return log(self.pi_in / (1.0 - self.pi_in)) + self.dimension * log(self.ratio)

    @property
    def switch_norm(self) -> float:
        """The norm u beyond which the outlier mode wins; 0 when it wins everywhere.

        Source: derived here; u²/2 = u²/(2 ratio²) + offset.
        """
        return sqrt(max(0.0, 2.0 * self.offset / (1.0 - self.ratio**-2)))

    def weights(self, norms: Array, state: None) -> Array:
        """Return ``(k,)`` weights: 1 where the inlier mode costs least, 1/ratio² elsewhere."""
        inlier, outlier = self._costs(norms)
        return np.where(inlier <= outlier, 1.0, self.ratio**-2)

    def cost(self, norms: Array) -> float:
        """Return Σ min(u²/2, u²/(2 ratio²) + offset) over the norms ``(k,)``."""
        return float(np.sum(np.minimum(*self._costs(norms))))

    def _costs(self, norms: Array) -> tuple[Array, Array]:
        inlier = 0.5 * np.asarray(norms) ** 2
        return inlier, inlier / self.ratio**2 + self.offset


def max_mixture(
    problem: Problem[X] | PoseGraph,
    pi_in: float,
    ratio: float,
    dimension: int | None = None,
    x0: X | None = None,
    *,
    tol: float | None = None,
    max_iterations: int = 100,
) -> Result[X]:
    """Minimise the cost of the null hypothesis, from ``x0`` or from plain least squares.

    The arguments are those of ``NullHypothesis``; ``dimension`` is by default that of the pose
    graph, and 1 where there is none. A pose graph starts at dead reckoning, as in ``irls``. A
    weight of 1/ratio² marks a measurement that the outlier mode explains better. No measurement is
    rejected completely: a residual u keeps the influence of an inlier with u/ratio², so take a
    ratio of at least the largest expected u. On a pose graph that is the largest norm at the
    start, ``residual_norms(graph, spanning_tree(graph)).max()``.

    Raises:
        ValueError: as ``NullHypothesis`` and ``irls``, or ``dimension`` is not that of the graph.

    Source: Olson and Agarwal 2013, the null-hypothesis mixture.

    >>> from robust_slam.problems import LocationProblem
    >>> result = max_mixture(LocationProblem([0.0, 0.1, 5.0]), 0.9, 100.0, 1, x0=0.0)
    >>> result.weights.round(4).tolist()
    [1.0, 1.0, 0.0001]
    """
    own = dimension_of(problem)
    if own > 1 and dimension not in (None, own):
        raise ValueError(f"dimension is {dimension}; residuals of this graph have {own}")
    rule = NullHypothesis(pi_in, ratio, own if dimension is None else dimension)
    return reweight(problem, rule, x0, tol=tol, max_iterations=max_iterations)
