"""Which of two sets of kept factors the measurements support more.

It is the evidence of ``solver.evidence`` with factors of all kinds: the probability of all
measurements if the kept factors are right, over all maps, and the others are outliers, which
measure anything that their kind measures. A landmark may be anywhere among them as well, so one
sighting of it alone is no evidence.

Source: Laplace 1774, as in MacKay 2003, chapter 28, for the integral over the maps; the densities
of an outlier and of a landmark are derived here.
"""

import numpy as np

from robust_slam._arrays import Array, Mask
from robust_slam.factors.equations import FactorEquations
from robust_slam.factors.factor_graph import Block, FactorGraph
from robust_slam.factors.models import RELATIVE
from robust_slam.solver.evidence import gaussian_entropy, outlier_entropy

_LEAST = 1e-3
"""The spread of what is measured is at least this (m); it matters for a few equal numbers."""


def evidence(equations: FactorEquations, x: Array, kept: Mask) -> float:
    """Return the log-evidence (nats) that the ``kept`` factors ``(m,)`` are the right ones.

    It is relative to all factors being outliers, up to a constant of the graph. The map x
    ``(n + l, …)`` is a minimum.
    """
    graph = equations.graph
    # The sum of logarithms is ½ log |Ω|.
    gains = [
        _entropy(graph, block) + np.log(np.diagonal(block.root, axis1=1, axis2=2)).sum(axis=1)
        for block in graph.blocks
    ]
    gain = np.concatenate(gains) - 0.5 * np.log(2.0 * np.pi) * graph.dimensions
    spent = float(np.sum(equations.norms(x)[kept] ** 2)) + _log_determinant(equations, x, kept)
    return float(np.sum(gain[kept])) - 0.5 * spent - _anywhere(graph, x, kept)


def _entropy(graph: FactorGraph, block: Block) -> float:
    """Return the entropy of an outlier of one kind, in nats."""
    if block.name == "relative":
        return outlier_entropy(graph.relative)
    if block.model is RELATIVE:
        any_turn = np.log(2.0 * np.pi if graph.group.DIMENSION == 2 else 8.0 * np.pi**2)
        return _gaussian(graph.group.translation(block.measurement)) + float(any_turn)
    return _gaussian(block.measurement)


def _gaussian(points: Array) -> float:
    """Return the entropy of a Gaussian with the spread of the points ``(k, d)``."""
    d = points.shape[1]
    return gaussian_entropy(np.cov(points.T, ddof=0).reshape(d, d), _LEAST**2)


def _anywhere(graph: FactorGraph, x: Array, kept: Mask) -> float:
    """Return what the places of the landmarks of ``kept`` factors cost, in nats."""
    reached = np.unique(graph.ends[kept])
    count = int(np.sum(reached >= graph.n))
    seen = [block.measurement for block in graph.blocks if block.name == "points"]
    place = _gaussian(seen[0] if seen else graph.group.translation(x))
    return count * (place - 0.5 * graph.group.DIMENSION * float(np.log(2.0 * np.pi)))


def _log_determinant(equations: FactorEquations, x: Array, kept: Mask) -> float:
    """Return log |H| of the ``kept`` factors, or infinity: such a map has no evidence."""
    weights = kept.astype(np.float64)
    hessian, _ = equations.system(x, weights)
    factors = equations.pattern.factorise(hessian, equations.shift(hessian, weights))
    return np.inf if factors is None else float(np.sum(np.log(factors.pivots[1:])))
