"""Gauss–Newton and Levenberg–Marquardt: what becomes of a step that would increase the cost.

The one halves it until it does not, however far the start is. The other goes between it and the
direction of steepest descent, the nearer the latter the more it is damped: more after a rejected
step, less after a good one.

Source: Dennis and Schnabel 1983, section 10.2, the halving; Marquardt 1963, damping by the
diagonal; Nielsen 1999, its update by the gain ratio.
"""

from collections import deque
from collections.abc import Iterable, Iterator

import numpy as np
from numpy.typing import ArrayLike

from robust_slam._arrays import Array
from robust_slam.descent.normal_equations import Linearisation, NormalEquations
from robust_slam.descent.step import (
    STEP_LIMIT,
    Descent,
    P,
    check_limits,
    damping_factor,
    increases,
)
from robust_slam.graphs.pose_graph import PoseGraph, check_poses, check_weights

FIRST_DAMPING = 1e-4
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
    start = _start(graph, poses, weights, tol, max_iterations)
    return undamped(start, tol, max_iterations).converged_poses(max_iterations)


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
    start = _start(graph, poses, weights, tol, max_iterations)
    return last(damped(start, tol, max_iterations)).converged_poses(max_iterations)


def _start(
    graph: PoseGraph, poses: ArrayLike, weights: ArrayLike | None, tol: float, max_iterations: int
) -> Linearisation:
    check_limits(tol, max_iterations)
    start = check_poses("poses", poses, graph)
    return NormalEquations(graph).start(start, check_weights(weights, graph))


def undamped(here: Linearisation, tol: float, max_iterations: int) -> Descent[Linearisation]:
    """Return where Gauss–Newton leads, which is no minimum if ``max_iterations`` are too few.

    Singular equations are Underdetermined.
    """
    for _ in range(max_iterations):
        step, _ = here.step()
        if here.is_small(step, tol):
            return Descent(here.moved(step), converged=True)
        # The longest of step, step/2, step/4, … that does not increase the cost is taken.
        for halvings in range(_HALVINGS):
            there = here.moved(step * 0.5**halvings)
            if not increases(there.cost, here.cost):
                break
        else:
            return Descent(here, _hidden_by_rounding(here, step))
        here = there
    return Descent(here, converged=False)


def _hidden_by_rounding(here: Linearisation, step: Array) -> bool:
    """Tell whether a step changes the cost by no more than the rounding of the coordinates.

    With coordinates p, each residual is off by about ε |p|, and so the cost ½ ‖u‖² by at most
    ‖u‖ ε |p| √tr(w Ω), by the inequality of Cauchy and Schwarz.
    """
    position = here.poses[..., :2] if here.poses.ndim == 2 else here.poses[..., 3]
    off = np.finfo(float).eps * np.abs(position).max()
    trace = np.trace(here.equations.graph.information, axis1=1, axis2=2)
    total = np.sum(here.weights * trace)
    change = abs(here.moved(step).cost - here.cost)
    return bool(change <= np.sqrt(2.0 * here.cost * total) * off)


def damped(
    here: P,
    tol: float,
    trials: int,
    damping: float = FIRST_DAMPING,
    *,
    ends_undamped: bool = False,
) -> Iterator[Descent[P]]:
    """Yield where Levenberg–Marquardt begins, and where each step leads that is not rejected.

    At most so many steps are tried, the first with ``damping``, and a small one is the last. A
    damped step can be small anywhere: with ``ends_undamped``, undamped ones follow it.
    """
    least, growth = FIRST_DAMPING if ends_undamped else 0.0, 2.0
    yield Descent(here, converged=False)
    for _ in range(trials):
        tried = here.step(damping)
        if tried is None or increases((there := here.moved(tried[0])).cost, here.cost):
            damping, growth = max(least, growth * damping), 2.0 * growth
            continue
        step, predicted = tried
        small = here.is_small(step, tol)
        gain_ratio = (here.cost - there.cost) / max(predicted, np.finfo(float).tiny)
        rests = small and not (ends_undamped and damping)
        here, growth = there, 2.0
        yield Descent(here, rests)
        if rests:
            return
        damping = 0.0 if small else damping * damping_factor(gain_ratio)


def last(descents: Iterable[Descent[P]]) -> Descent[P]:
    """Return the last of one or more."""
    return deque(descents, maxlen=1).pop()
