"""Sparse symmetric matrices with one square block for each pose and each joined pair.

Which blocks are filled, and in which order the poses are best eliminated, depends on the
edges alone. Both are found once per graph; each step then fills in the numbers and
factorises. A faster factorisation replaces ``factorise`` and nothing else.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csc_array, eye_array
from scipy.sparse.linalg import SuperLU, splu

from robust_slam._arrays import Array, Indices

_SYMMETRIC = {"SymmetricMode": True}


@dataclass(frozen=True, eq=False)
class BlockPattern:
    """Where the numbers of the edges go in the matrix, poses in elimination order.

    ``order`` ``(n − 1,)`` lists the free poses as they are eliminated, each with a block
    of ``block`` unknowns. ``indptr`` and ``indices`` are those of the compressed columns.
    The flat edge blocks ``(m, 2, 2, block, block)``, over both ends twice, rows and
    columns, give their entries ``source`` to the places ``target``; blocks of the fixed
    pose 0 give none.
    """

    order: Indices
    block: int
    indptr: Indices
    indices: Indices
    source: Indices
    target: Indices

    def matrix(self, blocks: Array) -> csc_array:
        """Return the sum of the edge blocks ``(m, 2, 2, block, block)`` as a sparse matrix."""
        size = self.block * self.order.size
        data = np.bincount(self.target, blocks.ravel()[self.source], self.indices.size)
        return csc_array((data, self.indices, self.indptr), shape=(size, size))


def find_pattern(n: int, edges: Indices, block: int) -> BlockPattern:
    """Return the pattern of a connected graph of ``n`` ≥ 2 poses with ``edges`` ``(m, 2)``.

    ``block`` is the number of unknowns of a pose.
    """
    order = _elimination_order(n, edges)
    slot = np.full(n, -1, dtype=np.intp)
    slot[order] = np.arange(n - 1)

    ends = slot[edges]
    row = np.broadcast_to(ends[:, :, None], (len(edges), 2, 2))
    column = np.broadcast_to(ends[:, None, :], (len(edges), 2, 2))
    free = (row >= 0) & (column >= 0)
    filled, at = np.unique(column[free] * (n - 1) + row[free], return_inverse=True)
    filled_column, filled_row = np.divmod(filled, n - 1)

    height = np.bincount(filled_column, minlength=n - 1)
    above = np.concatenate([[0], np.cumsum(height)])
    # Block number k is number k − above[column] of its column of blocks. A scalar column
    # holds block·height entries, the scalar columns before it block²·above[column].
    inside = np.arange(filled.size) - above[filled_column]
    first = block**2 * above[filled_column] + block * inside
    across, down = np.arange(block)[None, None, :], np.arange(block)[None, :, None]
    stride = block * height[filled_column]
    place = first[:, None, None] + stride[:, None, None] * across + down

    indices = np.empty(block**2 * filled.size, dtype=np.intp)
    indices[place] = np.broadcast_to(block * filled_row[:, None, None] + down, place.shape)
    indptr = np.concatenate([[0], np.cumsum(np.repeat(block * height, block))])
    source = np.arange(4 * block**2 * len(edges)).reshape(-1, 2, 2, block, block)[free]
    return BlockPattern(order, block, indptr, indices, source.ravel(), place[at].ravel())


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


def factorise(matrix: csc_array) -> SuperLU:
    """Return the factors of a symmetric matrix whose unknowns are in elimination order.

    No pivots are sought: for a positive definite matrix this is the work of a Cholesky
    factorisation, and the matrix is positive definite exactly if the diagonal of the
    factor U is positive.

    Raises:
        RuntimeError: a pivot is exactly 0.
    """
    return splu(matrix, permc_spec="NATURAL", diag_pivot_thresh=0.0, relax=1, options=_SYMMETRIC)
