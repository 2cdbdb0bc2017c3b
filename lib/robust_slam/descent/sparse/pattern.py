"""Where the numbers of the edges go in the matrix of a pose graph, and its factors.

Which blocks are filled depends on the edges alone. It is found once per graph; each step
then adds up the numbers and factorises.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy.sparse import csr_array

from robust_slam._arrays import Array, Indices, Mask
from robust_slam.descent.sparse.elimination import Elimination, find_elimination, find_fronts
from robust_slam.descent.sparse.multifrontal import Multifrontal
from robust_slam.descent.sparse.simplicial import Simplicial

_DENSE = 5500.0
"""So many multiplications for each pose, and dense fronts are quicker than sparse columns."""


class Factors(Protocol):
    """A positive definite matrix, factorised, over poses in the order of elimination."""

    @property
    def pivots(self) -> Array:
        """What was left of the diagonal ``(n − 1, b)`` when its turn came, all above 0."""
        ...

    def solve(self, right: Array) -> Array:
        """Return the solutions ``(n − 1, b, c)`` of c right-hand sides at once."""
        ...


@dataclass(frozen=True, eq=False)
class BlockPattern:
    """The filled blocks of a symmetric matrix over ``n`` poses, pose 0 left out.

    Each of the others has ``block`` unknowns. ``order`` ``(n − 1,)`` lists them as they
    are eliminated. Only the blocks on and below the diagonal are kept: number k stands in
    row ``row[k]`` and column ``column[k]``, places in that order, sorted by column and then
    by row. ``onto`` adds up what the edges bring, first at their ends and then across,
    where those of ``flipped`` ``(m,)`` are transposed. ``method`` factorises.
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
        """Return the filled blocks ``(k, block, block)`` that the edges add up to.

        ``pieces`` ``(3, m, block, block)`` are what they bring: the blocks on the diagonal
        at pose i, those at pose j, and those in the rows of i and the columns of j. The
        last are turned in place, so the pieces are used up.
        """
        pieces[2, self.flipped] = np.swapaxes(pieces[2, self.flipped], 1, 2)
        total = self.onto @ pieces.reshape(-1, self.block**2)
        return np.asarray(total).reshape(-1, self.block, self.block)

    def diagonal(self, blocks: Array) -> Array:
        """Return the diagonal of the matrix ``(n, block)``; that of pose 0 is 0."""
        return self._by_pose(np.einsum("kaa->ka", blocks[self.row == self.column]))

    def factorise(self, blocks: Array, shift: Array | None = None) -> PoseFactors | None:
        """Return the factors of the matrix + diag(``shift``), or None.

        ``blocks`` are from ``sum``; ``shift`` is ``(n, block)``, that of pose 0 without
        effect. None says that the matrix is not positive definite. With the next
        factorisation on this pattern the factors may become stale, and say so.
        """
        factors = self.method.factorise(self._shifted(blocks, shift))
        return None if factors is None else PoseFactors(self, factors)

    def solve(self, blocks: Array, right: Array, shift: Array | None = None) -> Array | None:
        """Return what ``PoseFactors.solve`` does, or None where there are no factors.

        In one go this is quicker than to factorise and solve.
        """
        chosen = right[self.order]
        flat = chosen.reshape(*chosen.shape[:2], -1)
        solved = self.method.solve(self._shifted(blocks, shift), flat)
        return None if solved is None else self._by_pose(solved.reshape(chosen.shape))

    def _shifted(self, blocks: Array, shift: Array | None) -> Array:
        if shift is None:
            return blocks
        moved, at = blocks.copy(), np.arange(self.block)
        own = np.flatnonzero(self.row == self.column)
        moved[own[:, None], at, at] += shift[self.order]
        return moved

    def _by_pose(self, values: Array) -> Array:
        full = np.zeros((self.n, *values.shape[1:]))
        full[self.order] = values
        return full


@dataclass(frozen=True, eq=False)
class PoseFactors:
    """Factors whose unknowns are called by their poses."""

    pattern: BlockPattern
    factors: Factors

    def solve(self, right: Array) -> Array:
        """Return the solution ``(n, block, …)``, 0 at pose 0, for right-hand sides like it."""
        chosen = right[self.pattern.order]
        flat = self.factors.solve(chosen.reshape(*chosen.shape[:2], -1))
        return self.pattern._by_pose(flat.reshape(chosen.shape))

    @property
    def pivots(self) -> Array:
        """What was left of the diagonal, ``(n, block)``; 0 at pose 0."""
        return self.pattern._by_pose(self.factors.pivots)


def free_elimination(n: int, edges: Indices) -> Elimination:
    """Return the elimination of ``n`` ≥ 2 poses with ``edges`` ``(m, 2)``, pose 0 left out."""
    return find_elimination(n - 1, edges[np.all(edges > 0, axis=1)] - 1)


def find_pattern(
    n: int, edges: Indices, block: int, elimination: Elimination | None = None
) -> BlockPattern:
    """Return the pattern of a connected graph of ``n`` ≥ 2 poses with ``edges`` ``(m, 2)``.

    ``block`` is the number of unknowns of a pose; ``elimination``, where it is known, is
    that of ``free_elimination``.
    """
    elimination = elimination or free_elimination(n, edges)
    dense = elimination.multiplications * block**3 > _DENSE * n
    fronts = find_fronts(elimination, block) if dense else None
    order = (elimination.order if fronts is None else fronts.order) + 1
    place = np.full(n, -1, dtype=np.intp)
    place[order] = np.arange(n - 1)
    ends = place[edges]
    row, column, onto = _filled(ends, n - 1)
    method = (
        Simplicial(block, n - 1, row, column)
        if fronts is None
        else Multifrontal(block, fronts, row, column)
    )
    flipped = ends[:, 0] < ends[:, 1]
    return BlockPattern(n, block, order, row, column, onto, flipped, method)


def by_pose(n: int, edges: Indices, values: Array) -> Array:
    """Return for each of ``n`` poses the sum ``(n, …)`` of what the edges bring to it.

    ``values`` ``(2, m, …)`` are theirs for pose i and for pose j of ``edges`` ``(m, 2)``.
    """
    ends = edges.T.ravel()
    columns = values.reshape(ends.size, -1).T
    total = np.stack([np.bincount(ends, column, n) for column in columns], axis=-1)
    return np.asarray(total.reshape(n, *values.shape[2:]))


def pieces_of(blocks: Array) -> Array:
    """Return the pieces ``(3, m, b, b)`` of ``sum`` of symmetric edge blocks.

    ``blocks`` ``(m, 2, 2, b, b)`` go over both ends twice, rows and columns.
    """
    return np.stack([blocks[:, 0, 0], blocks[:, 1, 1], blocks[:, 0, 1]])


def _filled(ends: Indices, size: int) -> tuple[Indices, Indices, csr_array]:
    """Return rows and columns of the filled blocks, and what adds the edges up to them.

    ``ends`` ``(m, 2)`` are places of poses, −1 for the one that is left out.
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
