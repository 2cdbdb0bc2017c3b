"""Switchable constraints: each untrusted edge has a switch s in [0, 1] on its residual.

The objective of the paper is Σ χ² over the trusted edges plus Σ s²χ² + λ(1 − s)² over the
untrusted ones, with χ² the squared whitened residual, the switch function Ψ(s) = s and the
prior s = 1 of variance 1/λ. It has no ½. ``switch`` and ``switched_cost`` follow the paper;
the cost of every ``Result`` is half of it, as everywhere in the library. Minimisers and
weights do not depend on the factor.

At fixed poses the optimal switch is s = λ/(λ + χ²), never exactly 0. Substituted into the
objective it leaves λχ²/(λ + χ²), which is twice the Geman–McClure kernel with c² = λ, and
the weight of the edge is s². The closed form is therefore IRLS with that kernel. The joint
form optimises poses and switches together, as the paper does.

Source: Sünderhauf and Protzel 2012, "Switchable constraints for robust pose graph SLAM".
"""

from dataclasses import dataclass, replace
from functools import cached_property
from math import sqrt
from typing import Self, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from robust_slam._arrays import Array, Mask, finite, positive, times
from robust_slam.descent.minimise import FIRST_DAMPING, damped
from robust_slam.descent.normal_equations import NormalEquations, linear_change
from robust_slam.descent.step import check_limits, is_small, retract
from robust_slam.estimators import kernels
from robust_slam.estimators.loop import Problem
from robust_slam.estimators.result import Result, Step, StopReason
from robust_slam.estimators.reweighting import irls
from robust_slam.estimators.thresholds import threshold_of
from robust_slam.graphs import pose_graph
from robust_slam.graphs.pose_graph import PoseGraph, check_poses
from robust_slam.problems import PoseGraphProblem

X = TypeVar("X")


def switch(chi2: ArrayLike, lam: float) -> Array:
    """Return the optimal switch s = λ/(λ + χ²) for squared whitened residuals χ².

    ``chi2`` has any shape, and the result has that shape. The weight of the edge is s², not s.

    Raises:
        ValueError: ``lam`` is not a finite number above zero, or a χ² is negative or not finite.

    Source: derived here, by setting the derivative 2sχ² − 2λ(1 − s) of the objective of
    Sünderhauf and Protzel 2012 to 0. The solution is always inside [0, 1].
    """
    lam = positive("lam", lam)
    return lam / (lam + _squares(chi2))


def switched_cost(chi2: ArrayLike, lam: float) -> Array:
    """Return the minimum of s²χ² + λ(1 − s)² over s: λχ²/(λ + χ²) < λ, of any shape.

    It has no ½: it is 2ρ(u) of ``kernels.geman_mcclure`` with c² = λ and u² = χ². Errors are as
    of ``switch``.

    Source: derived here, by substituting s = λ/(λ + χ²) into the objective.
    """
    return _squares(chi2) * switch(chi2, lam)


def dcs_switch(chi2: ArrayLike, phi: float) -> Array:
    """Return the switch min(1, 2Φ/(Φ + χ²)) of dynamic covariance scaling, of any shape.

    Beyond χ² = Φ it is twice the switch of λ = Φ, so it does not minimise that objective.
    The information of the edge is scaled by s².

    Raises:
        ValueError: ``phi`` is not a finite number above zero, or a χ² is negative or not finite.

    Source: Agarwal et al. 2013, the closed form of the scaling s.

    >>> dcs_switch([0.5, 1.0, 9.0], phi=1.0).round(3)
    array([1. , 1. , 0.2])
    """
    phi = positive("phi", phi)
    return np.minimum(1.0, 2.0 * phi / (phi + _squares(chi2)))


def _squares(chi2: ArrayLike) -> Array:
    squares = np.asarray(chi2, dtype=np.float64)
    if not np.all(np.isfinite(squares) & (squares >= 0.0)):
        raise ValueError("chi2: an entry is negative or not finite; give squared norms")
    return squares


