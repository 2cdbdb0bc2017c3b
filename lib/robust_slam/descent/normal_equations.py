"""The sparse normal equations of a pose graph: (Σ w Jᵀ Ω J) δ = −Σ w Jᵀ Ω r.

Source: Grisetti et al. 2010, the linearised system and its sparse blocks.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from robust_slam._arrays import Array, Mask
from robust_slam.descent.sparse.choice import use_compiled
from robust_slam.descent.sparse.pattern import BlockPattern, find_pattern, sum_by_pose
from robust_slam.descent.step import Linearisation, retract
from robust_slam.errors import Underdetermined
from robust_slam.graphs import pose_graph
from robust_slam.graphs.pose_graph import PoseGraph

if TYPE_CHECKING:
    from robust_slam.descent.sparse.edges import CompiledEdges

_FULL_SHARE = 0.9
"""With a smaller share of edges of positive weight, a pattern of these alone is quicker."""


class NormalEquations:
    """The linear step of a graph; the sparsity pattern is found at construction.

    It is ``compiled``, or as ``use_compiled`` says if None. Results agree up to rounding.
    """

    def __init__(self, graph: PoseGraph, compiled: bool | None = None) -> None:
        self.graph = graph
        self.compiled = use_compiled(len(graph.edges)) if compiled is None else compiled
        self.pattern = find_pattern(graph.n, graph.edges, graph.group.DOF, compiled=self.compiled)
        self._edges = _compiled_edges(graph, self.pattern) if self.compiled else None
        self._restricted: tuple[Mask, NormalEquations] | None = None

    def at(self, poses: Array, weights: Array) -> Linearisation:
        """Return the linearisation at ``poses``, each edge with its weight ``(m,)``."""
        if self._edges is None:
            return Linearisation(self.graph, poses, weights)
        return _CompiledLinearisation(self.graph, poses, weights, self._edges)

    def retract(self, poses: Array, step: Array) -> Array:
        """Return each pose ∘ Exp(δ), with δ its row of ``step`` ``(n, D)``."""
        if self._edges is None:
            return retract(self.graph, poses, step)
        return self._edges.retract(poses, step)

    def residual_norms(self, poses: Array) -> Array:
        """Return the whitened residual norm of each edge, ``(m,)``."""
        if self._edges is None:
            return pose_graph.residual_norms(self.graph, poses)
        return np.sqrt(self._edges.squared_norms(poses))

    def restricted(self, weights: Array) -> tuple[NormalEquations, Array]:
        """Return equations over the edges of positive weight, and the weights of these edges.

        An edge of weight 0 contributes nothing, but its blocks cause fill-in. Where many of
        ``weights`` ``(m,)`` are 0, the other edges get equations and a pattern of their own.
        They are reused in later calls as long as they cover the edges of positive weight, so
        a few edges of weight 0 may remain. Otherwise the equations themselves are returned.
        """
        used = weights > 0.0
        if used.sum() > _FULL_SHARE * used.size:
            return self, weights
        if self._restricted is None or not _covers(self._restricted[0], used):
            smaller = NormalEquations(pose_graph.select(self.graph, used), self.compiled)
            self._restricted = used, smaller
        mask, smaller = self._restricted
        return smaller, weights[mask]

    def step(self, linearisation: Linearisation, weights: Array) -> Array:
        """Return the Gauss–Newton step δ ``(n, D)``; row 0 is 0.

        ``weights`` ``(m,)`` multiply the information of the edges.

        Raises:
            Underdetermined: the matrix is singular to working precision.
        """
        return self.minimise(*self.system(linearisation, weights))

    def system(self, linearisation: Linearisation, weights: Array) -> tuple[Array, Array]:
        """Return H = Σ w Jᵀ Ω J as the blocks of the pattern, and Σ w Jᵀ Ω r ``(n, D)``."""
        if self._edges is None:
            return self.assemble(*weighted_edges(self.graph, linearisation, weights))
        return self._edges.assemble(linearisation.poses, weights)

    def solve(
        self,
        jacobian: Array,
        information: Array,
        weighted_residuals: Array,
        damping: float = 0.0,
    ) -> Array:
        """Return the δ ``(n, D)`` with (H + damping·diag H) δ = −Σ Jᵀ p; row 0 is 0.

        H is Σ Jᵀ A J over the edges. ``jacobian`` ``(2, m, D, D)`` holds the two factors of J
        from ``pose_graph.linearise``, ``information`` is A ``(m, D, D)``, and
        ``weighted_residuals`` is p ``(m, D)``.

        Raises:
            Underdetermined: the matrix is singular to working precision.
        """
        hessian, gradient = self.assemble(jacobian, information, weighted_residuals)
        shift = damping * self.pattern.diagonal(hessian) if damping else None
        return self.minimise(hessian, gradient, shift)

    def minimise(self, hessian: Array, gradient: Array, shift: Array | None = None) -> Array:
        """Return the δ ``(n, D)`` with (H + diag(shift)) δ = −g; row 0 is 0.

        H and g are from ``system`` or ``assemble``, ``shift`` is ``(n, D)``.

        Raises:
            Underdetermined: the matrix is singular to working precision.
        """
        step = self.pattern.solve(hessian, -gradient, shift)
        if step is None or not np.all(np.isfinite(step)):
            raise Underdetermined(
                "the normal equations are singular to working precision: some edges weigh "
                "almost nothing beside the others; give such edges weight 0 or trust more edges"
            )
        return step

    def assemble(
        self, jacobian: Array, information: Array, weighted_residuals: Array
    ) -> tuple[Array, Array]:
        """Return Σ Jᵀ A J as the filled blocks of the pattern, and Σ Jᵀ p ``(n, D)``."""
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


@dataclass(frozen=True, eq=False)
class _CompiledLinearisation(Linearisation):
    """A linearisation whose cost is computed by the compiled kernels."""

    edges: CompiledEdges

    @cached_property
    def cost(self) -> float:
        """The cost ½ Σ w rᵀ Ω r."""
        return 0.5 * float(self.weights @ self.edges.squared_norms(self.poses))


def _compiled_edges(graph: PoseGraph, pattern: BlockPattern) -> CompiledEdges:
    from robust_slam.descent.sparse.edges import CompiledEdges

    return CompiledEdges(graph, pattern)


def _covers(mask: Mask, used: Mask) -> bool:
    """Tell whether ``mask`` contains all ``used`` edges and few others."""
    return not np.any(used & ~mask) and bool(used.sum() > _FULL_SHARE * mask.sum())


def weighted_edges(
    graph: PoseGraph, linearisation: Linearisation, weights: Array
) -> tuple[Array, Array, Array]:
    """Return what each edge contributes to the normal equations of least squares.

    These are the factors ``(2, m, D, D)`` of J, A = w Ω ``(m, D, D)`` and p = w Ω r ``(m, D)``,
    with ``weights`` w ``(m,)``.
    """
    jacobian = pose_graph.linearise(graph, linearisation.relative, linearisation.residuals)
    information = weights[:, None, None] * graph.information
    return jacobian, information, linearisation.weighted_residuals


def linear_change(jacobian: Array, graph: PoseGraph, step: Array) -> Array:
    """Return J δ ``(m, D)``: how a ``step`` δ ``(n, D)`` changes the linearised residuals."""
    at_i, at_j = step[graph.edges.T][..., None]
    by_j, transfer = jacobian
    return np.asarray((by_j @ (transfer @ at_i + at_j))[..., 0])


def linear_cost_change(change: Array, information: Array, weighted_residuals: Array) -> float:
    """Return the change of the linearised cost, Σ pᵀ e + ½ eᵀ A e.

    ``change`` ``(m, D)`` is e = J δ, ``information`` ``(m, D, D)`` is A and
    ``weighted_residuals`` ``(m, D)`` is p, as in ``NormalEquations.solve``.
    """
    integrand = 0.5 * (information @ change[..., None])[..., 0] + weighted_residuals
    return float(np.sum(change * integrand))
