"""Gauss–Newton on a pose graph, and the pose graph as a problem of the loop.

Pose 0 stays where it is. A step that would raise the cost is halved until it does not,
so the cost never rises, however far the start is.

Source: Dennis and Schnabel 1983, the damped Gauss–Newton method.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from robust_slam import pose_graph
from robust_slam._arrays import Array, mask
from robust_slam._descent import (
    STEP_LIMIT,
    Descent,
    Place,
    check_limits,
    check_weights,
    is_small,
    moved,
    rises,
)
from robust_slam._normal_equations import NormalEquations
from robust_slam.errors import NotConverged
from robust_slam.levenberg_marquardt import descend_damped
from robust_slam.pose_graph import PoseGraph, check_poses
from robust_slam.start import spanning_tree

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


class PoseGraphProblem:
    """A pose graph for the loop; its x are poses, ``(n, 3)`` or ``(n, 3, 4)``.

    ``guess``, poses too, is where the unweighted solve starts, by default the spanning
    tree of ``start``, which is dead reckoning where the odometry is complete;
    ``trusted`` ``(m,)`` is the mask of edges whose weight stays 1, by default the
    odometry. Each solve takes at most ``steps`` Gauss–Newton steps from the poses of the
    solve before, and ends earlier as ``gauss_newton`` does with ``tol``; the loop goes on
    from there, so a few steps are enough.

    Raises:
        ValueError: ``guess`` or ``trusted`` does not fit the graph, or a limit is out of
            range.
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
        self.guess = spanning_tree(graph) if guess is None else check_poses("guess", guess, graph)
        self.trusted = mask(
            "trusted", graph.is_odometry if trusted is None else trusted, len(graph.edges)
        )
        check_limits(tol, steps)
        self.tol = tol
        self.steps = steps
        self._equations = NormalEquations(graph)

    def initial(self) -> Array:
        """Return the least-squares poses, from the guess, every weight 1.

        With gross errors among the edges Gauss–Newton alone may crawl, so it is damped.

        Raises:
            NotConverged: ``STEP_LIMIT`` steps were not enough.
        """
        ones = np.ones(len(self.graph.edges))
        descent = descend_damped(self._equations, self.guess, ones, self.tol, STEP_LIMIT)
        try:
            return descent.settled(STEP_LIMIT)
        except NotConverged as error:
            raise NotConverged(
                f"the unweighted solve: {error}; or begin the robust solve elsewhere, with "
                "x0=problem.guess"
            ) from None

    def residual_norms(self, x: Array) -> Array:
        """Return the whitened residual norm of every edge, ``(m,)``."""
        _, r = self._equations.look(np.asarray(x))
        return np.sqrt(pose_graph.squares(r, self.graph))

    def solve(self, weights: Array, x: Array) -> Array:
        """Return the poses that Gauss–Newton reaches from ``x``.

        Raises:
            Underdetermined: the edges with positive weight leave a pose loose.
        """
        start = check_poses("x", x, self.graph)
        full = check_weights(weights, self.graph)
        return descend(self._equations, start, full, self.tol, self.steps).poses


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
