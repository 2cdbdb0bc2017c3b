"""Gauss–Newton on a pose graph, with backtracking.

A step that would increase the cost is halved until it does not, however far the start is.

Source: Dennis and Schnabel 1983, section 10.2, the damped Gauss–Newton method.
"""

import numpy as np
from numpy.typing import ArrayLike

from robust_slam._arrays import Array
from robust_slam.descent.normal_equations import NormalEquations, checked_start
from robust_slam.descent.step import STEP_LIMIT, Descent, Linearisation, increases, is_small
from robust_slam.graphs.pose_graph import PoseGraph

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

    ``poses``, ``(n, 3)`` or ``(n, 3, 4)``, are the start; pose 0 is held fixed. ``weights``
    ``(m,)`` are 1 if None. It converges when a step moves positions by at most
    ``tol`` times 1 m + the longest side of the map, and rotations by at most ``tol`` rad.

    Raises:
        ValueError: ``poses`` or ``weights`` have the wrong shape or are not finite, a
            weight is negative, or a limit is out of range.
        Underdetermined: the edges with positive weight do not connect all poses.
        NotConverged: ``max_iterations`` steps were not enough.

    Source: Dennis and Schnabel 1983, section 10.2.

    >>> from robust_slam.graphs import circle, dead_reckoning
    >>> from robust_slam.graphs.pose_graph import cost
    >>> graph, _ = circle(40, np.random.default_rng(0), laps=2, closures=8)
    >>> first = dead_reckoning(graph)
    >>> round(cost(graph, first), 1), round(cost(graph, gauss_newton(graph, first)), 1)
    (619.0, 11.2)
    """
    start = checked_start(graph, poses, weights, tol, max_iterations)
    return descend_undamped(*start, tol, max_iterations).converged_poses(max_iterations)


def descend_undamped(
    equations: NormalEquations, poses: Array, weights: Array, tol: float, max_iterations: int
) -> Descent:
    """Run Gauss–Newton on normal equations whose pattern is already known.

    ``poses`` are ``(n, 3)`` or ``(n, 3, 4)``, ``weights`` ``(m,)``. The arguments are not checked,
    and running out of iterations is no error; singular equations are, Underdetermined.
    """
    equations, weights = equations.restricted(weights)
    current, size = equations.at(poses, weights), np.inf
    for _ in range(max_iterations):
        step = equations.step(current)
        size = float(np.abs(step).max())
        if is_small(step, current.poses, tol):
            last = equations.moved(current, step)
            return Descent(last.poses, last.cost, size, converged=True)
        # The longest of step, step/2, step/4, … that does not increase the cost is taken.
        for halvings in range(_HALVINGS):
            trial = equations.moved(current, step * 0.5**halvings)
            if not increases(trial.cost, current.cost):
                break
        else:
            there = _hidden_by_rounding(equations, current, step)
            return Descent(current.poses, current.cost, size, converged=there)
        current = trial
    return Descent(current.poses, current.cost, size, converged=False)


def _hidden_by_rounding(equations: NormalEquations, current: Linearisation, step: Array) -> bool:
    """Tell whether a step changes the cost by no more than the rounding of the coordinates.

    With coordinates p, each residual is off by about ε |p|, and so the cost ½ ‖u‖² by at most
    ‖u‖ ε |p| √tr(w Ω), by the inequality of Cauchy and Schwarz.
    """
    position = current.poses[..., :2] if current.poses.ndim == 2 else current.poses[..., 3]
    off = np.finfo(float).eps * np.abs(position).max()
    trace = np.trace(equations.graph.information, axis1=1, axis2=2)
    total = np.sum(current.weights * trace)
    change = abs(equations.moved(current, step).cost - current.cost)
    return bool(change <= np.sqrt(2.0 * current.cost * total) * off)