def switchable(
    problem: Problem[X] | PoseGraph,
    lam: float | None = None,
    x0: X | None = None,
    *,
    probability: float = 0.99,
    tol: float | None = None,
    max_iterations: int = 100,
) -> Result[X]:
    """Minimise the switched cost by alternating the solve and the closed-form switches.

    The weights of the result are s², so the switches are their square roots. λ has the unit of χ²:
    an edge with χ² = λ has s = ½. By default it is the χ² that an inlier does not exceed with
    ``probability``. The start is ``x0``, or plain least squares, or dead reckoning where
    ``problem`` is a pose graph, as in ``irls``.

    Raises:
        ValueError: ``lam`` is not a finite number above zero, or as ``irls``.

    Source: Sünderhauf and Protzel 2012; the closed form is derived in ``switch``.

    >>> from robust_slam.problems import LocationProblem
    >>> result = switchable(LocationProblem([0.0, 0.1, 5.0]), lam=1.0, x0=0.0)
    >>> (result.weights**0.5).round(3)
    array([0.997, 0.998, 0.039])
    """
    c = threshold_of(problem, probability) if lam is None else sqrt(positive("lam", lam))
    return irls(problem, kernels.geman_mcclure(c), x0, tol=tol, max_iterations=max_iterations)


def joint_switchable(
    problem: PoseGraphProblem | PoseGraph,
    lam: float,
    x0: ArrayLike | None = None,
    s0: ArrayLike | None = None,
    *,
    damping: float = FIRST_DAMPING,
    tol: float = 1e-9,
    max_iterations: int = 500,
) -> Result[Array]:
    """Minimise the switched cost over poses and switches together.

    The poses start at ``x0`` ``(n, 3)`` or ``(n, 3, 4)``, by default plain least squares, or
    dead reckoning where ``problem`` is a graph, and the switches at ``s0`` ``(m,)``, by
    default 1; trusted edges have none and stay at 1. Each of at most ``max_iterations`` steps
    is a Gauss–Newton step on both. Switches are clipped to [0, 1]. The poses are damped,
    initially by ``damping`` (0 for a plain first step), more after a rejected step and less
    after a good one. The result has CONVERGED when an undamped step changes no switch by
    more than ``tol``, and no pose by more than ``gauss_newton`` allows with this ``tol``.

    The weights of a step are s², with s the switches at its poses.

    Raises:
        ValueError: an argument is out of range or has the wrong shape.
        Underdetermined: the trusted edges and those with s > 0 do not determine the map.
        NotConverged: plain least squares did not converge; give ``x0``.

    Source: Sünderhauf and Protzel 2012; Marquardt 1963, damping by the diagonal; Nielsen
    1999, the update of the damping by the gain ratio.
    """
    if isinstance(problem, PoseGraph):
        problem = PoseGraphProblem(problem)
        x0 = problem.guess if x0 is None else x0
    elif not isinstance(problem, PoseGraphProblem):
        given = type(problem).__name__
        raise TypeError(f"problem is a {given}; give a PoseGraph or a PoseGraphProblem")
    lam, damping = positive("lam", lam), _checked_damping(damping)
    check_limits(tol, max_iterations)
    poses = problem.initial() if x0 is None else check_poses("x0", x0, problem.graph)
    switches = _switches(s0, ~problem.trusted)
    start = _Switched(NormalEquations(problem.graph), ~problem.trusted, lam, poses, switches)
    history, stop = [], StopReason.ITERATION_LIMIT
    for taken in damped(start, tol, max_iterations, damping, ends_undamped=True):
        history.append(Step(taken.here.poses, taken.here.switches**2, taken.here.cost, None))
        if taken.converged:
            stop = StopReason.CONVERGED
    return Result.ending(history, stop)


def dcs(
    problem: Problem[X] | PoseGraph,
    phi: float | None = None,
    x0: X | None = None,
    *,
    probability: float = 0.99,
    tol: float | None = None,
    max_iterations: int = 100,
) -> Result[X]:
    """Run dynamic covariance scaling: IRLS with the weight s² of ``dcs_switch``.

    The cost is that of ``kernels.dcs`` with c² = Φ, whose weight is s². By default Φ is the χ²
    that an inlier does not exceed with ``probability``. Start and pose graphs are as in ``irls``.

    Raises:
        ValueError: ``phi`` is not a finite number above zero, or as ``irls``.

    Source: Agarwal et al. 2013, the closed form of the scaling s.
    """
    c = threshold_of(problem, probability) if phi is None else sqrt(positive("phi", phi))
    return irls(problem, kernels.dcs(c), x0, tol=tol, max_iterations=max_iterations)


