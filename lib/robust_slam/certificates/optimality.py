"""Is a map the best of all? A certificate for the chordal problem, checked after the fact.

Let S = M − Λ with the data matrix M of ``chordal`` and Λ block diagonal, Λ_i =
sym(R_iᵀ (X M)_i) on the rotation of pose i and 0 on its position. If S·Xᵀ = 0 and S ⪰ 0,
then X minimises the chordal cost over all maps.

Two slips make this test worthless, so both are guarded against:

- A shift is needed, because S has a kernel of dimension d + 1 at least: S + ηI may pass a
  Cholesky test at a point that is not even stationary. Stationarity is tested first.
- tr Λ = cost holds at any rotations with their best positions. It proves nothing.

**What a certificate does not say.** It speaks about the weighted least-squares problem
with the edges that were kept, and about its chordal cost alone. It knows nothing of
outliers: with a wrong closure kept it may certify a wrong map. A refusal does not say that
the map is wrong either: it may be a local minimum, or the relaxation may not be tight.

Source: Rosen et al. 2019, "SE-Sync", Theorem 7 and equations (107) and (112).
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse.linalg import LinearOperator, eigsh

from robust_slam._arrays import Array, positive
from robust_slam.certificates.chordal import (
    ChordalProblem,
    certificate_blocks,
    edge_pulls,
    lifted_cost,
    pose_blocks,
)
from robust_slam.certificates.newton import polish, stationarity
from robust_slam.descent.sparse.pattern import (
    BlockPattern,
    PoseFactors,
    find_pattern,
    pieces_of,
)
from robust_slam.errors import Underdetermined
from robust_slam.graphs.pose_graph import PoseGraph, check_poses

STATIONARY = 1e-9
"""The largest stationarity of a map that counts as stationary; a polished one has 1e-13."""
_SHIFT = 1e-12
_DENSE = 60
"""Up to this size of S_R a dense eigenvalue solver is used: ARPACK wants room."""


class Verdict(Enum):
    """What the certificate says of a map."""

    CERTIFIED = "certified"
    """The map is stationary and S + η·diag(I, 0) is positive definite: the global optimum."""
    NOT_CERTIFIED = "not certified"
    """The map is stationary but not proved best; a local minimum, or no tight relaxation."""
    NOT_STATIONARY = "not stationary"
    """The map is not even a stationary point of the chordal cost; polish it first."""


@dataclass(frozen=True, eq=False)
class Certificate:
    """The verdict on a map, with the numbers behind it.

    ``stationarity`` is that of ``riemannian_newton.stationarity``, the relative size of
    S·Xᵀ. ``lambda_min`` is the smallest eigenvalue of S_R, the S of the rotations alone
    with the positions marginalised, in the unit of κ. ``eta`` is the shift with which
    S + η·diag(I, 0), the positions unshifted and one of them pinned, passed the Cholesky
    test. ``cost`` is the chordal cost of the map, and no map at all costs less than
    ``lower_bound`` = tr Λ − d n η. ``direction`` ``(n, d + 1)``, rotation part first, is
    the eigenvector of a negative ``lambda_min`` with its best positions, along which the
    cost falls one rank higher; None if the Cholesky test passed at once.

    What it does not say about outliers: see the module.
    """

    verdict: Verdict
    stationarity: float
    lambda_min: float
    eta: float
    cost: float
    lower_bound: float
    direction: Array | None

    @property
    def bound(self) -> float:
        """The most by which the map's cost can exceed the least there is, at least 0.

        It holds at any map, stationary or not: for every map X' with S + η·diag(I, 0) ⪰ 0
        cost(X') = tr Λ + tr(X' S X'ᵀ) ≥ tr Λ − η ‖R'‖²_F, and ‖R'‖²_F = d n. With
        η = −λ_min of an S that keeps the positions this would be false, as nothing bounds
        ‖t'‖.

        Source: Rosen et al. 2019, weak duality of Problem 6; with positions derived here.
        """
        # No map costs less than 0, whatever the multipliers say.
        return max(0.0, self.cost - max(0.0, self.lower_bound))


def certify(
    graph: PoseGraph, poses: ArrayLike, weights: ArrayLike | None = None
) -> tuple[Array, Certificate]:
    """Return the poses polished on the chordal cost, and the certificate of these.

    ``poses`` are ``(n, 3)`` or ``(n, 3, 4)``; ``weights`` ``(m,)`` multiply κ and τ, are 1
    if None, and drop an edge where they are 0. The certificate speaks about the weighted
    least squares over the edges that are left, and not about outliers among them.

    Raises:
        ValueError: ``poses`` or ``weights`` have the wrong shape or are not finite, or a
            weight is negative.
        Underdetermined: the edges with positive weight leave a pose loose.
        NotConverged: the polish did not come to rest.
    """
    polished = polish(graph, poses, weights)
    return polished, certificate(graph, polished, weights)


def certificate(
    graph: PoseGraph,
    poses: ArrayLike,
    weights: ArrayLike | None = None,
    *,
    eta: float | None = None,
    tol: float = STATIONARY,
) -> Certificate:
    """Return the certificate of ``poses`` as they are.

    ``poses`` are ``(n, 3)`` or ``(n, 3, 4)``; ``weights`` ``(m,)`` are 1 if None. ``eta``
    is the shift of the Cholesky test, in the unit of κ; if None it is 1e-12 of the mean of
    M's diagonal over the rotations, more where the map is stationary less well than that.
    A map is stationary up to a stationarity of ``tol``. A smallest eigenvalue of 0 is what
    a certified map has: S_R Rᵀ = 0.

    It speaks about the chordal cost of the weighted edges: with a wrong closure kept it
    may certify a wrong map.

    Raises:
        ValueError: ``poses`` or ``weights`` have the wrong shape or are not finite, a
            weight is negative, or ``eta`` or ``tol`` is not above 0.
        Underdetermined: the edges with positive weight leave a pose loose, or do so to
            working precision.

    Source: Rosen et al. 2019, Theorem 7 and equations (107) and (112).
    """
    blocks = pose_blocks(check_poses("poses", poses, graph))
    return judge(ChordalProblem.of(graph, weights), blocks, eta=eta, tol=tol)


def judge(
    problem: ChordalProblem, blocks: Array, *, eta: float | None = None, tol: float = STATIONARY
) -> Certificate:
    """Return the certificate of ``blocks`` ``(n, r, d + 1)`` of any rank r ≥ d.

    Arguments and errors are those of ``certificate``. At a rank above d it speaks about
    the relaxation: ``lower_bound`` still bounds the cost of every map.
    """
    tol = positive("tol", tol)
    uneven = stationarity(problem, blocks)
    first = _shift(problem, uneven) if eta is None else positive("eta", eta)
    s = _CertificateMatrix.at(problem, blocks)
    passed = s.factorise(first)
    lowest, direction = _lowest(s, first, passed)
    shift = first if passed else _least_shift(s, max(first, -lowest))
    cost = lifted_cost(problem, blocks)
    return Certificate(
        verdict=_verdict(uneven <= tol, passed is not None),
        stationarity=uneven,
        lambda_min=lowest,
        eta=shift,
        cost=cost,
        lower_bound=_multiplier_trace(problem, blocks, cost) - problem.d * problem.n * shift,
        direction=None if passed else direction,
    )


def _verdict(stationary: bool, passed: bool) -> Verdict:
    if not stationary:
        return Verdict.NOT_STATIONARY
    return Verdict.CERTIFIED if passed else Verdict.NOT_CERTIFIED


def _shift(problem: ChordalProblem, uneven: float) -> float:
    """Return η: above rounding, and above what is left of the gradient."""
    diagonal = np.einsum("icc->ic", problem.pose_blocks)[:, : problem.d]
    return float(max(_SHIFT, min(uneven, STATIONARY)) * diagonal.mean())


def _multiplier_trace(problem: ChordalProblem, blocks: Array, cost: float) -> float:
    """Return tr Λ, which is the cost less ⟨t, (X M)_t⟩, and so the cost at the best t."""
    pull = np.zeros(blocks.shape[:2])
    np.add.at(pull, problem.edges, edge_pulls(problem, blocks)[..., -1])
    # The pulls add up to 0, so the origin is free; near the map less is lost to rounding.
    place = blocks[..., -1] - blocks[..., -1].mean(axis=0)
    return cost - float(np.sum(place * pull))


@dataclass(frozen=True, eq=False)
class _CertificateMatrix:
    """S with one position pinned: its filled ``blocks`` and their ``pattern``.

    The pin is a spring from the position of pose 0 to a fixed point, which the pattern
    knows as a pose before all others. Moving all positions together costs nothing in S, so
    the spring changes neither definiteness nor S_R. ``ceiling`` is a shift that must pass.
    """

    pattern: BlockPattern
    blocks: Array
    ceiling: float

    @classmethod
    def at(cls, problem: ChordalProblem, blocks: Array) -> _CertificateMatrix:
        """Return S at ``blocks``."""
        d, width = problem.d, problem.d + 1
        spring = np.zeros((1, 2, 2, width, width))
        spring[0, 1, 1, d, d] = problem.pose_blocks[0, d, d]
        s = np.concatenate([spring, certificate_blocks(problem, blocks)])
        pattern = find_pattern(problem.n + 1, np.concatenate([[[0, 1]], problem.edges + 1]), width)
        multipliers = problem.edge_blocks - s[1:]
        return cls(pattern, pattern.sum(pieces_of(s)), 2.0 * float(np.abs(multipliers).sum()))

    def factorise(self, eta: float) -> PoseFactors | None:
        """Return the factors of S + η·diag(I, 0), or None if it is not positive definite."""
        shift = np.full((self.pattern.n, self.pattern.block), eta)
        shift[:, -1] = 0.0
        return self.pattern.factorise(self.blocks, shift)


def _solved(factors: PoseFactors, turns: Array) -> Array:
    """Return the unknowns ``(n, d + 1, …)`` for a right-hand side over the rotations alone.

    Their rotations are (S_R + ηI)⁻¹ ``turns``, which is ``(n, d, …)``: factors of all
    unknowns do the work of a Schur complement.
    """
    right = np.zeros((turns.shape[0] + 1, turns.shape[1] + 1, *turns.shape[2:]))
    right[1:, :-1] = turns
    return np.asarray(factors.solve(right)[1:])


def _lowest(s: _CertificateMatrix, eta: float, passed: PoseFactors | None) -> tuple[float, Array]:
    """Return λ_min of S_R and its eigenvector ``(n, d + 1)`` with the best positions."""
    shift, factors = eta, passed
    while factors is None:
        if shift > s.ceiling:
            raise Underdetermined(
                "the certificate matrix is singular to working precision: some edges weigh "
                "almost nothing beside the others; give such edges weight 0"
            )
        shift *= 100.0
        factors = s.factorise(shift)
    inverse, turns = _largest(s.pattern.n - 1, s.pattern.block - 1, factors)
    full = _solved(factors, turns)
    return 1.0 / inverse - shift, full / np.linalg.norm(full[:, :-1])


def _largest(n: int, d: int, factors: PoseFactors) -> tuple[float, Array]:
    """Return the largest eigenvalue of (S_R + ηI)⁻¹ and its eigenvector ``(n, d)``."""
    size = n * d

    def apply(x: Array) -> Array:
        turns = x.reshape(n, d, *x.shape[1:])
        return _solved(factors, turns)[:, :-1].reshape(x.shape)

    if size <= _DENSE:
        full = apply(np.eye(size))
        values, vectors = np.linalg.eigh(0.5 * (full + full.T))
    else:
        operator = LinearOperator((size, size), matvec=apply, dtype=np.float64)
        start = np.random.default_rng(0).normal(size=size)
        values, vectors = eigsh(operator, k=1, which="LM", v0=start)
    return float(values[-1]), vectors[:, -1].reshape(n, d)


def _least_shift(s: _CertificateMatrix, above: float) -> float:
    """Return a shift just above ``above`` that passes the Cholesky test."""
    margin = 1e-10
    while s.factorise(above * (1.0 + margin)) is None:
        margin *= 10.0
    return above * (1.0 + margin)
