"""Gauss–Newton on a pose graph in SE(2), and the pose graph as a problem of the loop.

Pose 0 stays where it is. A step that would raise the cost is halved until it does not,
so the cost never rises, however far the start is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from robust_slam import pose_graph, se2
from robust_slam._arrays import Array, finite, mask
from robust_slam._normal_equations import NormalEquations
from robust_slam.generate import dead_reckoning
from robust_slam.loop import Underdetermined
from robust_slam.pose_graph import PoseGraph, check_poses, unreached

_ROUNDING = 1e-12
"""A relative rise of the cost that is taken for rounding."""
_HALVINGS = 30
STEP_LIMIT = 500
"""Gross errors make Gauss–Newton slow: in trials with wrong closures up to 203 steps."""


class NotConverged(RuntimeError):
    """Gauss–Newton has not come to rest within its iterations."""


@dataclass(frozen=True, eq=False)
class Descent:
    """Where a run of Gauss–Newton ended: poses, cost, size of the last step, at rest or not."""

    poses: Array
    cost: float
    step: float
    at_rest: bool


def gauss_newton(
    graph: PoseGraph,
    poses: ArrayLike,
    weights: ArrayLike | None = None,
    *,
    tol: float = 1e-9,
    max_iterations: int = STEP_LIMIT,
) -> Array:
    """Return the poses ``(n, 3)`` at a minimum of ½ Σ w ‖whitened residual‖² near ``poses``.

    ``poses`` ``(n, 3)`` is the start; its pose 0 is kept. ``weights`` ``(m,)`` are 1 if
    None. It ends when no coordinate of a step (m, m, rad) is larger than ``tol`` times
    1 + the largest coordinate of the map.

    Raises:
        ValueError: ``poses`` or ``weights`` have the wrong shape or are not finite, a
            weight is negative, or a limit is out of range.
        Underdetermined: the edges with positive weight leave a pose loose.
        NotConverged: ``max_iterations`` steps were not enough.

    Source: Dennis and Schnabel 1983, the damped Gauss–Newton method.
    """
    start = check_poses("poses", poses, graph)
    full = _weights(weights, graph)
    descent = descend(NormalEquations(graph), start, full, tol, max_iterations)
    return _at_rest(descent, max_iterations)


class PoseGraphProblem:
    """A pose graph for the loop; its x are poses ``(n, 3)``.

    ``guess`` ``(n, 3)`` is where the unweighted solve starts, by default dead reckoning;
    ``trusted`` ``(m,)`` is the mask of edges whose weight stays 1, by default the
    odometry. Each solve takes at most ``steps`` Gauss–Newton steps from the poses of the
    solve before, and ends earlier as ``gauss_newton`` does with ``tol``; the loop goes on
    from there, so a few steps are enough.

    Raises:
        ValueError: ``guess`` or ``trusted`` does not fit the graph, or the odometry does
            not lead to every pose and no ``guess`` is given.
    """

    def __init__(
        self,
        graph: PoseGraph,
        guess: ArrayLike | None = None,
        trusted: ArrayLike | None = None,
        *,
        tol: float = 1e-9,
        steps: int = 100,
    ) -> None:
        self.graph = graph
        self.guess = dead_reckoning(graph) if guess is None else check_poses("guess", guess, graph)
        self.trusted = mask(
            "trusted", graph.is_odometry if trusted is None else trusted, len(graph.edges)
        )
        self.tol = tol
        self.steps = steps
        self._equations = NormalEquations(graph)

    def initial(self) -> Array:
        """Return the least-squares poses, from the guess, every weight 1.

        Raises:
            NotConverged: ``STEP_LIMIT`` steps were not enough; give a better ``guess``.
        """
        ones = np.ones(len(self.graph.edges))
        descent = descend(self._equations, self.guess, ones, self.tol, STEP_LIMIT)
        return _at_rest(descent, STEP_LIMIT)

    def residual_norms(self, x: Array) -> Array:
        """Return the whitened residual norm of every edge, ``(m,)``."""
        return pose_graph.residual_norms(np.asarray(x), self.graph)

    def solve(self, weights: Array, x: Array) -> Array:
        """Return the poses that Gauss–Newton reaches from ``x`` ``(n, 3)``.

        Raises:
            Underdetermined: the edges with positive weight leave a pose loose.
        """
        start = check_poses("x", x, self.graph)
        return descend(self._equations, start, weights, self.tol, self.steps).poses


def descend(
    equations: NormalEquations, poses: Array, weights: Array, tol: float, max_iterations: int
) -> Descent:
    """Run Gauss–Newton on equations whose pattern is already known.

    Arguments, errors and the rule for stopping are those of ``gauss_newton``, but running
    out of iterations is told, not raised.
    """
    graph = equations.graph
    _check(graph, weights, tol, max_iterations)
    cost = pose_graph.cost(poses, graph, weights)
    size = np.inf
    for _ in range(max_iterations):
        step = equations.step(poses, weights)
        size = float(np.abs(step).max())
        if size <= tol * (1.0 + float(np.abs(poses).max())):
            last = se2.compose(poses, se2.exp(step))
            return Descent(last, pose_graph.cost(last, graph, weights), size, at_rest=True)
        poses, cost = _shortened(graph, poses, weights, step, cost)
    return Descent(poses, cost, size, at_rest=False)


def _shortened(
    graph: PoseGraph, poses: Array, weights: Array, step: Array, cost: float
) -> tuple[Array, float]:
    """Return poses and cost after the longest of step, step/2, step/4, … that is no rise."""
    for halvings in range(_HALVINGS):
        moved = se2.compose(poses, se2.exp(step * 0.5**halvings))
        lower = pose_graph.cost(moved, graph, weights)
        if lower <= cost * (1.0 + _ROUNDING):
            return moved, lower
    return poses, cost


def _at_rest(descent: Descent, max_iterations: int) -> Array:
    if not descent.at_rest:
        raise NotConverged(
            f"after {max_iterations} steps the cost is {descent.cost:.6g} and the last step "
            f"{descent.step:.2g}; start from better poses, allow more steps or loosen tol"
        )
    return descent.poses


def _weights(weights: ArrayLike | None, graph: PoseGraph) -> Array:
    m = len(graph.edges)
    return np.ones(m) if weights is None else finite("weights", weights, (m,))


def _check(graph: PoseGraph, weights: Array, tol: float, max_iterations: int) -> None:
    if np.any(weights < 0.0):
        raise ValueError(f"weights: edge {int(np.argmax(weights < 0.0))} weighs less than 0")
    if not tol >= 0.0:
        raise ValueError(f"tol is {tol}; give a number of at least 0")
    if max_iterations < 1:
        raise ValueError(f"max_iterations is {max_iterations}; give at least 1")
    if np.all(weights > 0.0):
        return
    loose = unreached(graph, weights > 0.0)
    if loose.size:
        raise Underdetermined(
            f"weights: no edge of positive weight joins pose {loose[0]} to pose 0 "
            f"({loose.size} poses are loose); trust the odometry or keep an edge"
        )
