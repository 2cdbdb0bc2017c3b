"""What Gauss–Newton and Levenberg–Marquardt share: where they are, limits and retraction.

Source: Dennis and Schnabel 1983; Nielsen 1999 for the damping.
"""

from dataclasses import dataclass
from typing import Any, Generic, Protocol, Self, TypeVar

import numpy as np

from robust_slam._arrays import Array
from robust_slam.errors import NotConverged
from robust_slam.graphs.pose_graph import PoseGraph

ROUNDING = 1e-12
"""A relative increase of the cost that counts as rounding."""
NEGLIGIBLE_COST = 1e-18
"""A cost below this counts as 0."""
STEP_LIMIT = 500
"""Gross errors make Gauss–Newton slow: in trials with wrong closures up to 203 steps."""
_REMEDY = "start from better poses, allow more steps or loosen tol"
ELSEWHERE = "this was the unweighted solve; begin the robust one elsewhere, with x0=problem.guess"
"""The remedy for a problem's own start."""


S = TypeVar("S")


class Place(Protocol[S]):
    """Least squares at ``poses`` ``(n, …)``, of any model; its steps S are often ``(n, D)``."""

    @property
    def poses(self) -> Array:
        """The poses, and landmarks where there are some."""

    @property
    def cost(self) -> float:
        """The cost that is minimised."""

    def step(self, damping: float) -> tuple[S, float] | None:
        """Return the damped step and the decrease of the linearised cost, or None: damp more."""

    def moved(self, step: S) -> Self:
        """Return it after a ``step``."""

    def is_small(self, step: S, tol: float) -> bool:
        """Tell whether a ``step`` is as small as that of ``gauss_newton`` at its end."""


P = TypeVar("P", bound=Place[Any])


@dataclass(frozen=True, eq=False)
class Descent(Generic[P]):
    """Where a descent is, and whether it is at rest there."""

    here: P
    converged: bool

    def converged_poses(self, max_iterations: int, remedy: str = _REMEDY) -> Array:
        """Return the poses, ``(n, 3)`` or ``(n, 3, 4)``.

        Raises:
            NotConverged: the descent did not converge.
        """
        if not self.converged:
            cost = f"after {max_iterations} steps the cost is {self.here.cost:.6g}"
            raise NotConverged(f"{cost}; {remedy}")
        return self.here.poses


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
