"""The sparse normal equations of a pose graph: (Σ w Jᵀ Ω J) δ = −Σ w Jᵀ Ω r.

Which 3 × 3 blocks are filled, and in which order the poses are best eliminated, depends
on the edges alone. Both are found once per graph; each step then fills in the numbers and
factorises. Everything that could be made faster is behind ``NormalEquations.step``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csc_array, eye_array
from scipy.sparse.linalg import splu

from robust_slam import pose_graph
from robust_slam._arrays import Array, Indices
from robust_slam.loop import Underdetermined
from robust_slam.pose_graph import PoseGraph

_SYMMETRIC = {"SymmetricMode": True}


@dataclass(frozen=True, eq=False)
class BlockPattern:
    """Where the numbers of the edges go in the matrix, poses in elimination order.

    ``order`` ``(n − 1,)`` lists the free poses as they are eliminated. ``indptr`` and
    ``indices`` are those of the compressed columns. The flat edge blocks
    ``(m, 2, 2, 3, 3)``, over both ends twice, rows and columns, give their entries
    ``source`` to the places ``target``; blocks of the fixed pose 0 give none.
    """

    order: Indices
    indptr: Indices
    indices: Indices
    source: Indices
    target: Indices

    def matrix(self, blocks: Array) -> csc_array:
        """Return the sum of the edge blocks ``(m, 2, 2, 3, 3)`` as a sparse matrix."""
        size = 3 * self.order.size
        data = np.bincount(self.target, blocks.ravel()[self.source], self.indices.size)
        return csc_array((data, self.indices, self.indptr), shape=(size, size))


def find_pattern(n: int, edges: Indices) -> BlockPattern:
    """Return the pattern of a connected graph of ``n`` ≥ 2 poses with ``edges`` ``(m, 2)``."""
    order = _elimination_order(n, edges)
    slot = np.full(n, -1, dtype=np.intp)
    slot[order] = np.arange(n - 1)

    ends = slot[edges]
    row = np.broadcast_to(ends[:, :, None], (len(edges), 2, 2))
    column = np.broadcast_to(ends[:, None, :], (len(edges), 2, 2))
    free = (row >= 0) & (column >= 0)
    filled, block = np.unique(column[free] * (n - 1) + row[free], return_inverse=True)
    filled_column, filled_row = np.divmod(filled, n - 1)

    height = np.bincount(filled_column, minlength=n - 1)
    above = np.concatenate([[0], np.cumsum(height)])
    # Block number b is number b − above[column] of its column of blocks. A scalar column
    # holds 3 height entries, and the scalar columns of earlier blocks 9 above[column].
    first = 9 * above[filled_column] + 3 * (np.arange(filled.size) - above[filled_column])
    across, down = np.arange(3)[None, None, :], np.arange(3)[None, :, None]
    place = first[:, None, None] + 3 * height[filled_column][:, None, None] * across + down

    indices = np.empty(9 * filled.size, dtype=np.intp)
    indices[place] = np.broadcast_to(3 * filled_row[:, None, None] + down, place.shape)
    indptr = np.concatenate([[0], np.cumsum(np.repeat(3 * height, 3))])
    source = np.arange(36 * len(edges)).reshape(-1, 2, 2, 3, 3)[free]
    return BlockPattern(order, indptr, indices, source.ravel(), place[block].ravel())


def _elimination_order(n: int, edges: Indices) -> Indices:
    """Return the free poses in an order of little fill-in.

    SuperLU orders by minimum degree while it factorises, so it is given one number per
    pair of joined poses, in a matrix that needs no pivots.
    """
    i, j = edges[np.all(edges > 0, axis=1)].T - 1
    joined = csc_array((-np.ones(i.size), (i, j)), shape=(n - 1, n - 1))
    heavy = eye_array(n - 1, format="csc") * (2.0 * i.size + 1.0)
    dominant = csc_array(joined + joined.T + heavy)
    factors = splu(dominant, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=_SYMMETRIC)
    return np.asarray(np.argsort(factors.perm_c) + 1, dtype=np.intp)


class NormalEquations:
    """The linear step of a graph, with the pattern found at construction."""

    def __init__(self, graph: PoseGraph) -> None:
        self.graph = graph
        self.pattern = find_pattern(graph.n, graph.edges)

    def step(self, poses: Array, weights: Array) -> Array:
        """Return the Gauss–Newton step δ ``(n, 3)`` from ``poses``; row 0 is 0.

        ``weights`` ``(m,)`` multiply the information of the edges.

        Raises:
            Underdetermined: the matrix is singular to working precision.
        """
        hessian, gradient = self.assemble(poses, weights)
        step = np.zeros_like(poses)
        step[self.pattern.order] = -_solve(hessian, gradient).reshape(-1, 3)
        return step

    def assemble(self, poses: Array, weights: Array) -> tuple[csc_array, Array]:
        """Return Σ w Jᵀ Ω J and Σ w Jᵀ Ω r over the free poses, in elimination order."""
        jacobian = np.stack(pose_graph.jacobians(poses, self.graph), axis=1)
        weighted = weights[:, None, None] * self.graph.information
        left = np.swapaxes(jacobian, -1, -2) @ weighted[:, None]
        hessian = self.pattern.matrix(left[:, :, None] @ jacobian[:, None, :])
        r = pose_graph.residuals(poses, self.graph)
        pulls = (left @ r[:, None, :, None])[..., 0]
        gradient = np.zeros_like(poses)
        np.add.at(gradient, self.graph.edges, pulls)
        return hessian, gradient[self.pattern.order].ravel()


def _solve(hessian: csc_array, gradient: Array) -> Array:
    try:
        # The unknowns are in elimination order already, and a positive definite matrix
        # needs no pivots: SuperLU then does the work of a Cholesky factorisation.
        factors = splu(
            hessian, permc_spec="NATURAL", diag_pivot_thresh=0.0, relax=1, options=_SYMMETRIC
        )
        solution = factors.solve(gradient)
    except RuntimeError:
        solution = np.full_like(gradient, np.nan)
    if not np.all(np.isfinite(solution)):
        raise Underdetermined(
            "the normal equations are singular to working precision: some edges weigh "
            "almost nothing beside the others; give such edges weight 0 or trust more edges"
        )
    return solution
