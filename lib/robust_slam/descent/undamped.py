"""Gauss–Newton on a pose graph, and the pose graph as a problem of the loop.

Pose 0 stays where it is. A step that would raise the cost is halved until it does not,
so the cost never rises, however far the start is.

Source: Dennis and Schnabel 1983, the damped Gauss–Newton method.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from robust_slam._arrays import Array
from robust_slam.descent.normal_equations import NormalEquations
from robust_slam.descent.step import (
    STEP_LIMIT,
    Descent,
    Place,
    check_limits,
    is_small,
    moved,
    rises,
)
from robust_slam.graphs.pose_graph import PoseGraph, check_poses, check_weights

_HALVINGS = 30


def gauss_newton(
    graph: PoseGraph,
    poses: ArrayLike,
    weights: ArrayLike | None = None,
    *,
    tol: float = 1e-9,
    max_iterations: int = STEP_LIMIT,
) -> Array:
    """Return the poses at a minimum of ½ Σ w ‖whitened residual‖² near ``poses``.

    ``poses``, ``(n, 3)`` or ``(n, 3, 4)``, are the start; pose 0 is kept. ``weights``
    ``(m,)`` are 1 if None. It ends when no coordinate of a step (m, rad) is larger than
    ``tol`` times 1 + the largest coordinate of the map.

    Raises:
        ValueError: ``poses`` or ``weights`` have the wrong shape or are not finite, a
            weight is negative, or a limit is out of range.
        Underdetermined: the edges with positive weight leave a pose loose.
        NotConverged: ``max_iterations`` steps were not enough.

    Source: Dennis and Schnabel 1983, the damped Gauss–Newton method.
    """
    check_limits(tol, max_iterations)
    start = check_poses("poses", poses, graph)
    full = check_weights(weights, graph)
    descent = descend(NormalEquations(graph), start, full, tol, max_iterations)
    return descent.settled(max_iterations)


def descend(
    equations: NormalEquations, poses: Array, weights: Array, tol: float, max_iterations: int
) -> Descent:
    """Run Gauss–Newton on equations whose pattern is already known.

    ``poses`` are ``(n, 3)`` or ``(n, 3, 4)``, ``weights`` ``(m,)``. Arguments and the rule
    for stopping are those of ``gauss_newton``, but checked already, and running out of
    iterations is told, not raised.

    Raises:
        Underdetermined: the normal equations are singular.
    """
    equations, weights = equations.without_idle_edges(weights)
    here, size = equations.at(poses, weights), np.inf
    for _ in range(max_iterations):
        step = equations.step(here, weights)
        size = float(np.abs(step).max())
        if is_small(step, here.poses, tol):
            last = equations.at(moved(equations.graph, here.poses, step), weights)
            return Descent(last.poses, last.cost, size, at_rest=True)
        here = _shortened(equations, here, weights, step)
    return Descent(here.poses, here.cost, size, at_rest=False)


def _shortened(equations: NormalEquations, here: Place, weights: Array, step: Array) -> Place:
    """Return the place after the longest of step, step/2, step/4, … that is no rise."""
    for halvings in range(_HALVINGS):
        trial = equations.at(moved(equations.graph, here.poses, step * 0.5**halvings), weights)
        if not rises(trial.cost, here.cost):
            return trial
    return here