def _checked_damping(damping: float) -> float:
    if not (np.isfinite(damping) and damping >= 0.0):
        raise ValueError(f"damping is {damping}; give a number of at least 0")
    return float(damping)


@dataclass(frozen=True, eq=False)
class _Switched:
    """The joint problem ½ Σ s²χ² + λ(1 − s)² at poses and switches; trusted ones keep s = 1."""

    equations: NormalEquations
    untrusted: Mask
    lam: float
    poses: Array
    switches: Array

    @cached_property
    def cost(self) -> float:
        chi2 = pose_graph.squared_norms(self.equations.graph, self.poses)
        prior = self.lam * (1.0 - self.switches) ** 2
        return 0.5 * float(np.sum(self.switches**2 * chi2 + prior))

    def moved(self, step: tuple[Array, Array]) -> Self:
        poses = retract(self.equations.graph, self.poses, step[0])
        return replace(self, poses=poses, switches=np.clip(self.switches + step[1], 0.0, 1.0))

    def is_small(self, step: tuple[Array, Array], tol: float) -> bool:
        return is_small(step[0], self.poses, tol) and bool(np.all(np.abs(step[1]) <= tol))

    def step(self, damping: float) -> tuple[tuple[Array, Array], float]:
        """Return the Gauss–Newton step of the poses ``(n, D)`` and of the switches ``(m,)``.

        Behind both is the decrease of the linearised cost.

        A switch belongs to one edge, so a Schur complement eliminates it exactly, and back
        substitution recovers it. Per edge, with v = Ωr, h = χ² + λ and the derivative
        g = sχ² − λ(1 − s) of the cost by s, the Schur complement is

            A = s²(Ω − v vᵀ/h),   p = (s² − s g/h) v,   δs = −(g + s vᵀJδ)/h.

        The derivative of s·r by s is r, not s·r, so a switch can leave s = 0.
        """
        graph, s = self.equations.graph, self.switches
        relative = pose_graph.relative_poses(graph, self.poses)
        r = pose_graph.residuals_of(graph, relative)
        jacobian = pose_graph.linearise(graph, relative, r)
        v = times(graph.information, r)
        chi2 = np.sum(r * v, axis=1)
        # A trusted edge has a switch of infinite stiffness: h = ∞ leaves A = Ω, p = Ωr.
        inverse = np.where(self.untrusted, 1.0 / (chi2 + self.lam), 0.0)
        slope = s * chi2 - self.lam * (1.0 - s)
        # A is positive semidefinite: with a = Ω^½ r it is s² Ω^½ (I − a aᵀ/(‖a‖² + λ)) Ω^½,
        # and the bracket has the eigenvalues λ/(‖a‖² + λ) > 0 and 1.
        shrunk = graph.information - inverse[:, None, None] * v[:, :, None] * v[:, None, :]
        weighted = (s**2 - s * slope * inverse)[:, None] * v
        reduced = s[:, None, None] ** 2 * shrunk
        system = self.equations.assemble(jacobian, reduced, weighted)
        step, decrease = self.equations.damped_step(*system, damping)
        change = linear_change(jacobian, graph, step)
        switch_step = -inverse * (slope + s * np.sum(v * change, axis=1))
        predicted = 0.5 * float(np.sum(inverse * slope**2)) + decrease
        return (step, switch_step), predicted


def _switches(s0: ArrayLike | None, untrusted: Mask) -> Array:
    m = untrusted.size
    given = np.ones(m) if s0 is None else finite("s0", s0, (m,))
    if np.any((given < 0.0) | (given > 1.0)):
        raise ValueError("s0: an entry is outside [0, 1]; give switches between 0 and 1")
    return np.where(untrusted, given, 1.0)
