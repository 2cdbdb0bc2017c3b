"""The sparsity pattern of the block matrix of a pose graph, and its factorisation.

Which blocks are filled depends on the edges alone and is computed once per graph. Each step
then sums the contributions of the edges and factorises.

Source: Davis 2006, chapters 2 and 4, assembly and symbolic analysis.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from robust_slam._arrays import Array, Indices, Mask
from robust_slam.descent.sparse.elimination import Elimination, find_elimination, find_fronts
from robust_slam.descent.sparse.multifrontal import Multifrontal, MultifrontalFactors
from robust_slam.descent.sparse.simplicial import Simplicial, SimplicialFactors

DENSE = 5500.0
"""Multiplications per pose above which dense fronts are faster than sparse columns."""


@dataclass(frozen=True, eq=False)
class BlockPattern:
    """The filled blocks of a symmetric matrix over ``n`` poses, pose 0 left out.

    Each of the other poses has ``block`` unknowns. ``order`` ``(n − 1,)`` is their
    elimination order. Only the blocks on and below the diagonal are stored: block k is in
    row ``row[k]`` and column ``column[k]``, positions in the elimination order, sorted by
    column and then by row. The matrix ``onto`` sums the contributions of the edges, those
    on the diagonal first and then the off-diagonal ones, where the edges of the mask
    ``flipped`` ``(m,)`` are transposed. ``method`` factorises.
    """

    n: int
    block: int
    order: Indices
    row: Indices
    column: Indices
    onto: csr_array
    flipped: Mask
    method: Simplicial | Multifrontal

    def sum(self, pieces: Array) -> Array:
        """Return the filled blocks ``(k, block, block)``, summed over the edges.

        ``pieces`` ``(3, m, block, block)`` are the contributions of the edges: the diagonal
        blocks at pose i, those at pose j, and the blocks in the rows of i and the columns
        of j. The last are transposed in place, so ``pieces`` must not be used again.
        """
        pieces[2, self.flipped] = np.swapaxes(pieces[2, self.flipped], 1, 2)
        total = self.onto @ pieces.reshape(-1, self.block**2)
        return np.asarray(total).reshape(-1, self.block, self.block)

    def sum_edges(self, blocks: Array) -> Array:
        """Return the filled blocks of symmetric edge blocks ``(m, 2, 2, block, block)``.

        They are indexed by the ends of rows and of columns.
        """
        return self.sum(np.stack([blocks[:, 0, 0], blocks[:, 1, 1], blocks[:, 0, 1]]))

    def diagonal(self, blocks: Array) -> Array:
        """Return the diagonal of the matrix ``(n, block)``; that of pose 0 is 0."""
        return self._by_pose(np.einsum("kaa->ka", blocks[self.row == self.column]))

    def factorise(self, blocks: Array, shift: Array | None = None) -> PoseFactors | None:
        """Return the factors of the matrix + diag(``shift``), or None.

        ``blocks`` ``(k, block, block)`` are from ``sum``; ``shift`` is ``(n, block)``, and
        its row 0 has no effect. None means that the matrix is not positive definite. The
        next factorisation on this pattern may invalidate the factors; using them then raises
        RuntimeError.
        """
        factors = self.method.factorise(self._shifted(blocks, shift))
        return None if factors is None else PoseFactors(self, factors)

    def solve(self, blocks: Array, right: Array, shift: Array | None = None) -> Array | None:
        """Factorise and solve as ``PoseFactors.solve`` does, or return None.

        ``right`` is ``(n, block, …)``. None means that the matrix is not positive definite, or
        so nearly that the solution overflows. This is faster than two separate calls.
        """
        chosen = right[self.order]
        flat = chosen.reshape(*chosen.shape[:2], -1)
        solved = self.method.solve(self._shifted(blocks, shift), flat)
        if solved is None or not np.all(np.isfinite(solved)):
            return None
        return self._by_pose(solved.reshape(chosen.shape))

    def _shifted(self, blocks: Array, shift: Array | None) -> Array:
        if shift is None:
            return blocks
        shifted, at = blocks.copy(), np.arange(self.block)
        diagonal = np.flatnonzero(self.row == self.column)
        shifted[diagonal[:, None], at, at] += shift[self.order]
        return shifted

    def _by_pose(self, values: Array) -> Array:
        full = np.zeros((self.n, *values.shape[1:]))
        full[self.order] = values
        return full


@dataclass(frozen=True, eq=False)
class PoseFactors:
    """Factors whose unknowns are indexed by pose; ``factors`` have them by their elimination."""

    pattern: BlockPattern
    factors: SimplicialFactors | MultifrontalFactors

    def solve(self, right: Array) -> Array:
        """Return the solution ``(n, block, …)`` for ``right`` of that shape; 0 at pose 0."""
        chosen = right[self.pattern.order]
        flat = self.factors.solve(chosen.reshape(*chosen.shape[:2], -1))
        return self.pattern._by_pose(flat.reshape(chosen.shape))

    @property
    def pivots(self) -> Array:
        """The pivots ``(n, block)``; 0 at pose 0."""
        return self.pattern._by_pose(self.factors.pivots)


def free_elimination(n: int, edges: Indices) -> Elimination:
    """Return the elimination of ``n`` ≥ 2 poses with ``edges`` ``(m, 2)``, without pose 0."""
    return find_elimination(n - 1, edges[np.all(edges > 0, axis=1)] - 1)


def find_pattern(
    n: int, edges: Indices, block: int, elimination: Elimination | None = None
) -> BlockPattern:
    """Return the pattern of a connected graph of ``n`` ≥ 2 poses with ``edges`` ``(m, 2)``.

    ``block`` is the number of unknowns of a pose. ``elimination`` is that of
    ``free_elimination``, which is computed if None.
    """
    _keep_freed_memory()
    elimination = elimination or free_elimination(n, edges)
    dense = elimination.multiplications * block**3 > DENSE * n
    fronts = find_fronts(elimination, block) if dense else None
    order = 1 + (elimination.order if fronts is None else fronts.order)
    position = np.full(n, -1, dtype=np.intp)
    position[order] = np.arange(n - 1)
    ends = position[edges]
    row, column, onto = _filled(ends, n - 1)
    flipped = ends[:, 0] < ends[:, 1]
    method = (
        Simplicial(block, n - 1, row, column)
        if fronts is None
        else Multifrontal(block, fronts, row, column)
    )
    return BlockPattern(n, block, order, row, column, onto, flipped, method)


def _keep_freed_memory() -> None:
    """Raise the size from which the C library returns freed arrays to the system.

    glibc raises that limit to the size of a freed allocation, up to 32 MiB. Below it each
    step reuses the memory of the last one; above it each step maps new pages, which made
    Gauss–Newton a tenth slower. The pages of this array are never touched.
    """
    np.empty(4_000_000)


def sum_by_pose(n: int, edges: Indices, values: Array) -> Array:
    """Return the sum ``(n, …)`` of the edge contributions at each of ``n`` poses.

    ``values`` ``(2, m, …)`` are the contributions to poses i and j of ``edges`` ``(m, 2)``.
    """
    ends = edges.T.ravel()
    columns = values.reshape(ends.size, -1).T
    total = np.stack([np.bincount(ends, column, n) for column in columns], axis=-1)
    return np.asarray(total.reshape(n, *values.shape[2:]))


def _filled(ends: Indices, size: int) -> tuple[Indices, Indices, csr_array]:
    """Return rows and columns of the filled blocks, and the matrix that sums the edges.

    ``ends`` ``(m, 2)`` are positions in the elimination order, −1 for pose 0.
    """
    row = np.concatenate([ends.T.ravel(), np.maximum(*ends.T)])
    column = np.concatenate([ends.T.ravel(), np.minimum(*ends.T)])
    free = np.flatnonzero(column >= 0)
    block = column[free] * size + row[free]
    by_block = np.argsort(block, kind="stable")
    sorted_blocks = block[by_block]
    first = np.flatnonzero(np.diff(sorted_blocks, prepend=-1))
    starts = np.append(first, free.size)
    onto = csr_array((np.ones(free.size), free[by_block], starts), shape=(first.size, row.size))
    filled = sorted_blocks[first]
    return filled % size, filled // size, onto
