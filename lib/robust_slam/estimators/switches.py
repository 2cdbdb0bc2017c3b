"""Switchable constraints: each doubted edge has a switch s in [0, 1] that scales its residual.

The objective of the paper is Σ χ² over the trusted edges plus Σ s²χ² + λ(1 − s)² over the
doubted ones, with χ² the squared whitened residual, the switch function Ψ(s) = s and the
prior s = 1 of variance 1/λ. It has no ½. ``switch`` and ``switched_cost`` are in its terms;
the cost of every ``Result`` is half of it, as everywhere in the library. Minimisers and
weights do not see the factor.

At fixed poses the best switch is known: s = λ/(λ + χ²), never exactly 0. Put back, it
leaves λχ²/(λ + χ²), which is twice the Geman–McClure kernel with c² = λ, and the weight of
the edge is s². So the closed form is the one loop with that kernel; the joint form walks
through poses and switches together, as the paper does.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike

from robust_slam._arrays import Array, Mask, finite, positive
from robust_slam.descent.normal_equations import NormalEquations, linear_change, linear_rise
from robust_slam.descent.step import check_limits, is_small, moved, rises, shrink
from robust_slam.estimators import kernels
from robust_slam.estimators.loop import Problem
from robust_slam.estimators.result import Result, Step, StopReason
from robust_slam.estimators.reweighting import irls
from robust_slam.graphs import pose_graph
from robust_slam.graphs.pose_graph import PoseGraph, check_poses
from robust_slam.problems import PoseGraphProblem

X = TypeVar("X")

_DAMPING = 1e-4


def switch(chi2: ArrayLike, lam: float) -> Array:
    """Return the best switch s = λ/(λ + χ²) of edges with squared whitened residuals χ².

    ``chi2`` has any shape and so has the answer. The weight of the edge is s², not s.

    Raises:
        ValueError: ``lam`` is not a finite number above zero, or a χ² is negative or not finite.

    Source: derived here, by setting the derivative 2sχ² − 2λ(1 − s) of the objective of
    Sünderhauf and Protzel 2012 to 0. The box [0, 1] needs no care.
    """
    lam = positive("lam", lam)
    return lam / (lam + _squares(chi2))


def switched_cost(chi2: ArrayLike, lam: float) -> Array:
    """Return the least s²χ² + λ(1 − s)² over s, which is λχ²/(λ + χ²) < λ, of any shape.

    Without the ½: it is 2ρ(u) of ``kernels.geman_mcclure`` with c² = λ and u² = χ².

    Raises:
        ValueError: as ``switch``.

    Source: derived here, by putting s = λ/(λ + χ²) into the objective.
    """
    return _squares(chi2) * switch(chi2, lam)


def dcs_switch(chi2: ArrayLike, phi: float) -> Array:
    """Return the switch min(1, 2Φ/(Φ + χ²)) of dynamic covariance scaling, of any shape.

    Beyond χ² = Φ it is twice the switch of λ = Φ, so it does not minimise that objective.
    The information of the edge is scaled by s².

    Raises:
        ValueError: ``phi`` is not a finite number above zero, or a χ² is negative or not finite.

    Source: Agarwal et al. 2013.
    """
    phi = positive("phi", phi)
    return np.minimum(1.0, 2.0 * phi / (phi + _squares(chi2)))


def _squares(chi2: ArrayLike) -> Array:
    squares = np.asarray(chi2, dtype=np.float64)
    if not np.all(np.isfinite(squares) & (squares >= 0.0)):
        raise ValueError("chi2: an entry is negative or not finite; give squared norms")
    return squares


def switchable(
    problem: Problem[X],
    lam: float,
    x0: X | None = None,
    *,
    tol: float = 1e-12,
    max_iterations: int = 100,
) -> Result[X]:
    """Minimise the switched cost by the closed form: solve, set every switch, solve again.

    The weights of the result are s², so the switches are their roots. λ is in units of χ²:
    an edge with χ² = λ has s = ½. The start is ``x0``, or plain least squares.

    Raises:
        ValueError: ``lam`` is not a finite number above zero, or as ``loop.reweight``.

    Source: Sünderhauf and Protzel 2012; the closed form is derived in ``switch``.
    """
    kernel = kernels.geman_mcclure(sqrt(positive("lam", lam)))
    return irls(problem, kernel, x0, tol=tol, max_iterations=max_iterations)


def joint_switchable(
    problem: PoseGraphProblem,
    lam: float,
    x0: ArrayLike | None = None,
    s0: ArrayLike | None = None,
    *,
    damping: float = _DAMPING,
    tol: float = 1e-9,
    max_iterations: int = 500,
) -> Result[Array]:
    """Minimise the switched cost over poses and switches together.

    The poses start at ``x0`` ``(n, 3)`` or ``(n, 3, 4)``, by default plain least squares,
    and the switches at ``s0`` ``(m,)``, by default 1; trusted edges have none and stay
    at 1. Each of the at most ``max_iterations`` steps is a Gauss–Newton step on both, kept
    to s in [0, 1], and damped on the poses: from ``damping`` on (0 for a plain first
    step), more after a step that would raise the cost and is not taken, less after a good
    one. It has CONVERGED when an undamped step moves no switch by more than ``tol`` and
    no pose by more than ``tol`` times 1 + the largest coordinate of the map.

    The weights of a step are s², with s the switches beside its poses.

    Raises:
        ValueError: an argument is out of range or has the wrong shape.
        Underdetermined: the trusted edges and those with s > 0 do not determine the map.
        NotConverged: plain least squares did not come to rest; give ``x0``.

    Source: Sünderhauf and Protzel 2012; Marquardt 1963, damping by the diagonal; Nielsen
    1999, how it follows the gain.
    """
    lam, damping = positive("lam", lam), _checked_damping(damping)
    check_limits(tol, max_iterations)
    model = _Switched(NormalEquations(problem.graph), ~problem.trusted, lam)
    poses = problem.initial() if x0 is None else check_poses("x0", x0, problem.graph)
    here = model.at(poses, _switches(s0, model.doubted))
    history, growth = [here.record()], 2.0
    for _ in range(max_iterations):
        motion, turn, promised = model.step(here, damping)
        there = model.at(
            moved(problem.graph, here.poses, motion), np.clip(here.switches + turn, 0.0, 1.0)
        )
        if rises(there.cost, here.cost):
            damping, growth = max(_DAMPING, growth * damping), 2.0 * growth
            continue
        history.append(there.record())
        small = is_small(motion, here.poses, tol) and bool(np.all(np.abs(turn) <= tol))
        if small and damping == 0.0:
            return Result.ending(history, StopReason.CONVERGED)
        # A damped step may be small anywhere; one without damping is small at a minimum.
        damping = 0.0 if small else damping * shrink((here.cost - there.cost) / promised)
        here, growth = there, 2.0
    return Result.ending(history, StopReason.ITERATION_LIMIT)


def dcs(
    problem: Problem[X],
    phi: float,
    x0: X | None = None,
    *,
    tol: float = 1e-12,
    max_iterations: int = 100,
) -> Result[X]:
    """Run dynamic covariance scaling: the loop with the weight s² of ``dcs_switch``.

    The cost is that of ``kernels.dcs`` with c² = Φ, the one whose weight s² is.

    The start is ``x0``, or plain least squares.

    Raises:
        ValueError: ``phi`` is not a finite number above zero, or as ``loop.reweight``.

    Source: Agarwal et al. 2013.
    """
    kernel = kernels.dcs(sqrt(positive("phi", phi)))
    return irls(problem, kernel, x0, tol=tol, max_iterations=max_iterations)


def _checked_damping(damping: float) -> float:
    if not (np.isfinite(damping) and damping >= 0.0):
        raise ValueError(f"damping is {damping}; give a number of at least 0")
    return float(damping)


@dataclass(frozen=True, eq=False)
class _Place:
    """Poses with switches ``(m,)`` and their joint cost."""

    poses: Array
    switches: Array
    cost: float

    def record(self) -> Step[Array]:
        return Step(self.poses, self.switches**2, self.cost, None)


@dataclass(frozen=True, eq=False)
class _Switched:
    """The joint problem ½ Σ s²χ² + λ(1 − s)²; an edge that is not doubted keeps s = 1."""

    equations: NormalEquations
    doubted: Mask
    lam: float

    @property
    def graph(self) -> PoseGraph:
        return self.equations.graph

    def at(self, poses: Array, switches: Array) -> _Place:
        chi2 = pose_graph.squared_norms(poses, self.graph)
        total = np.sum(switches**2 * chi2 + self.lam * (1.0 - switches) ** 2)
        return _Place(poses, switches, 0.5 * float(total))

    def step(self, place: _Place, damping: float) -> tuple[Array, Array, float]:
        """Return the Gauss–Newton step of the poses ``(n, D)`` and of the switches ``(m,)``.

        The third is how far it lowers the cost of the linearised residuals.

        A switch touches one edge only, so it leaves the normal equations exactly and is
        found again afterwards. Per edge, with v = Ωr, h = χ² + λ and the slope
        g = sχ² − λ(1 − s) of the cost by s, the Schur complement is

            A = s²(Ω − v vᵀ/h),   p = (s² − s g/h) v,   δs = −(g + s vᵀJδ)/h.

        The derivative of s·r by s is r, not s·r: from s = 0 the switch still moves.
        """
        graph, s = self.graph, place.switches
        predicted = pose_graph.seen(place.poses, graph)
        r = pose_graph.errors(predicted, graph)
        jacobian = pose_graph.linearise(predicted, r, graph)
        v = (graph.information @ r[..., None])[..., 0]
        chi2 = np.sum(r * v, axis=1)
        # A trusted edge is one whose switch is infinitely stiff: h = ∞ leaves A = Ω, p = Ωr.
        inverse = np.where(self.doubted, 1.0 / (chi2 + self.lam), 0.0)
        slope = s * chi2 - self.lam * (1.0 - s)
        # A is never indefinite: with a = Ω^½ r it is s² Ω^½ (I − a aᵀ/(‖a‖² + λ)) Ω^½, and
        # the bracket has the eigenvalues λ/(‖a‖² + λ) > 0 and 1.
        shrunk = graph.information - inverse[:, None, None] * v[:, :, None] * v[:, None, :]
        pull = (s**2 - s * slope * inverse)[:, None] * v
        reduced = s[:, None, None] ** 2 * shrunk
        motion = self.equations.solve(jacobian, reduced, pull, damping)
        change = linear_change(jacobian, graph, motion)
        turn = -inverse * (slope + s * np.sum(v * change, axis=1))
        promised = 0.5 * float(np.sum(inverse * slope**2)) - linear_rise(change, reduced, pull)
        return motion, turn, max(promised, np.finfo(float).tiny)


def _switches(s0: ArrayLike | None, doubted: Mask) -> Array:
    given = np.ones(doubted.size) if s0 is None else finite("s0", s0, (doubted.size,))
    if np.any((given < 0.0) | (given > 1.0)):
        raise ValueError("s0: an entry is outside [0, 1]; give switches between 0 and 1")
    return np.where(doubted, given, 1.0)
