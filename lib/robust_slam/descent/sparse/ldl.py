"""LDLᵀ factorisation of sparse symmetric matrices, by QDLDL or by SciPy.

QDLDL has no wheel for WebAssembly, so Python in the browser uses SciPy's SuperLU. ``Solver``
is QDLDL's where it is installed, and ``SuperLU`` elsewhere.

Source: Li 2005, "An overview of SuperLU", for its symmetric mode; Stellato et al. 2020, "OSQP",
for QDLDL.
"""

from typing import Literal

import numpy as np
from scipy.sparse import csc_array, triu
from scipy.sparse.linalg import splu

from robust_slam._arrays import Array, Indices


class SuperLU:
    """Factorises matrices, with the methods of ``qdldl.Solver`` that are used here.

    Raises:
        RuntimeError: a pivot is 0, so the matrix is not definite.
    """

    def __init__(self, matrix: csc_array, upper: bool = True) -> None:
        number = csc_array(
            (np.arange(1.0, matrix.nnz + 1.0), matrix.indices, matrix.indptr), matrix.shape
        )
        self._whole = csc_array(number + triu(number, k=1).T) if upper else number
        self._whole.sort_indices()
        self._source = self._whole.data.astype(np.intp) - 1
        self._factorise(matrix, "MMD_AT_PLUS_A")

    def update(self, matrix: csc_array, upper: bool = True) -> None:
        """Factorise another matrix ``(n, n)`` with entries in the same places.

        Its rows are eliminated as they come, since ``Simplicial`` has them in an order of little
        fill-in. ``upper`` is that of the first matrix.

        Raises:
            RuntimeError: a pivot is 0, so the matrix is not definite.
        """
        self._factorise(matrix, "NATURAL")

    def _factorise(self, matrix: csc_array, order: Literal["MMD_AT_PLUS_A", "NATURAL"]) -> None:
        np.take(matrix.data, self._source, out=self._whole.data)
        # The symmetric mode orders Aᵀ + A, and a threshold of 0 takes every diagonal entry
        # except 0 as its pivot, so L U is L D Lᵀ. Columns are too short for panels.
        self._factors = splu(
            self._whole,
            permc_spec=order,
            diag_pivot_thresh=0.0,
            relax=1,
            panel_size=1,
            options={"SymmetricMode": True},
        )
        if not np.array_equal(self._factors.perm_r, self._factors.perm_c):
            raise RuntimeError("a pivot on the diagonal is 0")

    def factors(self) -> tuple[csc_array, Array, Indices]:
        """Return L ``(n, n)`` without its unit diagonal, D ``(n,)`` and the order ``(n,)``.

        L D Lᵀ is the matrix with its rows and columns in this order.
        """
        whole = self._factors.L
        below = whole.indices != np.repeat(np.arange(whole.shape[0]), np.diff(whole.indptr))
        starts = np.concatenate([[0], np.cumsum(below)])[whole.indptr]
        part = csc_array((whole.data[below], whole.indices[below], starts), whole.shape)
        return part, self._factors.U.diagonal(), np.argsort(self._factors.perm_c)

    def solve(self, right: Array) -> Array:
        """Return the solutions for right-hand sides ``(n,)`` or ``(n, c)``."""
        solution: Array = self._factors.solve(right)
        return solution


try:
    from qdldl import Solver
except ImportError:
    Solver = SuperLU

__all__ = ["Solver", "SuperLU"]
