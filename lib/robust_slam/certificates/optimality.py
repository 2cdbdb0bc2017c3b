"""A certificate of global optimality for the chordal problem, checked a posteriori.

Let S = M − Λ with the data matrix M of ``chordal`` and Λ block diagonal, Λ_i =
sym(R_iᵀ (X M)_i) on the rotation of pose i and 0 on its position. If S·Xᵀ = 0 and S ⪰ 0,
then X minimises the chordal cost over all maps.

Two mistakes make this test invalid, and both are avoided:

- A shift is needed, because S has a kernel of dimension d + 1 at least: S + ηI may pass a
  Cholesky test at a point that is not stationary. Stationarity is tested first.
- tr Λ = cost holds at any rotations with optimal positions. It proves nothing.

**What a certificate does not prove.** It is about the weighted least-squares problem over
the kept edges, and about its chordal cost alone. It says nothing about outliers: with a
wrong closure kept it may certify a wrong map. A map without a certificate need not be wrong:
it may be a local minimum, or the relaxation may not be tight.

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
    edge_gradients,
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
"""Up to this size of S_R a dense eigenvalue solver is used instead of ARPACK."""


class Verdict(Enum):
    """The verdict of a certificate on a map."""

    CERTIFIED = "certified"
    """The map is stationary and S + η·diag(I, 0) is positive definite: the global optimum."""
    NOT_CERTIFIED = "not certified"
    """The map is stationary but not proved optimal: a local minimum or a loose relaxation."""
    NOT_STATIONARY = "not stationary"
    """The map is not a stationary point of the chordal cost; polish it first."""


@dataclass(frozen=True, eq=False)
class Certificate:
    """The verdict on a map, with the numbers behind it.

    ``stationarity`` is that of ``newton.stationarity``, the relative size of
    S·Xᵀ. ``lambda_min`` is the smallest eigenvalue of S_R, the S of the rotations alone
    with the positions marginalised, in the unit of κ. ``eta`` is the shift with which
    S + η·diag(I, 0), without a shift on positions and with one of them fixed, passed the
    Cholesky test. ``cost`` is the chordal cost of the map, and every map costs at least
    ``lower_bound`` = tr Λ − d n η. ``direction`` ``(n, d + 1)``, rotation part first, is
    the eigenvector of a negative ``lambda_min`` with its optimal positions, a descent
    direction at the next rank; None if the Cholesky test passed at once.

    It says nothing about outliers: see the module.
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
        """An upper bound on the optimality gap, the cost minus the global minimum.

        It holds at any map, stationary or not: for every map X' with S + η·diag(I, 0) ⪰ 0
        cost(X') = tr Λ + tr(X' S X'ᵀ) ≥ tr Λ − η ‖R'‖²_F, and ‖R'‖²_F = d n. With
        η = −λ_min of an S that keeps the positions this would be false, as nothing bounds
        ‖t'‖.

        Source: Rosen et al. 2019, weak duality of Problem 6; with positions derived here.
        """
        # No map costs less than 0, so a negative lower bound can be raised to 0.
        return max(0.0, self.cost - max(0.0, self.lower_bound))


