"""The sparse normal equations of a pose graph: (Σ w Jᵀ Ω J) δ = −Σ w Jᵀ Ω r.

Everything that could be made faster is behind ``NormalEquations.solve``.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import csc_array, diags_array

from robust_slam import pose_graph
from robust_slam._arrays import Array
from robust_slam._block_pattern import factorise, find_pattern
from robust_slam.errors import Underdetermined
from robust_slam.pose_graph import PoseGraph


class NormalEquations:
    """The linear step of a graph, with the pattern found at construction."""

    def __init__(self, graph: PoseGraph) -> None:
        self.graph = graph
        self.pattern = find_pattern(graph.n, graph.edges, graph.group.DOF)

    def step(self, poses: Array, weights: Array, damping: float = 0.0) -> Array:
        """Return the Gauss–Newton step δ ``(n, D)`` from ``poses``; row 0 is 0.

        ``weights`` ``(m,)`` multiply the information of the edges. ``damping`` is that of
        ``solve``.

        Raises:
            Underdetermined: the matrix is singular to working precision.
        """
        return self.solve(*weighted_edges(self.graph, poses, weights), damping)

    def solve(
        self, jacobian: Array, information: Array, pull: Array, damping: float = 0.0
    ) -> Array:
        """Return the δ ``(n, D)`` with (H + damping·diag H) δ = −Σ Jᵀ p; row 0 is 0.

        H is Σ Jᵀ A J over the edges, with J ``(m, 2, D, D)`` the derivatives by both ends,
        A ``(m, D, D)`` the ``information`` and p ``(m, D)`` the ``pull``.

        Raises:
            Underdetermined: the matrix is singular to working precision.
        """
        hessian, gradient = self.assemble(jacobian, information, pull)
        if damping:
            hessian = csc_array(hessian + diags_array(damping * hessian.diagonal()))
        step = np.zeros((self.graph.n, self.pattern.block))
        step[self.pattern.order] = -_solve(hessian, gradient).reshape(-1, self.pattern.block)
        return step

    def assemble(
        self, jacobian: Array, information: Array, pull: Array
    ) -> tuple[csc_array, Array]:
        """Return Σ Jᵀ A J and Σ Jᵀ p over the free poses, in elimination order."""
        left = np.swapaxes(jacobian, -1, -2)
        hessian = self.pattern.matrix(
            (left @ information[:, None])[:, :, None] @ jacobian[:, None]
        )
        gradient = np.zeros((self.graph.n, self.pattern.block))
        np.add.at(gradient, self.graph.edges, (left @ pull[:, None, :, None])[..., 0])
        return hessian, gradient[self.pattern.order].ravel()


def weighted_edges(graph: PoseGraph, poses: Array, weights: Array) -> tuple[Array, Array, Array]:
    """Return what each edge brings to the normal equations of least squares.

    These are J ``(m, 2, D, D)``, A = w Ω ``(m, D, D)`` and p = w Ω r ``(m, D)``.
    """
    r, jacobian = pose_graph.linearise(poses, graph)
    information = weights[:, None, None] * graph.information
    return jacobian, information, (information @ r[..., None])[..., 0]


def _solve(hessian: csc_array, gradient: Array) -> Array:
    try:
        solution = factorise(hessian).solve(gradient)
    except RuntimeError:
        solution = np.full_like(gradient, np.nan)
    if not np.all(np.isfinite(solution)):
        raise Underdetermined(
            "the normal equations are singular to working precision: some edges weigh "
            "almost nothing beside the others; give such edges weight 0 or trust more edges"
        )
    return solution
