"""The sparse normal equations of a pose graph: (Σ w Jᵀ Ω J) δ = −Σ w Jᵀ Ω r.

Source: Grisetti et al. 2010, the linearised system and its sparse blocks.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from robust_slam._arrays import Array, Mask, times
from robust_slam.descent.sparse.pattern import BlockPattern, PoseFactors, find_pattern, sum_by_pose
from robust_slam.descent.step import is_small, retract
from robust_slam.errors import singular
from robust_slam.graphs import pose_graph
from robust_slam.graphs.pose_graph import PoseGraph

FULL_SHARE = 0.9
"""With a smaller share of edges of positive weight, a pattern of these alone is quicker."""


@dataclass(frozen=True, eq=False)
class Residuals:
    """The residuals of ``graph`` at ``poses`` ``(n, …)``, each part when it is first used."""

    graph: PoseGraph
    poses: Array

    @cached_property
    def relative(self) -> Array:
        """The ``pose_graph.relative_poses``, ``(m, 3)`` or ``(m, 3, 4)``."""
        return pose_graph.relative_poses(self.graph, self.poses)

    @cached_property
    def r(self) -> Array:
        """The residuals r ``(m, D)``, not whitened."""
        return pose_graph.residuals_of(self.graph, self.relative)

    @cached_property
    def applied(self) -> Array:
        """The products Ω r ``(m, D)``."""
        return times(self.graph.information, self.r)

    @cached_property
    def norms(self) -> Array:
        """The whitened residual norms u ``(m,)``."""
        squared = np.sum(self.r * self.applied, axis=1)
        return np.asarray(np.sqrt(np.maximum(squared, 0.0)))


@dataclass(frozen=True, eq=False)
class Linearisation:
    """Weighted least squares at given poses: ``residuals``, and their ``weights`` ``(m,)``."""

    equations: NormalEquations
    residuals: Residuals
    weights: Array

    @property
    def poses(self) -> Array:
        """The poses, ``(n, 3)`` or ``(n, 3, 4)``."""
        return self.residuals.poses

    @cached_property
    def cost(self) -> float:
        """The cost ½ Σ w rᵀ Ω r."""
        return 0.5 * float(np.sum(self.residuals.r * self.weighted_residuals))

    @cached_property
    def weighted_residuals(self) -> Array:
        """The w Ω r ``(m, D)``."""
        return np.asarray(self.weights[:, None] * self.residuals.applied)

    @property
    def system(self) -> tuple[Array, Array]:
        """H = Σ w Jᵀ Ω J as the blocks of the pattern, and Σ w Jᵀ Ω r ``(n, D)``.

        It is not kept: the next one reuses its memory.
        """
        graph, residuals = self.equations.graph, self.residuals
        jacobian = pose_graph.linearise(graph, residuals.relative, residuals.r)
        information = self.weights[:, None, None] * graph.information
        return self.equations.assemble(jacobian, information, self.weighted_residuals)

    def step(self, damping: float = 0.0) -> tuple[Array, float]:
        """Return the ``damped_step``, without ``damping`` that of Gauss–Newton."""
        return self.equations.damped_step(*self.system, damping)

    def moved(self, step: Array) -> Linearisation:
        """Return it at each pose ∘ Exp(δ), with δ its row of ``step`` ``(n, D)``."""
        equations = self.equations
        return equations.at(retract(equations.graph, self.poses, step), self.weights)

    def is_small(self, step: Array, tol: float) -> bool:
        """Tell whether a ``step`` ``(n, D)`` moves nothing by more than ``tol`` allows."""
        return is_small(step, self.poses, tol)


class NormalEquations:
    """The linear step of a graph; the sparsity pattern is found when it is first needed.

    Often it never is, because only the ``restricted`` equations are solved.
    """

    def __init__(self, graph: PoseGraph) -> None:
        self.graph = graph
        self._restricted: tuple[Mask, NormalEquations] | None = None
        self._last: Residuals | None = None

    @cached_property
    def pattern(self) -> BlockPattern:
        """The sparsity pattern of all edges, with what factorises."""
        graph = self.graph
        return find_pattern(graph.n, graph.edges, graph.group.DOF)

    def residuals(self, poses: Array) -> Residuals:
        """Return the residuals at ``poses``, ``(n, 3)`` or ``(n, 3, 4)``.

        The last ones are kept: a robust solve asks for those of the same poses three times.
        """
        if self._last is None or not np.array_equal(self._last.poses, poses):
            self._last = Residuals(self.graph, poses.copy())
        return self._last

    def residual_norms(self, poses: Array) -> Array:
        """Return the whitened residual norm of each edge, ``(m,)``."""
        return self.residuals(poses).norms

    def at(self, poses: Array, weights: Array) -> Linearisation:
        """Return the linearisation at ``poses``, each edge with its weight ``(m,)``."""
        return Linearisation(self, self.residuals(poses), weights)

    def start(self, poses: Array, weights: Array) -> Linearisation:
        """Return the linearisation of the ``restricted`` equations at ``poses`` ``(n, …)``."""
        equations, weights = self.restricted(weights)
        return equations.at(poses, weights)

    def restricted(self, weights: Array) -> tuple[NormalEquations, Array]:
        """Return equations over the edges of positive weight, and the weights of these edges.

        An edge of weight 0 contributes nothing, but its blocks cause fill-in. Where many of
        ``weights`` ``(m,)`` are 0, the other edges get equations and a pattern of their own.
        They are reused in later calls as long as they cover the edges of positive weight, so
        a few edges of weight 0 may remain. Otherwise the equations themselves are returned.
        """
        used = weights > 0.0
        if used.sum() > FULL_SHARE * used.size:
            return self, weights
        held = self._restricted
        if held is None or np.any(used & ~held[0]) or used.sum() <= FULL_SHARE * held[0].sum():
            held = self._restricted = used, NormalEquations(pose_graph.select(self.graph, used))
        mask, smaller = held
        return smaller, weights[mask]

    def factorise(self, linearisation: Linearisation) -> tuple[PoseFactors, Array]:
        """Return the factors of H, and the gradient ``(n, D)``, both of its ``system``.

        Raises:
            Underdetermined: the matrix is singular to working precision.
        """
        hessian, gradient = linearisation.system
        factors = self.pattern.factorise(hessian)
        if factors is None:
            raise singular("the normal equations are")
        return factors, gradient

    def damped_step(self, hessian: Array, gradient: Array, damping: float) -> tuple[Array, float]:
        """Return the δ ``(n, D)`` with (H + S) δ = −g, and the decrease of the linearised cost.

        H and g are from ``assemble``, and S is ``damping`` times the diagonal of H.
        The decrease is ½ δᵀ (S δ − g). Row 0 of δ is 0.

        Raises:
            Underdetermined: the matrix is singular to working precision.

        Source: Nielsen 1999, the denominator of the gain ratio.
        """
        shift = damping * self.pattern.diagonal(hessian) if damping else None
        step = self.pattern.solve(hessian, -gradient, shift)
        if step is None:
            raise singular("the normal equations are")
        held = 0.0 if shift is None else shift * step
        return step, 0.5 * float(np.sum(step * (held - gradient)))

    def assemble(
        self, jacobian: Array, information: Array, weighted_residuals: Array
    ) -> tuple[Array, Array]:
        """Return Σ Jᵀ A J as the filled blocks of the pattern, and Σ Jᵀ p ``(n, D)``.

        ``jacobian`` ``(2, m, D, D)`` holds the two factors of J from ``pose_graph.linearise``,
        ``information`` is A ``(m, D, D)``, and ``weighted_residuals`` is p ``(m, D)``.
        """
        # With J_i = J_j T and G = J_jᵀ A J_j, the blocks of an edge are Tᵀ G T, Tᵀ G and G.
        # numpy multiplies stacks of small matrices fastest where all are stored by rows.
        transposed = np.swapaxes(jacobian, 2, 3).copy()
        pieces = np.empty((3, *information.shape))
        np.matmul(transposed[0], information @ jacobian[0], out=pieces[1])
        np.matmul(transposed[1], pieces[1], out=pieces[2])
        np.matmul(pieces[2], jacobian[1], out=pieces[0])
        gradients = np.empty((2, *weighted_residuals.shape, 1))
        np.matmul(transposed[0], weighted_residuals[..., None], out=gradients[1])
        np.matmul(transposed[1], gradients[1], out=gradients[0])
        gradient = sum_by_pose(self.graph.n, self.graph.edges, gradients[..., 0])
        return self.pattern.sum(pieces), gradient


def linear_change(jacobian: Array, graph: PoseGraph, step: Array) -> Array:
    """Return J δ ``(m, D)``: how a ``step`` δ ``(n, D)`` changes the linearised residuals."""
    at_i, at_j = step[graph.edges.T][..., None]
    by_j, transfer = jacobian
    return np.asarray((by_j @ (transfer @ at_i + at_j))[..., 0])
