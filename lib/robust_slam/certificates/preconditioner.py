"""Preconditioners for Newton steps on the chordal problem, from sparse Cholesky factors.

A preconditioner is the inverse of M − θ Λ, restricted to the tangent space. For θ = 1 that is
the Hessian. Where it is indefinite, θ is lowered until the factorisation succeeds: at
θ = 0, with pose 0 left out, M is always positive definite.

At low ranks the tangent space is small, and the restriction is factorised: a step with θ = 1
is then Newton's. At higher ranks it has many more unknowns, and the matrix itself, with d + 1
unknowns for each pose, is factorised once for all rows; the result is projected.

Source: Rosen et al. 2019, "SE-Sync", section 5.1, a Cholesky factor of M as preconditioner;
the levels of θ are derived here.
"""

from collections.abc import Callable

import numpy as np
from scipy.sparse import csr_array

from robust_slam._arrays import Array
from robust_slam.certificates.chordal import (
    ChordalProblem,
    assemble,
    certificate_blocks,
    edge_gradients,
)
from robust_slam.certificates.tangent import (
    project_tangent,
    restricted,
    tangent_basis,
    tangent_dimension,
)
from robust_slam.descent.sparse.pattern import (
    BlockPattern,
    PoseFactors,
    find_pattern,
    free_elimination,
    sum_by_pose,
)
from robust_slam.errors import singular

Operator = Callable[[Array], Array]
"""A linear map of tangent vectors ``(n, r, d + 1)`` that are 0 at pose 0."""

_LEVELS = (1.0, 0.9, 0.5, 0.0)
"""The values of θ, the best first."""
_RESTRICTED = 12
"""Up to this many unknowns of a pose the restriction to the tangent space is factorised."""


class Systems:
    """The linear systems of a problem at rank ``r``; all sparsity patterns are found once."""

    def __init__(self, problem: ChordalProblem, r: int) -> None:
        self.problem = problem
        elimination = free_elimination(problem.n, problem.edges)
        self._matrix = csr_array(assemble(problem, problem.edge_blocks))
        unknowns = tangent_dimension(problem.d, r)
        self._whole = unknowns > _RESTRICTED
        block = problem.d + 1 if self._whole else unknowns
        self._pattern = find_pattern(problem.n, problem.edges, block, elimination)
        self._positions = _position_factors(
            problem, find_pattern(problem.n, problem.edges, 1, elimination)
        )
        self._level = 0

    def with_optimal_positions(self, blocks: Array) -> Array:
        """Return ``blocks`` ``(n, r, d + 1)`` with the best positions for their rotations.

        The position of pose 0 is kept. A step along a straight line leaves the positions
        behind the rotations wherever a part of the map turns as a whole.
        """
        pull = np.swapaxes(edge_gradients(self.problem, blocks)[..., -1], 0, 1)
        total = sum_by_pose(self.problem.n, self.problem.edges, pull)
        placed = blocks.copy()
        placed[..., -1] -= self._positions.solve(total[:, None])[:, 0]
        return placed

    def hessian(self, blocks: Array) -> Operator:
        """Return half the Riemannian Hessian at ``blocks`` ``(n, r, d + 1)``."""
        problem, d = self.problem, self.problem.d
        across = problem.edge_blocks - certificate_blocks(problem, blocks)
        own = np.swapaxes(across[:, (0, 1), (0, 1), :d, :d], 0, 1)
        multipliers = sum_by_pose(problem.n, problem.edges, own)

        def apply(vectors: Array) -> Array:
            n, r, width = vectors.shape
            rows = np.ascontiguousarray(np.swapaxes(vectors, 1, 2)).reshape(n * width, r)
            product = np.swapaxes((self._matrix @ rows).reshape(n, width, r), 1, 2)
            product[..., :d] -= vectors[..., :d] @ multipliers
            product[0] = 0.0
            return project_tangent(blocks, product)

        return apply

    def preconditioner(self, blocks: Array) -> Operator:
        """Return an approximate inverse of ``hessian(blocks)``, positive definite.

        ``blocks`` are ``(n, r, d + 1)``. It is valid until the next one is made.

        Raises:
            Underdetermined: even the factorisation of M fails.
        """
        problem = self.problem
        s = certificate_blocks(problem, blocks)
        # The level of the last point is a good guess; a better one is tried first.
        self._level = max(0, self._level - 1)
        while self._level < len(_LEVELS):
            theta = _LEVELS[self._level]
            inverse = self._inverse(
                blocks, problem.edge_blocks + theta * (s - problem.edge_blocks)
            )
            if inverse is not None:
                return inverse
            self._level += 1
        raise singular("the chordal problem is")

    def _inverse(self, blocks: Array, matrix: Array) -> Operator | None:
        """Return the inverse of a matrix of edge blocks, None if not positive definite."""
        if self._whole:
            factors = self._pattern.factorise(self._pattern.sum_edges(matrix))
            return None if factors is None else _projected(blocks, factors)
        basis = tangent_basis(blocks)
        factors = self._pattern.factorise(restricted(self.problem, self._pattern, matrix, basis))
        return None if factors is None else _in_basis(basis, factors)


def _projected(blocks: Array, factors: PoseFactors) -> Operator:
    """Return the inverse of the matrix over all rows, projected on the tangent space."""

    def apply(vectors: Array) -> Array:
        rows = np.ascontiguousarray(np.swapaxes(vectors, 1, 2))
        return project_tangent(blocks, np.swapaxes(factors.solve(rows), 1, 2))

    return apply


def _in_basis(basis: Array, factors: PoseFactors) -> Operator:
    """Return the inverse of the restriction to ``basis`` ``(n, p, r, d + 1)``."""

    def apply(vectors: Array) -> Array:
        coordinates = np.einsum("npcx,ncx->np", basis, vectors)
        return np.asarray(np.einsum("npcx,np->ncx", basis, factors.solve(coordinates)))

    return apply


def _position_factors(problem: ChordalProblem, pattern: BlockPattern) -> PoseFactors:
    """Return the factors of Σ τ over the edges, the Laplacian of the positions.

    Raises:
        Underdetermined: the factorisation fails.
    """
    d = problem.d
    own = np.ascontiguousarray(problem.edge_blocks[..., d:, d:])
    factors = pattern.factorise(pattern.sum_edges(own))
    if factors is None:
        raise singular("the positions are")
    return factors
