"""Riemannian Newton on the chordal problem, over rotations or over the Stiefel manifold.

Gauss–Newton on the logarithm cost does not end at the chordal optimum, so a map is
polished before it is certified. At rank r = d the iterate is a map in SO(d)ⁿ × R^{dn};
at a higher rank each rotation is an r × d matrix with orthonormal columns, which is what
the Riemannian staircase climbs. Pose 0 stays where it is.

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
    edge_pulls,
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
"""Beyond this shift, relative to the diagonal, a step is lost in rounding."""


@dataclass(frozen=True, eq=False)
class Point:
    """An iterate ``blocks`` ``(n, r, d + 1)`` with its cost and its ``stationarity``."""

    blocks: Array
    cost: float
    stationarity: float


@dataclass(frozen=True, eq=False)
class Descent:
    """Where a descent ended, and the ``history`` of points that led there, the start first.

    ``at_rest`` tells that no step lowers the gradient any more, beyond rounding.
    """

    history: tuple[Point, ...]
    at_rest: bool

    @property
    def last(self) -> Point:
        """The point where it ended."""
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

    ``poses``, ``(n, 3)`` or ``(n, 3, 4)``, are the start; pose 0 is kept. ``weights``
    ``(m,)`` multiply κ and τ and are 1 if None. It ends when the stationarity of
    ``stationarity`` is at most ``tol``, or at rounding level, where a step does not halve
    it. Near a minimum the convergence is quadratic; far away it may crawl, and ``gauss_newton``
    is the better way to come near.

    Raises:
        ValueError: ``poses`` or ``weights`` have the wrong shape or are not finite, a
            weight is negative, or a limit is out of range.
        Underdetermined: the edges with positive weight leave a pose loose.
        NotConverged: ``max_iterations`` steps were not enough.

    Source: Absil, Mahony and Sepulchre 2008, Newton's method; the shift is derived here.
    """
    start = check_poses("poses", poses, graph)
    problem = ChordalProblem.of(graph, weights)
    last = settled(descend(problem, pose_blocks(start), tol, max_iterations))
    polished = poses_of(graph.group, last.blocks)
    polished[0] = start[0]
    return polished


def poses_of(group: Group, blocks: Array) -> Array:
    """Return the poses ``(n, …)`` of ``blocks`` ``(n, d, d + 1)``, each [R | t]."""
    return group.from_parts(blocks[..., :-1], blocks[..., -1])


def settled(descent: Descent) -> Point:
    """Return where ``descent`` ended.

    Raises:
        NotConverged: it is not at rest.
    """
    if not descent.at_rest:
        raise NotConverged(
            f"after {len(descent.history) - 1} steps the chordal cost is "
            f"{descent.last.cost:.6g} and the stationarity {descent.last.stationarity:.2g}; "
            "start from better poses, allow more steps or loosen tol"
        )
    return descent.last


def stationarity(problem: ChordalProblem, blocks: Array) -> float:
    """Return the relative size of S·Xᵀ, a number without a unit: 0 where the gradient is.

    ``blocks`` ``(n, r, d + 1)`` are a map, or a point of a higher rank.

    It is √(Σ_c ‖(X S)_c‖² / M_cc) / √(Σ_c M_cc), the first sum over all columns, the
    second over those of the rotations. So it depends neither on the unit of length, nor on
    the scale of the information, nor on where the map lies. Its square is about the part
    of the cost that one step along the diagonal would save, relative to the cost of
    measurements that are all wrong.

    Source: derived here.
    """
    diagonal = np.einsum("icc->ic", problem.pose_blocks)
    uneven = np.sum(_gradient(problem, blocks) ** 2, axis=1) / diagonal
    return float(np.sqrt(np.sum(uneven) / np.sum(diagonal[:, : problem.d])))


def _gradient(problem: ChordalProblem, blocks: Array) -> Array:
    """Return X S = X M − X Λ as blocks ``(n, r, d + 1)``."""
    d = problem.d
    gradient = np.zeros_like(blocks)
    np.add.at(gradient, problem.edges, edge_pulls(problem, blocks))
    turn = blocks[..., :d]
    inner = np.swapaxes(turn, 1, 2) @ gradient[..., :d]
    gradient[..., :d] -= turn @ (0.5 * (inner + np.swapaxes(inner, 1, 2)))
    return gradient


def descend(
    problem: ChordalProblem,
    blocks: Array,
    tol: float = 1e-13,
    max_iterations: int = STEP_LIMIT,
) -> Descent:
    """Run Newton from ``blocks`` ``(n, r, d + 1)`` of any rank r ≥ d.

    The rule for stopping is that of ``polish``, but running out of iterations is told, not
    raised. The cost never rises.

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
            return Descent(tuple(history), at_rest=True)
        trial, shift = _lower(problem, pattern, point, shift)
        history.append(trial)
        if shift == 0.0 and trial.stationarity > 0.5 * point.stationarity and _is_flat(point):
            return Descent(tuple(history), at_rest=True)
    return Descent(tuple(history), at_rest=False)


def _is_flat(point: Point) -> bool:
    return point.stationarity < 1e-9


def _point(problem: ChordalProblem, blocks: Array) -> Point:
    return Point(blocks, lifted_cost(problem, blocks), stationarity(problem, blocks))


def tangent_dimension(d: int, r: int) -> int:
    """Return how many numbers move a pose at rank r: d(d − 1)/2 + (r − d) d + r."""
    return d * (d - 1) // 2 + (r - d) * d + r


def _lower(
    problem: ChordalProblem, pattern: BlockPattern, point: Point, shift: float
) -> tuple[Point, float]:
    """Return a point of no higher cost, and the shift to begin with at the next step.

    Levenberg's shift grows until the Hessian is positive definite and the cost falls; it
    is relative to the diagonal of the Hessian of Λ = 0, which is always positive.
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
    """Return the shift to begin with after a step; a small one gives way to plain Newton."""
    lower = shift / _GROWTH**2
    return lower if lower > _FIRST_SHIFT else 0.0


def tangent_basis(blocks: Array) -> Array:
    """Return a basis ``(n, p, r, d + 1)`` of the tangent space at each pose.

    First the Y A with A skew, then the Y⊥ K, then the positions, along the axes.
    """
    n, r, width = blocks.shape
    d = width - 1
    turn = blocks[..., :d]
    basis = np.zeros((n, tangent_dimension(d, r), r, width))
    for k, (a, b) in enumerate(combinations(range(d), 2)):
        basis[:, k, :, b], basis[:, k, :, a] = turn[..., a], -turn[..., b]
    beyond = np.linalg.qr(turn, mode="complete")[0][..., d:]
    for k, (c, a) in enumerate(product(range(r - d), range(d)), d * (d - 1) // 2):
        basis[:, k, :, a] = beyond[..., c]
    basis[:, np.arange(-r, 0), np.arange(r), d] = 1.0
    return basis


def retract(blocks: Array, basis: Array, step: Array) -> Array:
    """Return ``blocks`` moved by ``step`` ``(n, p)`` and taken back to the manifold.

    Orthonormal columns come back as the polar factor, the nearest there is.

    Source: Absil, Mahony and Sepulchre 2008, the polar retraction of the Stiefel manifold.
    """
    moved = blocks + np.einsum("np,npcx->ncx", step, basis)
    moved[..., :-1] = nearest_stiefel(moved[..., :-1])
    # Untouched poses stay to the last bit: pose 0, which is pinned.
    still = ~np.any(step, axis=1)
    moved[still] = blocks[still]
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
