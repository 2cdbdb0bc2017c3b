"""What every descent on a pose graph shares: its record, its limits, its retraction."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robust_slam._arrays import Array
from robust_slam.errors import NotConverged
from robust_slam.graphs import pose_graph
from robust_slam.graphs.pose_graph import PoseGraph

ROUNDING = 1e-12
"""A relative rise of the cost that is taken for rounding."""
NOTHING = 1e-18
"""A cost that no measurement can tell from 0."""
STEP_LIMIT = 500
"""Gross errors make Gauss–Newton slow: in trials with wrong closures up to 203 steps."""


@dataclass(frozen=True, eq=False)
class Place:
    """Poses, and what both their cost and the next step from there want to know.

    ``predicted`` is what ``pose_graph.seen`` gives, ``residuals`` ``(m, D)`` are the r of
    the edges, and ``pull`` ``(m, D)`` is w Ω r.
    """

    poses: Array
    predicted: Array
    residuals: Array
    pull: Array
    cost: float

    @classmethod
    def at(cls, graph: PoseGraph, poses: Array, weights: Array) -> Place:
        """Return the place of ``poses``, each edge of ``graph`` with its weight ``(m,)``."""
        predicted = pose_graph.seen(poses, graph)
        return cls.of(graph, poses, predicted, pose_graph.errors(predicted, graph), weights)

    @classmethod
    def of(
        cls, graph: PoseGraph, poses: Array, predicted: Array, r: Array, weights: Array
    ) -> Place:
        """Return the place where the edges are known to see ``predicted``, with residuals r."""
        pull = weights[:, None] * pose_graph.loaded(r, graph)
        return cls(poses, predicted, r, pull, 0.5 * float(np.sum(r * pull)))


@dataclass(frozen=True, eq=False)
class Descent:
    """Where a descent ended: poses, cost, size of the last step, at rest or not."""

    poses: Array
    cost: float
    step: float
    at_rest: bool

    def settled(self, max_iterations: int) -> Array:
        """Return the poses.

        Raises:
            NotConverged: the descent is not at rest.
        """
        if not self.at_rest:
            raise NotConverged(
                f"after {max_iterations} steps the cost is {self.cost:.6g} and the last step "
                f"{self.step:.2g}; start from better poses, allow more steps or loosen tol"
            )
        return self.poses


def moved(graph: PoseGraph, poses: Array, step: Array) -> Array:
    """Return each pose ∘ Exp(its row of ``step`` ``(n, D)``)."""
    return graph.group.compose(poses, graph.group.exp(step))


def rises(cost: float, before: float) -> bool:
    """Tell whether ``cost`` is higher than the one ``before``, beyond rounding.

    A cost is a sum of squares without a unit, so below ``NOTHING`` it is 0 with rounding.
    """
    return cost > before * (1.0 + ROUNDING) + NOTHING


def is_small(step: Array, poses: Array, tol: float) -> bool:
    """Tell whether no coordinate of a step exceeds tol·(1 + the map's largest coordinate)."""
    return float(np.abs(step).max()) <= tol * (1.0 + float(np.abs(poses).max()))


def shrink(gain: float) -> float:
    """Return the factor on a damping after a step: 1/3 for a promise kept, 2 at most.

    ``gain`` is by how much the cost fell, as a share of what the linear model promised.

    Source: Nielsen 1999.
    """
    return max(1.0 / 3.0, 1.0 - (2.0 * min(max(gain, 0.0), 1.0) - 1.0) ** 3)


def check_limits(tol: float, max_iterations: int) -> None:
    """Check when a descent may stop.

    Raises:
        ValueError: ``tol`` is negative, or ``max_iterations`` is below 1.
    """
    if not tol >= 0.0:
        raise ValueError(f"tol is {tol}; give a number of at least 0")
    if max_iterations < 1:
        raise ValueError(f"max_iterations is {max_iterations}; give at least 1")
