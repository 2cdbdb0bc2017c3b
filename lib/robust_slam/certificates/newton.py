"""Riemannian Newton on the chordal problem, over rotations or over the Stiefel manifold.

Gauss–Newton minimises the logarithm cost, not the chordal one, so a map is polished before
it is certified. Each step minimises the quadratic model of the cost in a trust region, by
conjugate gradients: they need only products with the Hessian, stop early far from a minimum,
and follow a direction of negative curvature to the edge of the region. Pose 0 is fixed, and
after each step the positions are the best ones for the rotations.

With the preconditioner of ``preconditioner`` one iteration of the conjugate gradients is
Newton's step close to a minimum, and where the problem is badly conditioned a few do.

Source: Absil, Baker and Gallivan 2007, "Trust-region methods on Riemannian manifolds",
Algorithms 1 and 2; Steihaug 1983 and Toint 1981 for truncated conjugate gradients; Rosen et
al. 2019, "SE-Sync", section 5, for pose graphs.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import ArrayLike

from robust_slam._arrays import Array
from robust_slam._deadline import Deadline
from robust_slam.certificates.chordal import ChordalProblem, pose_blocks
from robust_slam.certificates.preconditioner import Operator, Systems
from robust_slam.certificates.tangent import Point, half_gradient, retract_vectors
from robust_slam.descent.step import NEGLIGIBLE_COST, check_limits, increases
from robust_slam.errors import NotConverged
from robust_slam.graphs.pose_graph import PoseGraph, check_poses

STEP_LIMIT = 200
_log = logging.getLogger(__name__)
_INNER_LIMIT = 300
"""The largest number of conjugate-gradient iterations in a step."""
_FORCING = 0.1
"""The least relative reduction of the residual by conjugate gradients."""
_FIRST_RADIUS = 4.0
"""The first radius, relative to the preconditioned gradient."""
_ACCEPTED, _POOR, _GOOD, _VERY_GOOD = 0.05, 0.25, 0.75, 0.9
"""Ratios of the decrease of the cost to that of the model."""
_NOISE = 1e-13
"""The rounding error of a difference of costs, relative to the cost."""
_FLAT = 1e-9
"""Below this stationarity a Newton step that does not halve it has reached rounding level."""


class Stop(Enum):
    """Why a descent stopped."""

    STATIONARY = "stationary"
    """The stationarity is at most ``tol``."""
    ROUNDING = "rounding"
    """No step lowers the gradient or the cost any further in working precision."""
    FLAT = "flat"
    """A step is predicted to lower the cost by less than the share asked for."""
    LOOSE = "the relaxation is not tight"
    """The staircase solved the relaxation, and no map was found that attains its value."""
    ITERATION_LIMIT = "iteration limit"
    TIME_LIMIT = "time limit"


@dataclass(frozen=True, eq=False)
class Descent:
    """The result of a descent: the ``history`` of points, the start first, and its ``stop``."""

    history: tuple[Point, ...]
    stop: Stop

    @property
    def converged(self) -> bool:
        """Whether the gradient is zero up to ``tol`` or rounding."""
        return self.stop in (Stop.STATIONARY, Stop.ROUNDING)

    @property
    def last(self) -> Point:
        """The last point, that of the lowest cost."""
        return self.history[-1]


def polish(
    graph: PoseGraph,
    poses: ArrayLike,
    weights: ArrayLike | None = None,
    *,
    tol: float = 1e-13,
    max_iterations: int = STEP_LIMIT,
) -> Array:
    """Return the poses at a minimum of the chordal cost near ``poses``.

    ``poses``, ``(n, 3)`` or ``(n, 3, 4)``, are the start; pose 0 is fixed. ``weights``
    ``(m,)`` multiply κ and τ and are 1 if None. It converges when the stationarity
    is at most ``tol``, or at rounding level, where a step does not halve it. The convergence
    is quadratic near a minimum.

    Raises:
        ValueError: ``poses`` or ``weights`` have the wrong shape or are not finite, a
            weight is negative, or a limit is out of range.
        Underdetermined: the edges with positive weight do not connect all poses.
        NotConverged: ``max_iterations`` steps were not enough.

    Source: Absil, Baker and Gallivan 2007, Algorithm 1.
    """
    start = check_poses("poses", poses, graph)
    problem = ChordalProblem.of(graph, weights)
    descent = descend(problem, pose_blocks(start), tol, max_iterations)
    if not descent.converged:
        raise NotConverged(
            f"after {len(descent.history) - 1} steps the chordal cost is "
            f"{descent.last.cost:.6g} and the stationarity {descent.last.stationarity:.2g}; "
            "start from better poses, allow more steps or loosen tol"
        )
    return poses_like(graph, descent.last.blocks, start)


def poses_like(graph: PoseGraph, blocks: Array, start: Array) -> Array:
    """Return the poses of ``blocks`` ``(n, d, d + 1)``, with pose 0 exactly as in ``start``."""
    poses = graph.group.from_parts(blocks[..., :-1], blocks[..., -1])
    poses[0] = start[0]
    return poses


def descend(
    problem: ChordalProblem,
    blocks: Array,
    tol: float = 1e-13,
    max_iterations: int = STEP_LIMIT,
    *,
    least_decrease: float = 0.0,
    max_seconds: float = np.inf,
) -> Descent:
    """Run Newton from ``blocks`` ``(n, r, d + 1)`` of any rank r ≥ d.

    It stops as ``polish`` does, or when a step is predicted to lower the cost by less than
    ``least_decrease`` times the cost, after ``max_iterations`` steps, or after
    ``max_seconds`` of CPU time, and returns the best point so far. The cost never increases.
    Each step is logged at the level DEBUG.

    Raises:
        ValueError: ``tol`` or ``max_seconds`` is negative, or ``max_iterations`` below 1.
        Underdetermined: the problem is singular to working precision.
    """
    check_limits(tol, max_iterations)
    deadline = Deadline.after(max_seconds)
    systems = Systems(problem, blocks.shape[1])
    history: list[Point] = [Point.at(problem, blocks)]
    radius = None
    for _ in range(max_iterations):
        point = history[-1]
        if point.stationarity <= tol:
            return Descent(tuple(history), Stop.STATIONARY)
        if deadline.passed:
            return Descent(tuple(history), Stop.TIME_LIMIT)
        region = _Region.at(systems, point, radius)
        step, trial = region.advance(deadline)
        radius = region.radius
        if trial is None:
            stop = Stop.TIME_LIMIT if deadline.passed else Stop.ROUNDING
            return Descent(tuple(history), stop)
        flat = point.stationarity < _FLAT and trial.stationarity > 0.5 * point.stationarity
        rounding = flat and not step.at_edge
        if not rounding or trial.stationarity < point.stationarity:
            history.append(trial)
        if rounding:
            return Descent(tuple(history), Stop.ROUNDING)
        if step.decrease < least_decrease * point.cost:
            return Descent(tuple(history), Stop.FLAT)
    return Descent(tuple(history), Stop.ITERATION_LIMIT)


@dataclass(frozen=True, eq=False)
class _Step:
    """Tangent ``vectors`` ``(n, r, d + 1)`` and the ``decrease`` of the cost in the model.

    ``length`` is that of the step in the norm of the region; ``at_edge`` tells whether the
    region limits it.
    """

    vectors: Array
    decrease: float
    length: float
    iterations: int
    at_edge: bool


@dataclass(eq=False)
class _Region:
    """The quadratic model at a point, in a trust region of ``radius``.

    The radius is in the norm of the preconditioner, where the square of a Newton step is
    about its decrease of the cost.
    """

    systems: Systems
    point: Point
    gradient: Array
    hessian: Operator
    inverse: Operator
    radius: float

    @classmethod
    def at(cls, systems: Systems, point: Point, radius: float | None) -> _Region:
        """Return the model at ``point``; the first ``radius`` follows from the gradient."""
        gradient = half_gradient(systems.problem, point.blocks)
        gradient[0] = 0.0
        inverse = systems.preconditioner(point.blocks)
        if radius is None:
            radius = _FIRST_RADIUS * np.sqrt(np.vdot(gradient, inverse(gradient)))
        hessian = systems.hessian(point.blocks)
        return cls(systems, point, gradient, hessian, inverse, float(radius))

    def advance(self, deadline: Deadline) -> tuple[_Step, Point | None]:
        """Return a step and its point, of no higher cost; None if a step gains rounding alone.

        The radius shrinks until the model predicts the cost well enough. The point is also
        None if that is not so when the ``deadline`` has passed.

        Source: Absil, Baker and Gallivan 2007, Algorithm 1.
        """
        problem, point = self.systems.problem, self.point
        while True:
            step = self.step()
            moved = retract_vectors(point.blocks, step.vectors)
            trial = Point.at(problem, self.systems.with_optimal_positions(moved))
            ratio = _gain_ratio(point, trial, step)
            _log.debug(
                "rank %d: cost %.9g, stationarity %.1e, %d inner iterations, gain ratio %.2f",
                point.blocks.shape[1],
                point.cost,
                point.stationarity,
                step.iterations,
                ratio,
            )
            self.radius = _next_radius(self.radius, step, ratio)
            if ratio > _ACCEPTED and not increases(trial.cost, point.cost):
                return step, trial
            exhausted = step.decrease <= _NOISE * point.cost + NEGLIGIBLE_COST
            if exhausted or deadline.passed:
                return step, None

    def step(self) -> _Step:
        """Return the step of truncated conjugate gradients.

        Source: Steihaug 1983; Absil, Baker and Gallivan 2007, Algorithm 2, with its
        equations for the norms.
        """
        vectors, change = np.zeros_like(self.gradient), np.zeros_like(self.gradient)
        residual = self.gradient.copy()
        scaled = self.inverse(residual)
        size = first = float(np.vdot(residual, scaled))
        if first == 0.0:
            return self._step(vectors, change, 0.0, 0, at_edge=False)
        goal = first * min(_FORCING, np.sqrt(self.point.stationarity)) ** 2
        direction = -scaled
        # In the norm of the preconditioner: of the step, of the direction, and their product.
        square, across, along = 0.0, 0.0, size
        for iteration in range(1, _INNER_LIMIT + 1):
            curved = self.hessian(direction)
            curvature = float(np.vdot(direction, curved))
            length = size / curvature if curvature > 0.0 else np.inf
            longer = square + 2.0 * length * across + length**2 * along
            if not longer < self.radius**2:
                room = across**2 + along * (self.radius**2 - square)
                length = (np.sqrt(max(room, 0.0)) - across) / along
                vectors += length * direction
                change += length * curved
                return self._step(vectors, change, self.radius, iteration, at_edge=True)
            vectors += length * direction
            change += length * curved
            residual += length * curved
            scaled = self.inverse(residual)
            square, last, size = longer, size, float(np.vdot(residual, scaled))
            if size <= goal:
                break
            direction = (size / last) * direction - scaled
            across = (size / last) * (across + length * along)
            along = size + (size / last) ** 2 * along
        return self._step(vectors, change, float(np.sqrt(square)), iteration, at_edge=False)

    def _step(
        self, vectors: Array, change: Array, length: float, iterations: int, at_edge: bool
    ) -> _Step:
        decrease = -float(np.vdot(2.0 * self.gradient + change, vectors))
        return _Step(vectors, decrease, length, iterations, at_edge)


def _gain_ratio(point: Point, trial: Point, step: _Step) -> float:
    """Return the decrease of the cost over that of the model, 1 where both are rounding.

    Source: Conn, Gould and Toint 2000, "Trust-Region Methods", section 17.4.2, for the
    rounding.
    """
    noise = _NOISE * point.cost + NEGLIGIBLE_COST
    return (point.cost - trial.cost + noise) / (step.decrease + noise)


def _next_radius(radius: float, step: _Step, ratio: float) -> float:
    """Return the radius after ``step`` with the given gain ratio."""
    if not ratio >= _POOR:
        return 0.25 * step.length
    if not step.at_edge or ratio < _GOOD:
        return radius
    return 2.0 * radius if ratio < _VERY_GOOD else 4.0 * radius
