"""The semidefinite relaxation of rotation averaging, small and dense, and its certificate.

Rotations are the blocks of R ``(d, dn)``, side by side, and the cost is
tr(R Q Rᵀ) = Σ κ ‖R_j − R_i R̃‖²_F, without ½. With Z = RᵀR the cost is linear, tr(Q Z), and
Z is positive semidefinite with identity d × d blocks on its diagonal and of rank d. The
relaxation drops the rank, which leaves a convex problem with one optimal value: a lower
bound of the cost of any rotations.

The relaxation is *tight* when its value is the cost of some rotations. These are then a
global optimum, however they were found. Tightness says nothing about an optimiser that has
not reached that cost, and a certificate is about the cost alone: a wrong closure that is
kept is part of the cost, and the distorted optimum is certified too.

A tight Z has rank d, so 2 in the plane and 3 in space, not 1. The certificate S is
positive semidefinite at an optimum, with 0 as an eigenvalue at least d times: test
λ_min ≥ −tol, not λ_min > 0.

Source: Rosen et al. 2019, "SE-Sync", Problem 7 and Theorem 7.
"""

from dataclasses import dataclass
from importlib import import_module
from types import ModuleType

import numpy as np
from numpy.typing import ArrayLike

from robust_slam._arrays import Array, finite
from robust_slam.graphs.pose_graph import checked_edges
from robust_slam.groups.rotations import check_rotations, nearest_rotations

SIZE_LIMIT = 60
"""The largest dn that ``solve_sdp`` accepts, which takes some seconds."""
_GAP = 1e-10
"""The solver's tolerance: its default of 1e-8 gives wrong ranks where noise is large."""


@dataclass(frozen=True, eq=False)
class SdpSolution:
    """The solution of the relaxation.

    ``Z`` ``(dn, dn)`` is the optimum, ``value`` tr(Q Z), ``rank`` its ``numerical_rank``,
    ``eigenvalues`` ``(dn,)`` those of Z, largest first, and ``status`` that of the solver.
    """

    Z: Array
    value: float
    rank: int
    eigenvalues: Array
    status: str


class SdpFailed(RuntimeError):
    """The solver found no optimum."""


def connection_matrix(
    n: int, edges: ArrayLike, rotations: ArrayLike, kappa: ArrayLike = 1.0
) -> Array:
    """Return Q ``(dn, dn)`` with tr(R Q Rᵀ) = Σ κ ‖R_j − R_i R̃‖²_F for R ``(d, dn)``.

    ``edges`` ``(m, 2)`` holds i and j of each measurement, ``rotations`` ``(m, d, d)`` the
    rotation R̃ of j in the frame of i, ``kappa`` a scalar or ``(m,)`` its precision, at least 0.

    Raises:
        ValueError: a shape is wrong, an entry is not finite, an index is out of range, a
            precision is negative, or a matrix is not a rotation.

    Source: Rosen et al. 2019, the rotation connection Laplacian.
    """
    i, j = checked_edges(edges, n).T
    measured = _rotations("rotations", rotations, i.size)
    kappa = _precisions(kappa, i.size)[:, None, None]
    d = measured.shape[-1]
    blocks = np.zeros((n, n, d, d))
    for end in (i, j):
        np.add.at(blocks, (end, end), kappa * np.eye(d))
    np.add.at(blocks, (i, j), -kappa * measured)
    np.add.at(blocks, (j, i), -kappa * np.swapaxes(measured, 1, 2))
    return np.moveaxis(blocks, 2, 1).reshape(n * d, n * d)


