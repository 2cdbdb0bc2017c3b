"""Iteratively reweighted least squares: the loop with a fixed kernel.

Residual norms and weights are ``(k,)``, one for each untrusted measurement.

Source: Holland and Welsch 1977, iteratively reweighted least squares.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import inf
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike

from robust_slam._arrays import Array
from robust_slam.estimators.kernels import Kernel, Loss, as_kernel
from robust_slam.estimators.loop import Problem, Stateless, reweight
from robust_slam.estimators.result import Result
from robust_slam.estimators.thresholds import threshold_of
from robust_slam.graphs.pose_graph import PoseGraph

X = TypeVar("X")


@dataclass(frozen=True)
class IrlsRule(Stateless):
    """The rule of a fixed kernel: the weight is ψ(u)/u."""

    kernel: Kernel

    def weights(self, norms: Array, state: None) -> Array:
        """Return ψ(u)/u."""
        return self.kernel.weight(norms)

    def cost(self, norms: Array) -> float:
        """Return Σ ρ(u)."""
        return float(np.sum(self.kernel.rho(norms)))


def irls(
    problem: Problem[X] | PoseGraph,
    kernel: Kernel | str | Callable[..., object] | None = None,
    x0: X | None = None,
    *,
    loss: str | Loss | None = None,
    c: float | None = None,
    trusted: ArrayLike | None = None,
    probability: float = 0.99,
    tol: float | None = None,
    max_iterations: int = 100,
    max_seconds: float = inf,
) -> Result[X]:
    """Minimise Σ ρ(u) by reweighting, from ``x0`` or from plain least squares.

    ``kernel`` is one with its scale, or the name or constructor of one, such as "huber"; its scale
    is then ``c``, by default the norm that an inlier does not exceed with ``probability``. In its
    place ``loss`` may be one of ``scipy.optimize.least_squares``, with ``c`` as its f_scale: a
    function of z = (u/c)² that returns the rows ρ, ρ' and ρ''.

    ``problem`` may be a pose graph: see ``loop.prepare`` for its start and tolerance, and for the
    edges that are ``trusted``. For a problem ``tol`` is 1e-12 by default. ``max_seconds`` is that
    of ``loop.reweight``.

    The robust cost never increases, but the result depends on the start: a non-convex
    kernel has several stationary points.

    Raises:
        TypeError: ``kernel`` is neither a kernel, such as ``kernels.cauchy(1.0)``, nor a loss, or
            both are given.
        ValueError: there is no kernel of that name, ``c`` is not above 0, or as
            ``loop.reweight``.

    Source: Holland and Welsch 1977; SLAM Handbook 2026, (3.12) for the weight, without the ½ of
    ρ here.

    >>> from robust_slam.estimators import kernels
    >>> from robust_slam.problems import LocationProblem
    >>> result = irls(LocationProblem([0.0, 0.1, -0.1, 5.0]), kernels.cauchy(1.0), x0=0.0)
    >>> round(result.x, 3), result.weights.round(3)
    (0.066, array([0.996, 0.999, 0.973, 0.039]))
    >>> soft = irls(LocationProblem([0.0, 0.1, -0.1, 5.0]), "huber", x0=0.0)
    >>> round(soft.x, 3)
    0.859
    """
    if (kernel is None) == (loss is None):
        raise TypeError("give either a kernel, such as 'cauchy', or a loss as SciPy takes it")
    scale = threshold_of(problem, probability) if c is None else c
    rule = IrlsRule(as_kernel(kernel or loss, scale))  # type: ignore[arg-type]  # one is there
    return reweight(
        problem,
        rule,
        x0,
        trusted=trusted,
        tol=tol,
        max_iterations=max_iterations,
        max_seconds=max_seconds,
    )