def certify(
    graph: PoseGraph, poses: ArrayLike, weights: ArrayLike | None = None
) -> tuple[Array, Certificate]:
    """Return the poses polished on the chordal cost, and their certificate.

    ``poses`` are ``(n, 3)`` or ``(n, 3, 4)``; ``weights`` ``(m,)`` multiply κ and τ and are 1
    if None; edges of weight 0 are left out. The certificate is about weighted least squares
    over the remaining edges and says nothing about outliers among them.

    Raises:
        ValueError: ``poses`` or ``weights`` have the wrong shape or are not finite, or a
            weight is negative.
        Underdetermined: the edges with positive weight do not connect all poses.
        NotConverged: the polish did not converge.

    Source: Rosen et al. 2019, Theorem 7 and equations (107) and (112).

    >>> from robust_slam.graphs import circle, dead_reckoning
    >>> graph, _ = circle(12, np.random.default_rng(0))
    >>> poses, proof = certify(graph, dead_reckoning(graph))
    >>> proof.verdict.value, round(proof.cost, 3), proof.bound < 1e-6
    ('certified', 1.217, True)
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
    """Return the certificate of ``poses`` without polishing them.

    ``poses`` are ``(n, 3)`` or ``(n, 3, 4)``; ``weights`` ``(m,)`` are 1 if None. ``eta``
    is the shift of the Cholesky test, in the unit of κ; if None it is 1e-12 of the mean of
    M's diagonal over the rotations, or larger where the stationarity is larger. A map counts
    as stationary if its stationarity is at most ``tol``. The smallest eigenvalue of a
    certified map is 0, since S_R Rᵀ = 0.

    It is about the chordal cost of the weighted edges: with a wrong closure kept it may
    certify a wrong map.

    Raises:
        ValueError: ``poses`` or ``weights`` have the wrong shape or are not finite, a
            weight is negative, or ``eta`` or ``tol`` is not above 0.
        Underdetermined: the edges with positive weight do not connect all poses, or the
            problem is singular to working precision.

    Source: Rosen et al. 2019, Theorem 7 and equations (107) and (112).
    """
    blocks = pose_blocks(check_poses("poses", poses, graph))
    return judge(ChordalProblem.of(graph, weights), blocks, eta=eta, tol=tol)


def judge(
    problem: ChordalProblem, blocks: Array, *, eta: float | None = None, tol: float = STATIONARY
) -> Certificate:
    """Return the certificate of ``blocks`` ``(n, r, d + 1)`` of any rank r ≥ d.

    Arguments and errors are those of ``certificate``. At a rank above d it is about the
    relaxation: ``lower_bound`` still bounds the cost of every map.
    """
    tol = positive("tol", tol)
    gradient_norm = stationarity(problem, blocks)
    first = _shift(problem, gradient_norm) if eta is None else positive("eta", eta)
    s = _CertificateMatrix.at(problem, blocks)
    passed = s.factorise(first)
    lowest, direction = _lowest(s, first, passed)
    shift = first if passed else _least_shift(s, max(first, -lowest))
    cost = lifted_cost(problem, blocks)
    return Certificate(
        verdict=_verdict(gradient_norm <= tol, passed is not None),
        stationarity=gradient_norm,
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


def _shift(problem: ChordalProblem, gradient_norm: float) -> float:
    """Return η, above rounding and above the remaining gradient."""
    diagonal = np.einsum("icc->ic", problem.pose_blocks)[:, : problem.d]
    return float(max(_SHIFT, min(gradient_norm, STATIONARY)) * diagonal.mean())


def _multiplier_trace(problem: ChordalProblem, blocks: Array, cost: float) -> float:
    """Return tr Λ, which is the cost less ⟨t, (X M)_t⟩, and so the cost at the optimal t."""
    gradient = np.zeros(blocks.shape[:2])
    np.add.at(gradient, problem.edges, edge_gradients(problem, blocks)[..., -1])
    # The gradients sum to 0, so any origin will do; the mean position limits rounding.
    position = blocks[..., -1] - blocks[..., -1].mean(axis=0)
    return cost - float(np.sum(position * gradient))


@dataclass(frozen=True, eq=False)
class _CertificateMatrix:
    """S with one position fixed: its filled ``blocks`` and their ``pattern``.

    An extra quadratic term joins the position of pose 0 to a fixed point, an additional
    first pose of the pattern. S is invariant to a common translation, so the term changes
    neither definiteness nor S_R. ``ceiling`` is a shift that must pass.
    """

    pattern: BlockPattern
    blocks: Array
    ceiling: float

    @classmethod
    def at(cls, problem: ChordalProblem, blocks: Array) -> _CertificateMatrix:
        """Return S at ``blocks``."""
        d, width = problem.d, problem.d + 1
        anchor = np.zeros((1, 2, 2, width, width))
        anchor[0, 1, 1, d, d] = problem.pose_blocks[0, d, d]
        s = np.concatenate([anchor, certificate_blocks(problem, blocks)])
        pattern = find_pattern(problem.n + 1, np.concatenate([[[0, 1]], problem.edges + 1]), width)
        multipliers = problem.edge_blocks - s[1:]
        return cls(pattern, pattern.sum(pieces_of(s)), 2.0 * float(np.abs(multipliers).sum()))

    def factorise(self, eta: float) -> PoseFactors | None:
        """Return the factors of S + η·diag(I, 0), or None if it is not positive definite."""
        shift = np.full((self.pattern.n, self.pattern.block), eta)
        shift[:, -1] = 0.0
        return self.pattern.factorise(self.blocks, shift)


def _solved(factors: PoseFactors, right_rotations: Array) -> Array:
    """Return the unknowns ``(n, d + 1, …)`` for a right-hand side over the rotations alone.

    Their rotations are (S_R + ηI)⁻¹ ``right_rotations`` ``(n, d, …)``: the factors of all
    unknowns replace the Schur complement.
    """
    n, d, *others = right_rotations.shape
    right = np.zeros((n + 1, d + 1, *others))
    right[1:, :-1] = right_rotations
    return np.asarray(factors.solve(right)[1:])


def _lowest(s: _CertificateMatrix, eta: float, passed: PoseFactors | None) -> tuple[float, Array]:
    """Return λ_min of S_R and its eigenvector ``(n, d + 1)`` with optimal positions."""
    shift, factors = eta, passed
    while factors is None:
        if shift > s.ceiling:
            raise Underdetermined(
                "the certificate matrix is singular to working precision: some edges weigh "
                "almost nothing beside the others; give such edges weight 0"
            )
        shift *= 100.0
        factors = s.factorise(shift)
    inverse, rotations = _largest(s.pattern.n - 1, s.pattern.block - 1, factors)
    full = _solved(factors, rotations)
    return 1.0 / inverse - shift, full / np.linalg.norm(full[:, :-1])


def _largest(n: int, d: int, factors: PoseFactors) -> tuple[float, Array]:
    """Return the largest eigenvalue of (S_R + ηI)⁻¹ and its eigenvector ``(n, d)``."""
    size = n * d

    def apply(x: Array) -> Array:
        rotations = x.reshape(n, d, *x.shape[1:])
        return _solved(factors, rotations)[:, :-1].reshape(x.shape)

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
