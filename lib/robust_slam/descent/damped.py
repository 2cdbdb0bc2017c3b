"""Levenberg–Marquardt on a pose graph: Gauss–Newton with adaptive damping.

A damped step is between the Gauss–Newton step and the direction of steepest descent.
The damping grows after a rejected step and shrinks after a good one.

Source: Marquardt 1963, damping by the diagonal; Nielsen 1999, its update by the gain ratio.
"""

import numpy as np
from numpy.typing import ArrayLike

from robust_slam._arrays import Array
from robust_slam.descent.normal_equations import NormalEquations, checked_start
from robust_slam.descent.step import STEP_LIMIT, Descent, damping_factor, increases, is_small
from robust_slam.graphs.pose_graph import PoseGraph

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

    ``poses`` are ``(n, 3)`` or ``(n, 3, 4)``, ``weights`` ``(m,)``. Arguments, stopping rule and
    errors are those of ``gauss_newton``; a rejected step counts as an iteration.

    Source: Marquardt 1963, Nielsen 1999.

    >>> from robust_slam.graphs import circle, dead_reckoning
    >>> from robust_slam.graphs.pose_graph import cost
    >>> graph, _ = circle(40, np.random.default_rng(0), laps=2, closures=8)
    >>> round(cost(graph, levenberg_marquardt(graph, dead_reckoning(graph))), 1)
    11.2
    """
    start = checked_start(graph, poses, weights, tol, max_iterations)
    return descend_damped(*start, tol, max_iterations).converged_poses(max_iterations)


def descend_damped(
    equations: NormalEquations, poses: Array, weights: Array, tol: float, max_iterations: int
) -> Descent:
    """Run Levenberg–Marquardt on normal equations whose pattern is already known.

    ``poses`` are ``(n, 3)`` or ``(n, 3, 4)``, ``weights`` ``(m,)``. The arguments are not checked,
    and running out of iterations is no error; singular equations are, Underdetermined.
    """
    equations, weights = equations.restricted(weights)
    current = equations.at(poses, weights)
    damping, growth, size = _FIRST_DAMPING, 2.0, np.inf
    for _ in range(max_iterations):
        step, predicted = equations.damped_step(*equations.system(current), damping)
        size = float(np.abs(step).max())
        trial = equations.moved(current, step)
        if not increases(trial.cost, current.cost):
            converged = is_small(step, current.poses, tol)
            gain_ratio = (current.cost - trial.cost) / max(predicted, np.finfo(float).tiny)
            damping, growth = damping * damping_factor(gain_ratio), 2.0
            current = trial
            if converged:
                return Descent(current.poses, current.cost, size, converged=True)
        else:
            damping, growth = damping * growth, 2.0 * growth
    return Descent(current.poses, current.cost, size, converged=False)
