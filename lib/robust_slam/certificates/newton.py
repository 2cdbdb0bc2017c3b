"""Riemannian Newton on the chordal problem, over rotations or over the Stiefel manifold.

Gauss–Newton minimises the logarithm cost, not the chordal one, so a map is polished before
it is certified. At rank r = d the iterate is a map in SO(d)ⁿ × R^{dn};
at a higher rank each rotation is an r × d matrix with orthonormal columns, as the
Riemannian staircase needs. Pose 0 is fixed.

With B a basis of the tangent space the gradient is 2 Bᵀ vec(X M) and the Hessian
2 Bᵀ ((M − Λ) ⊗ I_r) B, both sums over the edges. The factors 2 are left out below.

Source: Absil, Mahony and Sepulchre 2008, "Optimization Algorithms on Matrix Manifolds",
Newton's method with a retraction; Rosen et al. 2019 for the Hessian's S = M − Λ.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations, product

import numpy as np
from numpy.typing import ArrayLike

from robust_slam._arrays import Array
from robust_slam.certificates.chordal import (
    ChordalProblem,
    certificate_blocks,
    edge_gradients,
    lifted_cost,
    pose_blocks,
)
from robust_slam.descent.sparse.pattern import BlockPattern, find_pattern, pieces_of
from robust_slam.descent.step import ROUNDING, check_limits
from robust_slam.errors import NotConverged
from robust_slam.graphs.group import Group
from robust_slam.graphs.pose_graph import PoseGraph, check_poses
from robust_slam.graphs.rotations import nearest_stiefel

STEP_LIMIT = 200
_FIRST_SHIFT = 1e-7
_GROWTH = 3.0
_LAST_SHIFT = 1e12
"""Beyond this shift, relative to the diagonal, a step is below rounding."""


@dataclass(frozen=True, eq=False)
class Point:
    """An iterate ``blocks`` ``(n, r, d + 1)`` with its cost and its ``stationarity``."""

    blocks: Array
    cost: float
    stationarity: float


@dataclass(frozen=True, eq=False)
class Descent:
    """The result of a descent: the ``history`` of points, the start first.

    ``converged`` means that the gradient is zero up to ``tol`` or rounding.
    """

    history: tuple[Point, ...]
    converged: bool

    @property
    def last(self) -> Point:
        """The last point."""
        return self.history[-1]


def polish(
    graph: PoseGraph,
    poses: ArrayLike,
    weights: ArrayLike | None = None,
    *,
    tol: float = 1e-13,
    max_iterations: int = STEP_LIMIT,
) -> Array:
    """Return the poses at a minimum of the chordal cost near ``poses``.

    ``poses``, ``(n, 3)`` or ``(n, 3, 4)``, are the start; pose 0 is fixed. ``weights``
    ``(m,)`` multiply κ and τ and are 1 if None. It converges when the stationarity
    is at most ``tol``, or at rounding level, where a step does not halve it. The convergence
    is quadratic near a minimum but can be slow far away: use ``gauss_newton`` first.

    Raises:
        ValueError: ``poses`` or ``weights`` have the wrong shape or are not finite, a
            weight is negative, or a limit is out of range.
        Underdetermined: the edges with positive weight do not connect all poses.
        NotConverged: ``max_iterations`` steps were not enough.

    Source: Absil, Mahony and Sepulchre 2008, Newton's method; the shift is derived here.
    """
    start = check_poses("poses", poses, graph)
    problem = ChordalProblem.of(graph, weights)
    last = converged_point(descend(problem, pose_blocks(start), tol, max_iterations))
    polished = poses_of(graph.group, last.blocks)
    polished[0] = start[0]
    return polished


def poses_of(group: Group, blocks: Array) -> Array:
    """Return the poses ``(n, …)`` of ``blocks`` ``(n, d, d + 1)``, each [R | t]."""
    return group.from_parts(blocks[..., :-1], blocks[..., -1])


def converged_point(descent: Descent) -> Point:
    """Return the last point of ``descent``.

    Raises:
        NotConverged: it did not converge.
    """
    if not descent.converged:
        raise NotConverged(
            f"after {len(descent.history) - 1} steps the chordal cost is "
            f"{descent.last.cost:.6g} and the stationarity {descent.last.stationarity:.2g}; "
            "start from better poses, allow more steps or loosen tol"
        )
    return descent.last


def stationarity(problem: ChordalProblem, blocks: Array) -> float:
    """Return the relative size of S·Xᵀ, without a unit: 0 where the gradient is 0.

    ``blocks`` ``(n, r, d + 1)`` are a map, or a point of a higher rank.

    It is √(Σ_c ‖(X S)_c‖² / M_cc) / √(Σ_c M_cc), the first sum over all columns, the
    second over those of the rotations. It does not depend on the unit of length, on the
    scale of the information, or on the origin. Its square is about the decrease of the cost
    by one diagonally scaled gradient step, relative to the cost of measurements that are all
    wrong.

    Source: derived here.
    """
    diagonal = np.einsum("icc->ic", problem.pose_blocks)
    gradient_squared = np.sum(_gradient(problem, blocks) ** 2, axis=1) / diagonal
    return float(np.sqrt(np.sum(gradient_squared) / np.sum(diagonal[:, : problem.d])))


def _gradient(problem: ChordalProblem, blocks: Array) -> Array:
    """Return X S = X M − X Λ as blocks ``(n, r, d + 1)``."""
    d = problem.d
    gradient = np.zeros_like(blocks)
    np.add.at(gradient, problem.edges, edge_gradients(problem, blocks))
    rotation = blocks[..., :d]
    inner = np.swapaxes(rotation, 1, 2) @ gradient[..., :d]
    gradient[..., :d] -= rotation @ (0.5 * (inner + np.swapaxes(inner, 1, 2)))
    return gradient


def descend(
    problem: ChordalProblem,
    blocks: Array,
    tol: float = 1e-13,
    max_iterations: int = STEP_LIMIT,
) -> Descent:
    """Run Newton from ``blocks`` ``(n, r, d + 1)`` of any rank r ≥ d.

    The stopping rule is that of ``polish``, but running out of iterations raises no error.
    The cost never increases.

    Raises:
        ValueError: ``tol`` is negative or ``max_iterations`` below 1.
    """
    check_limits(tol, max_iterations)
    pattern = find_pattern(problem.n, problem.edges, tangent_dimension(problem.d, blocks.shape[1]))
    history = [_point(problem, blocks)]
    shift = 0.0
    for _ in range(max_iterations):
        point = history[-1]
        if point.stationarity <= tol:
            return Descent(tuple(history), converged=True)
        trial, shift = _descend_once(problem, pattern, point, shift)
        history.append(trial)
        if shift == 0.0 and trial.stationarity > 0.5 * point.stationarity and _is_flat(point):
            return Descent(tuple(history), converged=True)
    return Descent(tuple(history), converged=False)


def _is_flat(point: Point) -> bool:
    return point.stationarity < 1e-9


def _point(problem: ChordalProblem, blocks: Array) -> Point:
    return Point(blocks, lifted_cost(problem, blocks), stationarity(problem, blocks))


def tangent_dimension(d: int, r: int) -> int:
    """Return the tangent dimension of a pose at rank r: d(d − 1)/2 + (r − d) d + r."""
    return d * (d - 1) // 2 + (r - d) * d + r


def _descend_once(
    problem: ChordalProblem, pattern: BlockPattern, point: Point, shift: float
) -> tuple[Point, float]:
    """Return a point of no higher cost, and the first shift of the next step.

    The Levenberg shift grows until the Hessian is positive definite and the cost falls. It is
    relative to the diagonal of the Hessian of Λ = 0, which is always positive.
    """
    basis = tangent_basis(point.blocks)
    hessian, gradient, scale = equations(problem, pattern, point, basis)
    while shift < _LAST_SHIFT:
        factors = pattern.factorise(hessian, shift * scale)
        if factors is not None:
            trial = _point(problem, retract(point.blocks, basis, -factors.solve(gradient)))
            if trial.cost <= point.cost * (1.0 + ROUNDING):
                return trial, _relaxed(shift)
        shift = max(_FIRST_SHIFT, _GROWTH * shift)
    return point, 0.0


def _relaxed(shift: float) -> float:
    """Return the first shift of the next step, 0 (plain Newton) where it would be small."""
    lower = shift / _GROWTH**2
    return lower if lower > _FIRST_SHIFT else 0.0


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
    beyond = np.linalg.qr(rotation, mode="complete")[0][..., d:]
    for k, (c, a) in enumerate(product(range(r - d), range(d)), d * (d - 1) // 2):
        basis[:, k, :, a] = beyond[..., c]
    basis[:, np.arange(-r, 0), np.arange(r), d] = 1.0
    return basis


def retract(blocks: Array, basis: Array, step: Array) -> Array:
    """Return ``blocks`` moved by ``step`` ``(n, p)`` and retracted to the manifold.

    The retraction is the polar factor, the nearest matrix with orthonormal columns.

    Source: Absil, Mahony and Sepulchre 2008, the polar retraction of the Stiefel manifold.
    """
    moved = blocks + np.einsum("np,npcx->ncx", step, basis)
    moved[..., :-1] = nearest_stiefel(moved[..., :-1])
    # Poses with a zero step, such as the fixed pose 0, are unchanged to the last bit.
    fixed = ~np.any(step, axis=1)
    moved[fixed] = blocks[fixed]
    return np.asarray(moved)


def equations(
    problem: ChordalProblem, pattern: BlockPattern, point: Point, basis: Array
) -> tuple[Array, Array, Array]:
    """Return Hessian, gradient and the diagonal of the Hessian of Λ = 0.

    ``basis`` ``(n, p, r, d + 1)`` is the tangent basis at the point. The Hessian comes as the
    filled blocks of ``pattern``, without pose 0, the others as ``(n, p)``; all three are
    half the derivatives.
    """
    blocks = certificate_blocks(problem, point.blocks)
    _, p, r, width = basis.shape
    ends = basis[problem.edges]
    flat = ends.reshape(-1, 2, 1, p * r, width) @ blocks
    flat = flat.reshape(-1, 2, 2, p, r * width)
    pairs = flat @ np.swapaxes(ends.reshape(-1, 1, 2, p, r * width), -1, -2)
    hessian = pattern.sum(pieces_of(pairs))
    gradient = np.einsum("npcx,ncx->np", basis, _gradient(problem, point.blocks))
    scale = np.einsum("npcx,nxy,npcy->np", basis, problem.pose_blocks, basis)
    return hessian, gradient, scale
