"""Levenberg–Marquardt on a pose graph: a Gauss–Newton step that is damped as needed.

A damped step lies between the Gauss–Newton step and the direction of steepest descent.
The damping grows after a step that would raise the cost and shrinks after a good one.

Source: Marquardt 1963, damping by the diagonal; Nielsen 1999, how it follows the gain.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from robust_slam._arrays import Array
from robust_slam.descent.normal_equations import (
    NormalEquations,
    linear_change,
    linear_rise,
    weighted_edges,
)
from robust_slam.descent.step import (
    STEP_LIMIT,
    Descent,
    Place,
    check_limits,
    is_small,
    moved,
    rises,
    shrink,
)
from robust_slam.graphs.pose_graph import PoseGraph, check_poses, check_weights

_FIRST_DAMPING = 1e-4


def levenberg_marquardt(
    graph: PoseGraph,
    poses: ArrayLike,
    weights: ArrayLike | None = None,
    *,
    tol: float = 1e-9,
    max_iterations: int = STEP_LIMIT,
) -> Array:
    """Return the poses at a minimum of ½ Σ w ‖whitened residual‖² near ``poses``.

    ``poses`` are ``(n, 3)`` or ``(n, 3, 4)``, ``weights`` ``(m,)``. Arguments and the rule
    for stopping are those of ``gauss_newton``; a step that is refused counts as an
    iteration.

    Raises:
        ValueError: as ``gauss_newton``.
        Underdetermined: the edges with positive weight leave a pose loose.
        NotConverged: ``max_iterations`` steps were not enough.

    Source: Marquardt 1963, damping by the diagonal; Nielsen 1999, how it follows the gain.
    """
    check_limits(tol, max_iterations)
    start = check_poses("poses", poses, graph)
    full = check_weights(weights, graph)
    descent = descend_damped(NormalEquations(graph), start, full, tol, max_iterations)
    return descent.settled(max_iterations)


def descend_damped(
    equations: NormalEquations, poses: Array, weights: Array, tol: float, max_iterations: int
) -> Descent:
    """Run Levenberg–Marquardt on equations whose pattern is already known.

    ``poses`` are ``(n, 3)`` or ``(n, 3, 4)``, ``weights`` ``(m,)``. The arguments are those
    of ``levenberg_marquardt``, checked already. Running out of
    iterations is told, not raised.

    Raises:
        Underdetermined: the normal equations are singular.
    """
    equations, weights = equations.without_idle_edges(weights)
    here = equations.at(poses, weights)
    damping, growth, size = _FIRST_DAMPING, 2.0, np.inf
    for _ in range(max_iterations):
        step, promised = _damped(equations, here, weights, damping)
        size = float(np.abs(step).max())
        trial = equations.at(moved(equations.graph, here.poses, step), weights)
        if not rises(trial.cost, here.cost):
            at_rest = is_small(step, here.poses, tol)
            gain = (here.cost - trial.cost) / max(promised, np.finfo(float).tiny)
            damping, growth = damping * shrink(gain), 2.0
            here = trial
            if at_rest:
                return Descent(here.poses, here.cost, size, at_rest=True)
        else:
            damping, growth = damping * growth, 2.0 * growth
    return Descent(here.poses, here.cost, size, at_rest=False)


def _damped(
    equations: NormalEquations, here: Place, weights: Array, damping: float
) -> tuple[Array, float]:
    """Return a damped step and how far it lowers the cost of the linearised residuals."""
    graph = equations.graph
    jacobian, information, pull = weighted_edges(graph, here, weights)
    step = equations.solve(jacobian, information, pull, damping)
    return step, -linear_rise(linear_change(jacobian, graph, step), information, pull)
