"""Iteratively reweighted least squares: the loop with a fixed kernel.

Residual norms and weights are ``(k,)``, one for each untrusted measurement.

Source: Holland and Welsch 1977, iteratively reweighted least squares.
"""

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
from robust_slam.estimators.thresholds import dimension_of, threshold_of
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

    ``kernel`` is one with its scale, or the name or constructor of one: "squared", "huber",
    "cauchy", "geman-mcclure", "tls", "dcs", "welsch", or SciPy's "linear", "soft_l1" and "arctan".
    Its scale is then ``c``, by default the norm that an inlier does not exceed with
    ``probability``. In its place ``loss`` may be one of ``scipy.optimize.least_squares``, with
    ``c`` as its f_scale: a function of z = (u/c)² that returns the rows ρ, ρ' and ρ''.

    A pose graph starts at dead reckoning instead, or where the odometry has gaps along a tree of
    edges, and takes one Gauss–Newton step for each weighting; its ``trusted`` edges ``(m,)``, by
    default the odometry, keep the weight 1. A residual u has settled when its change, relative to
    1 + u, is at most ``tol``, by default 1e-6 on a pose graph and else 1e-12. After
    ``max_seconds`` of CPU time it stops with TIME_LIMIT.

    The robust cost never increases, but the result depends on the start: a non-convex
    kernel has several stationary points.

    Raises:
        TypeError: ``problem`` is no problem and no pose graph, ``kernel`` no kernel and no loss.
        ValueError: there is no kernel of that name, ``c`` is not above 0, the residuals at the
            start are not finite, or a limit is out of range.
        Underdetermined: the plain least-squares solution does not exist.

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
    >>> own = lambda z: [np.log1p(z), 1.0 / (1.0 + z)]  # as SciPy's cauchy
    >>> round(irls(LocationProblem([0.0, 0.1, -0.1, 5.0]), loss=own, c=1.0, x0=0.0).x, 3)
    0.066
    """
    if (kernel is None) == (loss is None):
        raise TypeError("give either a kernel, such as 'cauchy', or a loss as SciPy takes it")
    if isinstance(x0, int | float) and dimension_of(problem) > 1:
        raise TypeError(f"x0 is {x0}; give poses to start from; the scale is c={x0}")
    scale = threshold_of(problem, probability) if c is None else c
    given = as_kernel(kernel or loss, scale, "kernel" if loss is None else "loss")  # type: ignore[arg-type]  # one is there
    return reweight(
        problem,
        IrlsRule(given),
        x0,
        trusted=trusted,
        tol=tol,
        max_iterations=max_iterations,
        max_seconds=max_seconds,
    )
