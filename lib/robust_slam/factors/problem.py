"""A factor graph for the loop, with a threshold for each factor.

Factors of different kinds have residuals of different dimensions, so an inlier's norm u has
another threshold ε in each: 3.04 for a point in the plane, 3.37 for a pose there. Rules and
kernels have one scale c for all. Here the norms that a rule sees are therefore v = c u/ε, where c
is ``threshold``, that of a pose: each factor then passes its own threshold where v passes c. The
solve still minimises Σ w u². As ρ_c(u) = c² ρ₁(u/c) for all kernels of the library, what is
minimised is Σ ρ_ε(u): each factor has its kernel with its own scale.

Source: Antonante et al. 2022, for the threshold; one for each factor is derived here.
"""

import numpy as np
from numpy.typing import ArrayLike

from robust_slam._arrays import Array, finite, mask, refuse
from robust_slam._words import counted
from robust_slam.descent.step import ELSEWHERE, STEP_LIMIT, check_limits
from robust_slam.estimators.thresholds import chi_square_threshold
from robust_slam.factors.equations import FactorEquations, descend
from robust_slam.factors.factor_graph import FactorGraph, as_factor_graph, check_map
from robust_slam.factors.start import first_map
from robust_slam.graphs.pose_graph import PoseGraph

_PROBABILITY = 0.99


def thresholds_of(graph: FactorGraph, probability: float = _PROBABILITY) -> Array:
    """Return the norms ``(m,)`` that inliers of the factors do not exceed with ``probability``."""
    largest = int(graph.dimensions.max())
    each = [chi_square_threshold(probability, d) for d in range(1, largest + 1)]
    return np.array(each)[graph.dimensions - 1]


class FactorGraphProblem:
    """A factor graph for the loop; x is a map ``(n + l, …)``, poses first and then landmarks.

    ``irls``, ``gnc``, ``dcs``, ``switchable`` and ``max_mixture`` take it as any other problem.
    The unweighted solve starts at the map ``guess``, by default as ``solve_factors``. ``trusted``
    ``(m,)`` is the mask of factors whose weight stays 1, by default odometry and priors.
    ``thresholds`` ``(m,)`` tell for each factor the norm u from which on it may be an outlier; by
    default an inlier exceeds it with probability 0.01. They hold with the default c of an
    estimator, which is ``threshold``; another c multiplies them all by c/``threshold``.

    ``graph`` may be a pose graph, to give each edge a threshold of its own. ``tol`` and ``steps``
    are those of ``PoseGraphProblem``.

    The ``cost`` of a result is Σ ρ(v), with ½ u² for a trusted factor. It is what is minimised
    only where all thresholds are equal, and may rise where they are not.

    Raises:
        TypeError: ``graph`` is neither a factor graph nor a pose graph.
        ValueError: ``guess``, ``trusted`` or ``thresholds`` do not fit the graph, a threshold is
            not above 0, or a limit is out of range.

    >>> from robust_slam.estimators import gnc
    >>> from robust_slam.factors import park
    >>> graph, truth, is_wrong = park(100, 1)
    >>> problem = FactorGraphProblem(graph, steps=1)
    >>> result = gnc(problem, x0=problem.guess)
    >>> int(is_wrong.sum()), int((result.kept & is_wrong).sum())
    (50, 0)
    """

    def __init__(
        self,
        graph: FactorGraph | PoseGraph,
        guess: ArrayLike | None = None,
        trusted: ArrayLike | None = None,
        thresholds: ArrayLike | None = None,
        *,
        tol: float = 1e-9,
        steps: int = 100,
    ) -> None:
        self.graph = as_factor_graph(graph)
        m = len(self.graph.ends)
        self.trusted = mask("trusted", self.graph.is_trusted if trusted is None else trusted, m)
        given = thresholds_of(self.graph) if thresholds is None else thresholds
        self.thresholds = finite("thresholds", given, (m,))
        refuse(self.thresholds <= 0.0, lambda k: f"thresholds: entry {k} is not above 0")
        check_limits(tol, steps)
        self.tol = tol
        self.steps = steps
        self.dimension = self.graph.group.DOF
        self.threshold = chi_square_threshold(_PROBABILITY, self.dimension)
        self._unit = np.where(self.trusted, 1.0, self.threshold / self.thresholds)
        self._equations = FactorEquations(self.graph)
        start = first_map(self.graph) if guess is None else guess
        self.guess = check_map("guess", start, self.graph)

    def __repr__(self) -> str:
        factors = counted(self.trusted.size, "factor")
        nodes = f"{self.graph.n:,} poses, {counted(self.graph.landmarks, 'landmark')}"
        trusted = f"{int(self.trusted.sum()):,} of them trusted"
        return f"<FactorGraphProblem: {nodes}, {factors}, {trusted}>"

    def initial(self) -> Array:
        """Return the least-squares map ``(n + l, …)``, found from the guess with all weights 1.

        Raises:
            NotConverged: as many steps as ``gauss_newton`` takes were not enough.
        """
        ones = np.ones(self.trusted.size)
        descent = descend(self._equations, self.guess, ones, self.tol, STEP_LIMIT)
        return descent.converged_poses(STEP_LIMIT, ELSEWHERE)

    def residual_norms(self, x: Array) -> Array:
        """Return the norm of each factor in units of ``thresholds``/``threshold``, ``(m,)``."""
        return np.asarray(self._unit * self._equations.norms(np.asarray(x)))

    def solve(self, weights: Array, x: Array) -> Array:
        """Return the map ``(n + l, …)`` that is reached from ``x`` with weights ``(m,)``.

        Factors of positive weight that do not connect all poses are Underdetermined.
        """
        return descend(self._equations, x, weights, self.tol, self.steps).here.poses
