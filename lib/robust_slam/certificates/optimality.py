"""A certificate of global optimality for the chordal problem, checked a posteriori.

Let S = M − Λ with the data matrix M of ``chordal`` and Λ block diagonal, Λ_i =
sym(R_iᵀ (X M)_i) on the rotation of pose i and 0 on its position. If S·Xᵀ = 0 and S ⪰ 0,
then X minimises the chordal cost over all maps.

Two mistakes make this test invalid, and both are avoided:

- A shift is needed, because S has a kernel of dimension d + 1 at least, and with a shift the
  Cholesky test passes at maps that are not optimal. So the verdict does not follow from the
  test but from the bound that it proves: a map is certified if it is stationary and its cost
  less the lower bound is at rounding level. A larger shift gives a looser bound, so no η
  certifies a wrong map.
- tr Λ = cost holds at any rotations with optimal positions. It proves nothing.

**What counts as rounding.** For a positive diagonal matrix D with S + diag(D, 0) ⪰ 0 every
map X' costs tr Λ + tr(X' S X'ᵀ) ≥ tr Λ − tr D, as the columns of rotations have length 1.
With D = s·diag(M) over the rotations, tr D is s times the cost of measurements that are all
wrong, and s is a relative change of the entries of M: below 1e-11 that is the error of the
data and of the factorisation. A gap of at most 1e-9 of the cost counts as rounding too,
whatever shift proves it.

**What a certificate does not prove.** It is about the weighted least-squares problem over
the kept edges, and about its chordal cost alone. It says nothing about outliers: with a
wrong closure kept it may certify a wrong map. A map without a certificate need not be wrong:
it may be a local minimum, or the relaxation may not be tight.

Source: Rosen et al. 2019, "SE-Sync", Theorem 7 and equations (107) and (112), and the weak
duality of Problem 6; the bound with positions and the shift by a diagonal are derived here.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from enum import Enum

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse.linalg import ArpackNoConvergence, LinearOperator, eigsh

from robust_slam._arrays import Array, positive
from robust_slam.certificates.chordal import (
    ChordalProblem,
    certificate_blocks,
    edge_gradients,
    lifted_cost,
    pose_blocks,
)
from robust_slam.certificates.newton import Stop, descend, poses_like
from robust_slam.certificates.tangent import stationarity
from robust_slam.descent.sparse.pattern import BlockPattern, PoseFactors, find_pattern
from robust_slam.errors import singular
from robust_slam.graphs.pose_graph import PoseGraph, check_poses

STATIONARY = 1e-9
"""The largest stationarity of a map that counts as stationary; a polished one has 1e-13."""
MAX_SECONDS = 60.0
"""The default limit of a descent, in seconds of CPU time."""
_SHIFT, _ROUNDING = 1e-12, 2e-11
"""The first shift of the Cholesky test and the largest that is rounding, relative to M."""
_GAP = 1e-9
"""An optimality gap, relative to the cost, that counts as rounding."""
_DENSE = 60
"""Up to this size of S_R a dense eigenvalue solver is used instead of ARPACK."""
_EIGENVALUE_TOLERANCE, _RESTARTS, _POWERS = 1e-7, 15, 20
"""The tolerance and the restarts of ARPACK, and the inverse iterations where it fails."""


class Verdict(Enum):
    """The verdict of a certificate on a map."""

    CERTIFIED = "certified"
    """The map is stationary and its optimality gap is at rounding level: the global optimum."""
    NOT_CERTIFIED = "not certified"
    """The map is stationary but not proved optimal: a local minimum or a loose relaxation."""
    NOT_STATIONARY = "not stationary"
    """The map is not a stationary point of the chordal cost; polish it first."""


@dataclass(frozen=True, eq=False)
class Certificate:
    """The verdict on a map, with the numbers behind it.

    ``stationarity`` is the size of S·Xᵀ relative to that of its terms. ``lambda_min`` is the
    smallest eigenvalue of S_R, the S of the rotations alone with the positions marginalised, in
    the unit of κ; 0 where it is 0 up to rounding. ``eta`` is the mean over the rotations of the
    shift with which S passed the Cholesky test, without a shift on positions and with one of them
    fixed. ``cost`` is the chordal cost of the map, and every map costs at least ``lower_bound`` =
    tr Λ − d n η. ``direction`` ``(n, d + 1)``, rotation part first, is the eigenvector of a
    negative ``lambda_min`` with its optimal positions, a descent direction at the next rank; None
    if the Cholesky test passed at once. ``stop`` is the reason why the descent before it stopped,
    None if there was none.

    It says nothing about outliers: see the module.
    """

    verdict: Verdict
    stationarity: float
    lambda_min: float
    eta: float
    cost: float
    lower_bound: float
    direction: Array | None = field(repr=False)
    stop: Stop | None = None

    def summary(self) -> str:
        """Return the verdict, the cost, the bound and the reason of the stop, a line each."""
        numbers = f"cost     {self.cost:.6g}\nbound    {self.bound:.3g}"
        end = "" if self.stop is None else f"\nstop     {self.stop.value}"
        return f"verdict  {self.verdict.value}\n{numbers}{end}"

    __str__ = summary

    @property
    def bound(self) -> float:
        """An upper bound on the optimality gap, the cost minus the global minimum.

        It is never more than the cost, since no cost is negative; where a map is NOT_CERTIFIED and
        the bound is as large as that, ``solve_certified`` finds a better one. It holds at any map,
        stationary or not: for every map X' with S + η·diag(I, 0) ⪰ 0 cost(X') = tr Λ + tr(X' S
        X'ᵀ) ≥ tr Λ − η ‖R'‖²_F, and ‖R'‖²_F = d n; so does it with any diagonal shift of the
        rotations of mean η. With η = −λ_min of an S that keeps the positions this would be false,
        as nothing bounds ‖t'‖.

        Source: Rosen et al. 2019, weak duality of Problem 6; with positions derived here.
        """
        return max(0.0, self.cost - max(0.0, self.lower_bound))


def certify(
    graph: PoseGraph,
    poses: ArrayLike,
    weights: ArrayLike | None = None,
    *,
    max_seconds: float = MAX_SECONDS,
) -> tuple[Array, Certificate]:
    """Return the poses polished on the chordal cost, and their certificate.

    ``poses`` are ``(n, 3)`` or ``(n, 3, 4)``; ``weights`` ``(m,)`` multiply κ and τ and are 1
    if None; edges of weight 0 are left out. After ``max_seconds`` of CPU time the polish ends
    with the best map so far. The verdict is then NOT_STATIONARY, and ``stop`` of the
    certificate gives the reason. The certificate is about weighted least squares over the
    remaining edges and says nothing about outliers among them.

    Raises:
        ValueError: ``poses`` or ``weights`` have the wrong shape or are not finite, or a
            weight or ``max_seconds`` is negative.
        Underdetermined: the edges with positive weight do not connect all poses.

    Source: Rosen et al. 2019, Theorem 7 and equations (107) and (112).

    >>> from robust_slam.graphs import circle, dead_reckoning
    >>> graph, _ = circle(12, np.random.default_rng(0))
    >>> poses, proof = certify(graph, dead_reckoning(graph))
    >>> proof.verdict.value, round(proof.cost, 3), proof.bound < 1e-6
    ('certified', 1.217, True)
    """
    start = check_poses("poses", poses, graph)
    problem = ChordalProblem.of(graph, weights)
    descent = descend(problem, pose_blocks(start), max_seconds=max_seconds)
    record = judge(problem, descent.last.blocks)
    return poses_like(graph, descent.last.blocks, start), replace(record, stop=descent.stop)


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
    is the mean shift of the Cholesky test, in the unit of κ. If None or too small it is 1e-12
    of the mean of M's diagonal over the rotations, or more where the stationarity is larger.
    The verdict follows from the bound: a larger shift passes more easily and proves less. A
    map counts as stationary if its stationarity is at most ``tol``. The smallest eigenvalue of
    a certified map is 0, since S_R Rᵀ = 0.

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


def unproven(graph: PoseGraph, poses: ArrayLike) -> Certificate:
    """Return a certificate of ``poses`` that proves nothing, for want of time.

    ``poses`` are ``(n, 3)`` or ``(n, 3, 4)``. Its cost and stationarity are those of the map;
    its lower bound is 0, as no map costs less, and its stop is TIME_LIMIT.

    Raises:
        ValueError: ``poses`` have the wrong shape or are not finite.
    """
    problem, blocks = ChordalProblem.of(graph), pose_blocks(check_poses("poses", poses, graph))
    return Certificate(
        verdict=Verdict.NOT_STATIONARY,
        stationarity=stationarity(problem, blocks),
        lambda_min=float("nan"),
        eta=float("inf"),
        cost=lifted_cost(problem, blocks),
        lower_bound=0.0,
        direction=None,
        stop=Stop.TIME_LIMIT,
    )


def judge(
    problem: ChordalProblem, blocks: Array, *, eta: float | None = None, tol: float = STATIONARY
) -> Certificate:
    """Return the certificate of ``blocks`` ``(n, r, d + 1)`` of any rank r ≥ d.

    Arguments and errors are those of ``certificate``. At a rank above d it is about the
    relaxation: ``lower_bound`` still bounds the cost of every map.
    """
    tol = positive("tol", tol)
    gradient_norm = stationarity(problem, blocks)
    diagonal = np.einsum("icc->ic", problem.pose_blocks)[:, : problem.d]
    scale = float(diagonal.mean())
    share = float(max(_SHIFT, min(gradient_norm, _ROUNDING / 2.0)))
    first = share * scale
    shift = first if eta is None else max(first, positive("eta", eta))
    s = _CertificateMatrix.at(problem, blocks)
    passed = s.factorise(shift / scale * diagonal)
    rounding = passed is not None and shift <= _ROUNDING * scale
    lowest, direction = (0.0, None) if rounding else _lowest(s, first)
    if passed is None:
        shift = _least_shift(s, max(shift, -lowest))
    cost = lifted_cost(problem, blocks)
    floor = _multiplier_trace(problem, blocks, cost) - problem.d * problem.n * shift
    negligible = _GAP * cost + (_ROUNDING * float(diagonal.sum()) if rounding else 0.0)
    return Certificate(
        verdict=_verdict(gradient_norm <= tol, cost - floor <= negligible),
        stationarity=gradient_norm,
        lambda_min=lowest,
        eta=shift,
        cost=cost,
        lower_bound=floor,
        direction=None if passed else direction,
    )


def _verdict(stationary: bool, closed: bool) -> Verdict:
    if not stationary:
        return Verdict.NOT_STATIONARY
    return Verdict.CERTIFIED if closed else Verdict.NOT_CERTIFIED


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
        return cls(pattern, pattern.sum_edges(s), 2.0 * float(np.abs(multipliers).sum()))

    def factorise(self, eta: float | Array) -> PoseFactors | None:
        """Return the factors of S + diag(η, 0), or None if it is not positive definite.

        ``eta`` is one number or ``(n, d)``, over the rotations' columns.
        """
        shift = np.zeros((self.pattern.n, self.pattern.block))
        shift[1:, :-1] = eta
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


def _lowest(s: _CertificateMatrix, least: float) -> tuple[float, Array]:
    """Return λ_min of S_R and its eigenvector ``(n, d + 1)`` with optimal positions.

    It is found by inverse iterations with S + σI, where σ passes the Cholesky test and is at
    most 4 times the least shift that does: then λ_min is well separated.

    Source: Ericsson and Ruhe 1980, the shifted and inverted Lanczos method; the choice of σ
    is derived here.
    """
    shift, factors = _bracket(s, least)
    inverse, rotations = _largest(s.pattern.n - 1, s.pattern.block - 1, factors)
    full = _solved(factors, rotations)
    return 1.0 / inverse - shift, full / np.linalg.norm(full[:, :-1])


def _bracket(s: _CertificateMatrix, least: float) -> tuple[float, PoseFactors]:
    """Return a shift of at least ``least`` that passes, and its factors."""
    below, shift = least, least
    while s.factorise(shift) is None:
        if shift > s.ceiling:
            raise singular("the certificate matrix is")
        below, shift = shift, 100.0 * shift
    while shift > 4.0 * below:
        middle = float(np.sqrt(below * shift))
        if s.factorise(middle) is None:
            below = middle
        else:
            shift = middle
    factors = s.factorise(shift)
    assert factors is not None
    return shift, factors


def _largest(n: int, d: int, factors: PoseFactors) -> tuple[float, Array]:
    """Return the largest eigenvalue of (S_R + σI)⁻¹ and its eigenvector ``(n, d)``.

    Where ARPACK does not converge within its restarts, it is the Rayleigh quotient and the
    vector of plain inverse iterations.
    """
    size = n * d

    def apply(x: Array) -> Array:
        rotations = x.reshape(n, d, *x.shape[1:])
        return _solved(factors, rotations)[:, :-1].reshape(x.shape)

    if size <= _DENSE:
        full = apply(np.eye(size))
        values, vectors = np.linalg.eigh(0.5 * (full + full.T))
        return float(values[-1]), vectors[:, -1].reshape(n, d)
    operator = LinearOperator((size, size), matvec=apply, dtype=np.float64)
    vector = np.random.default_rng(0).normal(size=size)
    try:
        values, vectors = eigsh(
            operator, k=1, which="LM", v0=vector, tol=_EIGENVALUE_TOLERANCE, maxiter=_RESTARTS
        )
        return float(values[-1]), vectors[:, -1].reshape(n, d)
    except ArpackNoConvergence:
        for _ in range(_POWERS):
            vector = apply(vector / np.linalg.norm(vector))
        unit = vector / np.linalg.norm(vector)
        return float(unit @ apply(unit)), unit.reshape(n, d)


def _least_shift(s: _CertificateMatrix, above: float) -> float:
    """Return a shift just above ``above`` that passes the Cholesky test."""
    margin = 1e-10
    while s.factorise(above * (1.0 + margin)) is None:
        margin *= 10.0
    return above * (1.0 + margin)
