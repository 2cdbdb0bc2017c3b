"""What Gauss–Newton and Levenberg–Marquardt share: linearisation, limits and retraction.

Source: Dennis and Schnabel 1983; Nielsen 1999 for the damping.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from robust_slam._arrays import Array, times
from robust_slam.errors import NotConverged
from robust_slam.graphs import pose_graph
from robust_slam.graphs.pose_graph import PoseGraph

ROUNDING = 1e-12
"""A relative increase of the cost that counts as rounding."""
NEGLIGIBLE_COST = 1e-18
"""A cost below this counts as 0."""
STEP_LIMIT = 500
"""Gross errors make Gauss–Newton slow: in trials with wrong closures up to 203 steps."""


@dataclass(frozen=True, eq=False)
class Residuals:
    """The residuals of ``graph`` at ``poses`` ``(n, …)``, each part when it is first used."""

    graph: PoseGraph
    poses: Array

    @cached_property
    def relative(self) -> Array:
        """The ``pose_graph.relative_poses``, ``(m, 3)`` or ``(m, 3, 4)``."""
        return pose_graph.relative_poses(self.graph, self.poses)

    @cached_property
    def r(self) -> Array:
        """The residuals r ``(m, D)``, not whitened."""
        return pose_graph.residuals_of(self.graph, self.relative)

    @cached_property
    def applied(self) -> Array:
        """The products Ω r ``(m, D)``."""
        return times(self.graph.information, self.r)

    @cached_property
    def norms(self) -> Array:
        """The whitened residual norms u ``(m,)``."""
        squared = np.sum(self.r * self.applied, axis=1)
        return np.asarray(np.sqrt(np.maximum(squared, 0.0)))


@dataclass(frozen=True, eq=False)
class Linearisation:
    """Weighted least squares at given poses: ``residuals``, and their ``weights`` ``(m,)``."""

    residuals: Residuals
    weights: Array

    @property
    def poses(self) -> Array:
        """The poses, ``(n, 3)`` or ``(n, 3, 4)``."""
        return self.residuals.poses

    @cached_property
    def cost(self) -> float:
        """The cost ½ Σ w rᵀ Ω r."""
        return 0.5 * float(np.sum(self.residuals.r * self.weighted_residuals))

    @cached_property
    def weighted_residuals(self) -> Array:
        """The w Ω r ``(m, D)``."""
        return np.asarray(self.weights[:, None] * self.residuals.applied)


@dataclass(frozen=True, eq=False)
class Descent:
    """Where a descent ended: poses, cost, size of the last step, and whether it converged."""

    poses: Array
    cost: float
    step: float
    converged: bool

    def converged_poses(self, max_iterations: int) -> Array:
        """Return the poses, ``(n, 3)`` or ``(n, 3, 4)``.

        Raises:
            NotConverged: the descent did not converge.
        """
        if not self.converged:
            raise NotConverged(
                f"after {max_iterations} steps the cost is {self.cost:.6g} and the last step "
                f"{self.step:.2g}; start from better poses, allow more steps or loosen tol"
            )
        return self.poses


def retract(graph: PoseGraph, poses: Array, step: Array) -> Array:
    """Return each pose ∘ Exp(δ), with δ its row of ``step`` ``(n, D)``."""
    return graph.group.compose(poses, graph.group.exp(step))


def increases(cost: float, before: float) -> bool:
    """Tell whether ``cost`` is higher than the one ``before`` by more than rounding.

    A cost has no unit; below ``NEGLIGIBLE_COST`` it is rounding alone.
    """
    return cost > before * (1.0 + ROUNDING) + NEGLIGIBLE_COST


def is_small(step: Array, poses: Array, tol: float) -> bool:
    """Tell whether a step moves positions by at most tol·(1 m + extent), rotations by tol.

    ``step`` is ``(n, D)`` in m and rad, ``poses`` ``(n, 3)`` or ``(n, 3, 4)``; the extent is
    the map's longest side. The rounding of coordinates is allowed on top: a map that is far
    from the origin cannot be computed more precisely.
    """
    position = poses[:, :2] if poses.ndim == 2 else poses[:, :, 3]
    moved, turned = np.split(np.abs(step), [position.shape[1]], axis=1)
    rounding = 4.0 * np.finfo(float).eps * float(np.abs(position).max())
    extent = float(np.ptp(position, axis=0).max())
    return bool(moved.max() <= tol * (1.0 + extent) + rounding and turned.max() <= tol + rounding)


def damping_factor(gain_ratio: float) -> float:
    """Return the factor on the damping after an accepted step, from 1/3 to 2.

    ``gain_ratio`` is the decrease of the cost over the decrease of the linearised cost.

    Source: Nielsen 1999, "Damping parameter in Marquardt's method", the continuous update.
    """
    return max(1.0 / 3.0, 1.0 - (2.0 * min(max(gain_ratio, 0.0), 1.0) - 1.0) ** 3)


def check_limits(tol: float, max_iterations: int) -> None:
    """Check when a descent may stop.

    Raises:
        ValueError: ``tol`` is negative, or ``max_iterations`` is below 1.
    """
    if not tol >= 0.0:
        raise ValueError(f"tol is {tol}; give a number of at least 0")
    if max_iterations < 1:
        raise ValueError(f"max_iterations is {max_iterations}; give at least 1")
