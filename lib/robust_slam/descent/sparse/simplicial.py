"""Sparse Cholesky factorisation column by column, by the library QDLDL or its stand-in.

It is the faster method where the columns of the factor are short: on graphs in the plane.

Source: Davis 2005, "Algorithm 849: a concise sparse Cholesky factorization package";
Stellato et al. 2020, "OSQP", for QDLDL.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import bsr_array, csc_array

from robust_slam._arrays import Array, Indices
from robust_slam.descent.sparse.ldl import Solver, SuperLU


class Simplicial:
    """Factorises matrices of ``size`` block rows, ``row`` and ``column`` as in the pattern.

    Symbolic analysis and memory are reused, so factors are valid until the next
    factorisation.
    """

    def __init__(self, block: int, size: int, row: Indices, column: Indices) -> None:
        self.shape = (size, block)
        by_row = np.argsort(row, kind="stable")
        starts = np.concatenate([[0], np.cumsum(np.bincount(row, minlength=size))])
        number = np.arange(row.size * block**2).reshape(-1, block, block)
        lower = bsr_array((number[by_row], column[by_row], starts)).tocsr()
        # QDLDL takes the columns of the upper triangle, which are our rows up to the diagonal.
        inside = np.repeat(np.arange(size * block), np.diff(lower.indptr)) >= lower.indices
        self._source = lower.data[inside]
        starts = np.concatenate([[0], np.cumsum(inside)])[lower.indptr]
        numbers = np.ones(self._source.size)
        self._matrix = csc_array((numbers, lower.indices[inside], starts), shape=lower.shape)
        self._solver: Solver | None = None
        self._count = 0

    def __getstate__(self) -> dict[str, object]:
        # QDLDL's solver cannot be pickled; the next factorisation makes a new one.
        return {**self.__dict__, "_solver": None}

    def solve(self, blocks: Array, right: Array) -> Array | None:
        """Return the solutions ``(n − 1, b, c)``, or None if not positive definite."""
        factors = self.factorise(blocks)
        return None if factors is None else factors.solve(right)

    def factorise(self, blocks: Array) -> SimplicialFactors | None:
        """Return the factors of ``blocks`` ``(k, b, b)``, or None if not positive definite."""
        np.take(blocks.ravel(), self._source, out=self._matrix.data)
        self._count += 1
        try:
            if self._solver is None:
                self._solver = Solver(self._matrix, upper=True)
            else:
                self._solver.update(self._matrix, upper=True)
        except RuntimeError:
            return None
        # An update that meets a pivot of 0 stops there without an error.
        _, pivots, _ = self._solver.factors()
        return SimplicialFactors(self, self._count) if pivots.min() > 0.0 else None

    def solver(self, number: int) -> Solver:
        """Return QDLDL's solver if it holds the factors of factorisation ``number``.

        Raises:
            RuntimeError: another matrix was factorised since.
        """
        if number != self._count or self._solver is None:
            raise RuntimeError("the factors are stale: another matrix was factorised since")
        return self._solver


@dataclass(frozen=True, eq=False)
class SimplicialFactors:
    """Factors in the memory of QDLDL, over poses in the order of elimination.

    Its methods raise RuntimeError where ``Simplicial.solver`` does.
    """

    owner: Simplicial
    number: int

    @property
    def pivots(self) -> Array:
        """The diagonal of the factors, ``(n − 1, b)``."""
        _, diagonal, order = self.owner.solver(self.number).factors()
        pivots = np.empty(diagonal.size)
        pivots[order] = diagonal
        return pivots.reshape(self.owner.shape)

    def solve(self, right: Array) -> Array:
        """Return the solutions ``(n − 1, b, c)``."""
        solver = self.owner.solver(self.number)
        columns = right.reshape(-1, right.shape[-1])
        if isinstance(solver, SuperLU):  # QDLDL takes one at a time
            return solver.solve(columns).reshape(right.shape)
        each = [solver.solve(column) for column in columns.T]
        return np.stack(each, axis=-1).reshape(right.shape)
