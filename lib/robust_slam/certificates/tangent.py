"""The manifold of the chordal problem: tangent vectors, derivatives and the retraction.

At rank r = d the iterate is a map in SO(d)ⁿ × R^{dn}; at a higher rank each rotation is an
r × d matrix with orthonormal columns, a point of the Stiefel manifold. With B a basis of the
tangent space the gradient is 2 Bᵀ vec(X M) and the Hessian 2 Bᵀ ((M − Λ) ⊗ I_r) B, both sums
over the edges. The factors 2 are left out below.

Source: Absil, Mahony and Sepulchre 2008, "Optimization Algorithms on Matrix Manifolds",
sections 3.5 and 4.1 on the Stiefel manifold; Rosen et al. 2019 for the Hessian's S = M − Λ.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations, product

import numpy as np

from robust_slam._arrays import Array
from robust_slam.certificates.chordal import ChordalProblem, edge_gradients, lifted_cost
from robust_slam.descent.sparse.pattern import BlockPattern, sum_by_pose
from robust_slam.groups.rotations import nearest_stiefel


@dataclass(frozen=True, eq=False)
class Point:
    """An iterate ``blocks`` ``(n, r, d + 1)`` with its cost and its ``stationarity``."""

    blocks: Array
    cost: float
    stationarity: float

    @classmethod
    def at(cls, problem: ChordalProblem, blocks: Array) -> Point:
        """Return the point of ``blocks``."""
        return cls(blocks, lifted_cost(problem, blocks), stationarity(problem, blocks))


def stationarity(problem: ChordalProblem, blocks: Array) -> float:
    """Return the relative size of S·Xᵀ, without a unit: 0 where the gradient is 0.

    ``blocks`` ``(n, r, d + 1)`` are a map, or a point of a higher rank.

    It is √(Σ_c ‖(X S)_c‖² / M_cc) / √(Σ_c M_cc), the first sum over all columns, the
    second over those of the rotations. It does not depend on the unit of length, on the
    scale of the information, or on the origin. Its square is about the decrease of the cost
    by one diagonally scaled gradient step, relative to the cost of measurements that are all
    wrong.
    """
    diagonal = np.einsum("icc->ic", problem.pose_blocks)
    gradient_squared = np.sum(half_gradient(problem, blocks) ** 2, axis=1) / diagonal
    return float(np.sqrt(np.sum(gradient_squared) / np.sum(diagonal[:, : problem.d])))


def half_gradient(problem: ChordalProblem, blocks: Array) -> Array:
    """Return X S = X M − X Λ as blocks ``(n, r, d + 1)``, half the Riemannian gradient."""
    gradients = np.swapaxes(edge_gradients(problem, blocks), 0, 1)
    total = sum_by_pose(problem.n, problem.edges, gradients)
    return project_tangent(blocks, total)


def project_tangent(blocks: Array, vectors: Array) -> Array:
    """Return the tangent vectors at ``blocks`` nearest to ``vectors``, ``(n, r, d + 1)`` both.

    A rotation part V at Y becomes V − Y sym(YᵀV); positions are unchanged.

    Source: Absil, Mahony and Sepulchre 2008, equation (3.35).
    """
    rotation, projected = blocks[..., :-1], vectors.copy()
    inner = np.swapaxes(rotation, 1, 2) @ vectors[..., :-1]
    projected[..., :-1] -= rotation @ (0.5 * (inner + np.swapaxes(inner, 1, 2)))
    return projected


def tangent_dimension(d: int, r: int) -> int:
    """Return the tangent dimension of a pose at rank r: d(d − 1)/2 + (r − d) d + r."""
    return d * (d - 1) // 2 + (r - d) * d + r


def tangent_basis(blocks: Array) -> Array:
    """Return a basis ``(n, p, r, d + 1)`` of the tangent space at each pose.

    First the Y A with A skew, then the Y⊥ K, then the positions, along the axes.
    """
    n, r, width = blocks.shape
    d = width - 1
    rotation = blocks[..., :d]
    basis = np.zeros((n, tangent_dimension(d, r), r, width))
    for k, (a, b) in enumerate(combinations(range(d), 2)):
        basis[:, k, :, b], basis[:, k, :, a] = rotation[..., a], -rotation[..., b]
    if r > d:
        beyond = np.linalg.qr(rotation, mode="complete")[0][..., d:]
        for k, (c, a) in enumerate(product(range(r - d), range(d)), d * (d - 1) // 2):
            basis[:, k, :, a] = beyond[..., c]
    basis[:, np.arange(-r, 0), np.arange(r), d] = 1.0
    return basis


def retract_vectors(blocks: Array, vectors: Array) -> Array:
    """Return ``blocks`` moved by tangent ``vectors`` and retracted, all ``(n, r, d + 1)``.

    The retraction is the polar factor, the nearest matrix with orthonormal columns.

    Source: Absil, Mahony and Sepulchre 2008, the polar retraction of the Stiefel manifold.
    """
    moved = blocks + vectors
    moved[..., :-1] = nearest_stiefel(moved[..., :-1])
    # Poses with a zero step, such as the fixed pose 0, are unchanged to the last bit.
    fixed = ~np.any(vectors, axis=(1, 2))
    moved[fixed] = blocks[fixed]
    return np.asarray(moved)


def restricted(
    problem: ChordalProblem, pattern: BlockPattern, matrix: Array, basis: Array
) -> Array:
    """Return Bᵀ (A ⊗ I_r) B as the filled blocks of ``pattern``, without pose 0.

    ``matrix`` is A, as edge blocks ``(m, 2, 2, d + 1, d + 1)``; ``basis`` ``(n, p, r, d + 1)``
    is B.
    """
    _, p, r, width = basis.shape
    ends = basis[problem.edges]
    flat = ends.reshape(-1, 2, 1, p * r, width) @ matrix
    flat = flat.reshape(-1, 2, 2, p, r * width)
    pairs = flat @ np.swapaxes(ends.reshape(-1, 1, 2, p, r * width), -1, -2)
    return pattern.sum_edges(pairs)