def solve_sdp(Q: ArrayLike, d: int) -> SdpSolution:
    """Return the Z ⪰ 0 with identity d × d diagonal blocks that minimises tr(Q Z).

    ``Q`` is ``(dn, dn)`` and symmetric. Where the optimum is not unique, the solver
    returns one of the largest rank.

    Raises:
        ValueError: ``Q`` is not square, symmetric, finite and made of d × d blocks, or is
            larger than ``SIZE_LIMIT``.
        ImportError: cvxpy is missing.
        SdpFailed: the solver finds no optimum.

    Source: Rosen et al. 2019, Problem 7, equation (33).
    """
    cost = _quadratic(Q, d)
    size = len(cost)
    if size > SIZE_LIMIT:
        raise ValueError(
            f"Q: {size} rows are more than {SIZE_LIMIT}, too many for a dense solver; "
            "optimise locally and prove the result with robust_slam.certificates.optimality"
        )
    cp = _cvxpy()
    # The solver's tolerance is partly absolute, so the cost is scaled to size 1.
    scale = float(np.abs(cost).max()) or 1.0
    Z = cp.Variable((size, size), PSD=True)
    unit = [Z[k : k + d, k : k + d] == np.eye(d) for k in range(0, size, d)]
    problem = cp.Problem(cp.Minimize(cp.sum(cp.multiply(cost / scale, Z))), unit)
    try:
        problem.solve(solver=cp.CLARABEL, tol_gap_abs=_GAP, tol_gap_rel=_GAP, tol_feas=_GAP)
    except cp.SolverError as error:
        raise SdpFailed(f"CLARABEL gives up on Q: {error}") from error
    if problem.status not in (cp.OPTIMAL, cp.OPTIMAL_INACCURATE):
        raise SdpFailed(f"CLARABEL says '{problem.status}'; look for extreme entries in Q")
    found = 0.5 * (Z.value + Z.value.T)
    return SdpSolution(
        Z=found,
        value=float(np.sum(cost * found)),
        rank=numerical_rank(found),
        eigenvalues=np.linalg.eigvalsh(found)[::-1],
        status=str(problem.status),
    )


def numerical_rank(Z: ArrayLike, tol: float = 1e-5) -> int:
    """Return how many eigenvalues of the symmetric ``Z`` exceed ``tol`` times the largest.

    Raises:
        ValueError: ``Z`` is not square, symmetric and finite.
    """
    eigenvalues = np.linalg.eigvalsh(_symmetric("Z", Z))
    return int(np.sum(eigenvalues > tol * eigenvalues[-1])) if eigenvalues[-1] > 0.0 else 0


def round_solution(Z: ArrayLike, d: int) -> Array:
    """Return rotations R ``(d, dn)``, R_0 = I, near the best factor of rank d of ``Z``.

    The factor is unique up to a reflection. It is chosen so that most blocks have a positive
    determinant, or block 0 in a tie. Each block is then replaced by
    the nearest rotation. If Z = RᵀR exactly, that R is recovered, and from the solver's Z
    to about 1e-5 rad. If Z has a higher rank, the cost of R may be above the optimum.

    Raises:
        ValueError: ``Z`` ``(dn, dn)`` is not symmetric, finite and made of d × d blocks.

    Source: Rosen et al. 2019, the rounding procedure of SE-Sync.
    """
    eigenvalues, vectors = np.linalg.eigh(_quadratic(Z, d, "Z"))
    factor = np.sqrt(np.maximum(eigenvalues[-d:], 0.0))[:, None] * vectors[:, -d:].T
    positive = np.linalg.det(_blocks(factor)) > 0.0
    votes = 2 * int(np.sum(positive)) - positive.size
    if votes < 0 or (votes == 0 and not positive[0]):
        factor[0] *= -1.0
    rotations = nearest_rotations(_blocks(factor))
    return np.asarray(np.moveaxis(rotations[0].T @ rotations, 0, 1).reshape(d, -1))


def is_tight(Z: ArrayLike, Q: ArrayLike, R: ArrayLike, tol: float = 1e-5) -> bool:
    """Tell whether ``R`` ``(d, dn)`` attains the optimum ``Z`` ``(dn, dn)`` of the relaxation.

    It does if Z has the numerical rank d, and tr(R Q Rᵀ) is tr(Q Z) to ``tol`` times the
    largest |eigenvalue| of ``Q``. ``tol`` is also the relative tolerance of the rank. True
    means that R is a global optimum of this cost, not that its closures are right. False
    is inconclusive: where several rotations are optimal, the solver returns a mixture of
    higher rank although the value is attained.

    Raises:
        ValueError: the shapes do not agree, or ``R`` does not hold rotations.

    Source: Rosen et al. 2019, Theorem 1.
    """
    cost, rotations = _cost_and_row(Q, R)
    d = len(rotations)
    relaxed = _quadratic(Z, d, "Z")
    if relaxed.shape != cost.shape:
        raise ValueError(f"Z: the shape is {relaxed.shape}, and that of Q {cost.shape}")
    gap = float(np.sum((rotations @ cost) * rotations)) - float(np.sum(cost * relaxed))
    scale = float(np.linalg.norm(cost, 2))
    return numerical_rank(relaxed, tol) == d and abs(gap) <= tol * scale


