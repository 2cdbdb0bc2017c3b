"""The sparse normal equations of a pose graph: (Σ w Jᵀ Ω J) δ = −Σ w Jᵀ Ω r."""

from __future__ import annotations

import numpy as np

from robust_slam._arrays import Array, Mask
from robust_slam.descent.sparse.pattern import by_pose, find_pattern
from robust_slam.descent.step import Place
from robust_slam.errors import Underdetermined
from robust_slam.graphs import pose_graph
from robust_slam.graphs.pose_graph import PoseGraph

_SPARE = 0.9
"""With a smaller share of the edges in use, a pattern of these alone pays for itself."""


class NormalEquations:
    """The linear step of a graph, with the pattern found at construction."""

    def __init__(self, graph: PoseGraph) -> None:
        self.graph = graph
        self.pattern = find_pattern(graph.n, graph.edges, graph.group.DOF)
        self._last_look = (np.empty(0), np.empty(0), np.empty(0))
        self._kept: tuple[Mask, _FewerEdges] | None = None

    def at(self, poses: Array, weights: Array) -> Place:
        """Return the place of ``poses``, each edge with its weight ``(m,)``."""
        return Place.of(self.graph, poses, *self.look(poses), weights)

    def look(self, poses: Array) -> tuple[Array, Array]:
        """Return what ``pose_graph.seen`` and ``errors`` say of all edges at ``poses``.

        The last look is kept: whoever asks for the norms at some poses often goes on from
        there.
        """
        last, predicted, r = self._last_look
        if not np.array_equal(last, poses):
            predicted = pose_graph.seen(poses, self.graph)
            r = pose_graph.errors(predicted, self.graph)
            self._last_look = (poses.copy(), predicted, r)
        return predicted, r

    def without_idle_edges(self, weights: Array) -> tuple[NormalEquations, Array]:
        """Return equations over fewer edges, and their weights.

        An edge of weight 0 adds nothing, but its blocks fill in. Where there are many, the
        rest of ``weights`` ``(m,)`` gets equations of its own. They are kept for the next
        call: from one set of weights to the next little changes.
        """
        used = weights > 0.0
        if used.sum() > _SPARE * used.size:
            return self, weights
        mask, smaller = self._kept or (np.zeros_like(used), None)
        if smaller is None or np.any(used & ~mask) or used.sum() <= _SPARE * mask.sum():
            mask, smaller = used, _FewerEdges(self, used)
            self._kept = mask, smaller
        return smaller, weights[mask]

    def step(self, place: Place, weights: Array) -> Array:
        """Return the Gauss–Newton step δ ``(n, D)`` from a place; row 0 is 0.

        ``weights`` ``(m,)`` multiply the information of the edges.

        Raises:
            Underdetermined: the matrix is singular to working precision.
        """
        return self.solve(*weighted_edges(self.graph, place, weights))

    def solve(
        self, jacobian: Array, information: Array, pull: Array, damping: float = 0.0
    ) -> Array:
        """Return the δ ``(n, D)`` with (H + damping·diag H) δ = −Σ Jᵀ p; row 0 is 0.

        H is Σ Jᵀ A J over the edges, with the derivatives J by both ends as the two factors
        ``(2, m, D, D)`` of ``pose_graph.linearise``, A ``(m, D, D)`` the ``information`` and p
        ``(m, D)`` the ``pull``.

        Raises:
            Underdetermined: the matrix is singular to working precision.
        """
        hessian, gradient = self.assemble(jacobian, information, pull)
        shift = damping * self.pattern.diagonal(hessian) if damping else None
        step = self.pattern.solve(hessian, -gradient, shift)
        if step is None or not np.all(np.isfinite(step)):
            raise Underdetermined(
                "the normal equations are singular to working precision: some edges weigh "
                "almost nothing beside the others; give such edges weight 0 or trust more edges"
            )
        return step

    def assemble(self, jacobian: Array, information: Array, pull: Array) -> tuple[Array, Array]:
        """Return Σ Jᵀ A J as the filled blocks of the pattern, and Σ Jᵀ p ``(n, D)``."""
        # With G = Jᵀ A J at pose j and the lever L the blocks of an edge are Lᵀ G L, Lᵀ G and
        # G. numpy multiplies stacks of small matrices fastest where all are stored by rows.
        turned = np.swapaxes(jacobian, 2, 3).copy()
        pieces = np.empty((3, *information.shape))
        np.matmul(turned[0], information @ jacobian[0], out=pieces[1])
        np.matmul(turned[1], pieces[1], out=pieces[2])
        np.matmul(pieces[2], jacobian[1], out=pieces[0])
        slopes = np.empty((2, *pull.shape, 1))
        np.matmul(turned[0], pull[..., None], out=slopes[1])
        np.matmul(turned[1], slopes[1], out=slopes[0])
        gradient = by_pose(self.graph.n, self.graph.edges, slopes[..., 0])
        return self.pattern.sum(pieces), gradient


class _FewerEdges(NormalEquations):
    """The equations over a part of the edges; it looks through the eyes of the whole."""

    def __init__(self, whole: NormalEquations, used: Mask) -> None:
        super().__init__(pose_graph.part(whole.graph, used))
        self._whole, self._used = whole, used

    def look(self, poses: Array) -> tuple[Array, Array]:
        """Return what the whole sees along the edges that are left."""
        predicted, r = self._whole.look(poses)
        return predicted[self._used], r[self._used]


def weighted_edges(graph: PoseGraph, place: Place, weights: Array) -> tuple[Array, Array, Array]:
    """Return what each edge brings to the normal equations of least squares at a place.

    These are the factors ``(2, m, D, D)`` of J, A = w Ω ``(m, D, D)`` and p = w Ω r ``(m, D)``.
    """
    jacobian = pose_graph.linearise(place.predicted, place.residuals, graph)
    return jacobian, weights[:, None, None] * graph.information, place.pull


def linear_change(jacobian: Array, graph: PoseGraph, step: Array) -> Array:
    """Return J δ ``(m, D)``: how a ``step`` δ ``(n, D)`` moves the linearised residuals."""
    at_i, at_j = step[graph.edges.T][..., None]
    by_j, lever = jacobian
    return np.asarray((by_j @ (lever @ at_i + at_j))[..., 0])


def linear_rise(change: Array, information: Array, pull: Array) -> float:
    """Return by how much the cost of the linearised residuals rises, Σ pᵀ e + ½ eᵀ A e.

    ``change`` ``(m, D)`` is e = J δ, and A and p are those of ``NormalEquations.solve``.
    """
    curved = 0.5 * (information @ change[..., None])[..., 0] + pull
    return float(np.sum(change * curved))
