"""LDLᵀ factorisation of sparse symmetric matrices, by QDLDL or by SciPy.

QDLDL has no wheel for WebAssembly, so Python in the browser uses SciPy's SuperLU. ``Solver``
is QDLDL's where it is installed, and ``SuperLU`` elsewhere.

Source: Li 2005, "An overview of SuperLU", for its symmetric mode; Stellato et al. 2020, "OSQP",
for QDLDL.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import csc_array, tril, triu
from scipy.sparse.linalg import splu

from robust_slam._arrays import Array, Indices


class SuperLU:
    """Factorises matrices, with the methods of ``qdldl.Solver`` that are used here.

    Raises:
        RuntimeError: a pivot is 0, so the matrix is not definite.
    """

    def __init__(self, matrix: csc_array, upper: bool = True) -> None:
        self.update(matrix, upper)

    def update(self, matrix: csc_array, upper: bool = True) -> None:
        """Factorise another matrix ``(n, n)``; ``upper``: it holds its upper triangle alone.

        Raises:
            RuntimeError: a pivot is 0, so the matrix is not definite.
        """
        whole = csc_array(matrix + triu(matrix, k=1).T) if upper else matrix
        # The symmetric mode orders Aᵀ + A, and a threshold of 0 takes every diagonal entry
        # except 0 as its pivot, so L U is L D Lᵀ.
        self._factors = splu(
            whole,
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )
        if not np.array_equal(self._factors.perm_r, self._factors.perm_c):
            raise RuntimeError("a pivot on the diagonal is 0")

    def factors(self) -> tuple[csc_array, Array, Indices]:
        """Return L ``(n, n)`` without its unit diagonal, D ``(n,)`` and the order ``(n,)``.

        L D Lᵀ is the matrix with its rows and columns in this order.
        """
        below = csc_array(tril(self._factors.L, k=-1))
        return below, self._factors.U.diagonal(), np.argsort(self._factors.perm_c)

    def solve(self, right: Array) -> Array:
        """Return the solution ``(n,)`` for a right-hand side ``(n,)``."""
        solution: Array = self._factors.solve(right)
        return solution


try:
    from qdldl import Solver
except ImportError:
    Solver = SuperLU

__all__ = ["Solver", "SuperLU"]