def dense_certificate(Q: ArrayLike, R: ArrayLike) -> tuple[Array, Array]:
    """Return S = Q − Λ ``(dn, dn)`` at ``R`` ``(d, dn)`` and its eigenvalues, ascending.

    Λ is the symmetric part of the diagonal blocks of Q RᵀR. R is a global optimum if
    S Rᵀ = 0 (it is stationary) and S ⪰ 0, both up to a tolerance that is relative to the
    largest |eigenvalue| of Q. Then 0 is an eigenvalue at least d times; exactly d times
    means that R is the unique optimum up to a common rotation. If S has a negative
    eigenvalue, nothing is proved, and R may still be optimal. tr Λ = tr(R Q Rᵀ) holds at any
    R and proves nothing either.

    Raises:
        ValueError: the shapes do not agree, or ``R`` does not hold rotations.

    Source: Rosen et al. 2019, equations (107) and (112) and Theorem 7.
    """
    cost, rotations = _cost_and_row(Q, R)
    S, d = cost.copy(), len(rotations)
    for k, block in enumerate((cost @ rotations.T).reshape(-1, d, d) @ _blocks(rotations)):
        at = slice(k * d, (k + 1) * d)
        S[at, at] -= 0.5 * (block + block.T)
    return S, np.asarray(np.linalg.eigvalsh(S), dtype=np.float64)


def suboptimality(Q: ArrayLike, R: ArrayLike) -> float:
    """Return max(0, −dn·λ_min) of the certificate, an upper bound on the optimality gap.

    It holds at every ``R`` ``(d, dn)``, stationary or not: Λ + λ_min I is feasible in the
    dual problem, and its trace is tr(R Q Rᵀ) + dn·λ_min.

    Raises:
        ValueError: the shapes do not agree, or ``R`` does not hold rotations.

    Source: derived here from the dual of Rosen et al. 2019, Problem 6.
    """
    eigenvalues = dense_certificate(Q, R)[1]
    return max(0.0, -eigenvalues.size * float(eigenvalues[0]))


def _blocks(R: Array) -> Array:
    """Return the blocks ``(n, d, d)`` of R ``(d, dn)``."""
    d = len(R)
    return np.moveaxis(R.reshape(d, -1, d), 1, 0)


def _precisions(value: ArrayLike, m: int) -> Array:
    given = np.asarray(value, dtype=np.float64)
    kappa = finite("kappa", np.full(m, given) if given.ndim == 0 else given, (m,))
    if np.any(kappa < 0.0):
        raise ValueError(f"kappa: edge {int(np.argmax(kappa < 0.0))} has less than 0")
    return kappa


def _rotations(name: str, value: ArrayLike, count: int) -> Array:
    matrices = finite(name, value, (count, -1, -1))
    d = matrices.shape[-1]
    if matrices.shape[1] != d or d not in (2, 3):
        raise ValueError(f"{name}: the shape is {matrices.shape}; d is 2 or 3 in (m, d, d)")
    check_rotations(f"{name}: block", matrices)
    return matrices


def _cost_and_row(Q: ArrayLike, R: ArrayLike) -> tuple[Array, Array]:
    """Return checked Q ``(dn, dn)`` and R ``(d, dn)``."""
    rotations = finite("R", R, (-1, -1))
    d, width = rotations.shape
    if d not in (2, 3) or width % d or not width:
        raise ValueError(f"R: the shape is {rotations.shape}; give (d, dn), where d is 2 or 3")
    _rotations("R", _blocks(rotations), width // d)
    cost = _quadratic(Q, d)
    if len(cost) != width:
        raise ValueError(f"R: {width} columns do not fit the {len(cost)} rows of Q")
    return cost, rotations


def _symmetric(name: str, value: ArrayLike) -> Array:
    matrix = finite(name, value, (-1, -1))
    if matrix.shape[0] != matrix.shape[1] or not matrix.size:
        raise ValueError(f"{name}: the shape is {matrix.shape}; give a square matrix")
    if np.abs(matrix - matrix.T).max() > 1e-9 * np.abs(matrix).max():
        raise ValueError(f"{name} is not symmetric; give (M + Mᵀ)/2")
    return matrix


def _quadratic(value: ArrayLike, d: int, name: str = "Q") -> Array:
    matrix = _symmetric(name, value)
    if d not in (2, 3) or len(matrix) % d:
        raise ValueError(f"{name}: {len(matrix)} rows are not blocks of d = {d}; d is 2 or 3")
    return matrix


def _cvxpy() -> ModuleType:
    try:
        return import_module("cvxpy")
    except ImportError as error:
        raise ImportError(
            "the relaxation is solved by cvxpy and its CLARABEL: pip install cvxpy clarabel"
        ) from error
