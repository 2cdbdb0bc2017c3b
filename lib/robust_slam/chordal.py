"""The chordal problem of a pose graph: least squares that is quadratic in [R | t].

Its cost is Σ κ ‖R_j − R_i R̃‖²_F + τ ‖t_j − t_i − R_i t̃‖² over the edges, without a ½.
It measures rotation errors by chords instead of arcs, so its minimum lies beside that of
``pose_graph.cost``, not at it. The certificates speak about this problem.

The unknown is X = [R_0 t_0 R_1 t_1 …] ``(r, (d + 1) n)``, one block [R | t] of d + 1
columns for each pose; d is 2 or 3, and the rank r is d for a map, more on the Riemannian
staircase. With the data matrix M the cost is tr(X M Xᵀ).

Source: Rosen et al. 2019, "SE-Sync", Problem 1 and its data matrix.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import coo_array, csc_array

from robust_slam import se2, se3
from robust_slam._arrays import Array, finite
from robust_slam.group import Group, group_of
from robust_slam.loop import Underdetermined
from robust_slam.pose_graph import PoseGraph, check_poses, unreached


def precisions(graph: PoseGraph) -> tuple[Array, Array]:
    """Return κ ``(m,)``, without a unit, and τ ``(m,)`` in 1/m²: one number for each block of Ω.

    In SE(2) κ = Ω_θθ and τ = 2 / tr(Ω_tt⁻¹), in SE(3) κ = 3 / (2 tr(Ω_RR⁻¹)) and
    τ = 3 / tr(Ω_tt⁻¹), where Ω_tt and Ω_RR are the diagonal blocks of the information.

    Source: Rosen et al. 2019, the appendix on the measurements' concentration parameters.
    """
    d = graph.group.DIMENSION
    tau = d / _inverse_traces(graph.information[:, :d, :d])
    turn = graph.information[:, d:, d:]
    kappa = turn[:, 0, 0].copy() if d == 2 else 3.0 / (2.0 * _inverse_traces(turn))
    return kappa, tau


def _inverse_traces(blocks: Array) -> Array:
    return np.asarray(np.trace(np.linalg.inv(blocks), axis1=1, axis2=2))


def edge_weights(graph: PoseGraph, weights: ArrayLike | None) -> Array:
    """Return checked ``weights`` ``(m,)`` of edges, all 1 if None.

    Raises:
        ValueError: the shape differs, or a weight is not finite or below 0.
        Underdetermined: the edges with positive weight leave a pose loose.
    """
    m = len(graph.edges)
    full = np.ones(m) if weights is None else finite("weights", weights, (m,))
    if np.any(full < 0.0):
        raise ValueError(f"weights: edge {int(np.argmax(full < 0.0))} weighs less than 0")
    loose = unreached(graph, full > 0.0)
    if loose.size:
        raise Underdetermined(
            f"weights: no edge of positive weight joins pose {loose[0]} to pose 0 "
            f"({loose.size} poses are loose); trust the odometry or keep an edge"
        )
    return full


def edge_precisions(graph: PoseGraph, weights: ArrayLike | None = None) -> Array:
    """Return the weighted precisions (κ, …, κ, τ) of each edge, ``(m, d + 1)``.

    ``weights`` ``(m,)`` multiply κ and τ and are 1 if None; an edge of weight 0 drops out.

    Raises:
        ValueError, Underdetermined: as ``edge_weights``.
    """
    kappa, tau = precisions(graph)
    parts = [kappa] * graph.group.DIMENSION + [tau]
    return edge_weights(graph, weights)[:, None] * np.stack(parts, axis=1)


def homogeneous(graph: PoseGraph) -> Array:
    """Return the measurements as matrices [[R̃, t̃], [0, 1]] ``(m, d + 1, d + 1)``."""
    d = graph.group.DIMENSION
    full = np.zeros((len(graph.edges), d + 1, d + 1))
    full[:, :d, :d] = graph.rotation
    full[:, :d, d] = graph.translation
    full[:, d, d] = 1.0
    return full


def chordal_cost(graph: PoseGraph, poses: ArrayLike, weights: ArrayLike | None = None) -> float:
    """Return Σ w (κ ‖R_j − R_i R̃‖²_F + τ ‖t_j − t_i − R_i t̃‖²) of ``poses``, without a ½.

    ``poses`` ``(n, 3)`` or ``(n, 3, 4)``; ``weights`` ``(m,)`` are 1 if None.

    Raises:
        ValueError: ``poses`` or ``weights`` have the wrong shape or are not finite, or a
            weight is negative.
        Underdetermined: the edges with positive weight leave a pose loose.

    Source: Rosen et al. 2019, Problem 1.
    """
    blocks = pose_blocks(check_poses("poses", poses, graph))
    return float(np.sum(edge_precisions(graph, weights)[:, None] * misfits(graph, blocks) ** 2))


def misfits(graph: PoseGraph, blocks: Array) -> Array:
    """Return X_j − X_i T̃ of each edge, ``(m, r, d + 1)``, for ``blocks`` ``(n, r, d + 1)``.

    The first d columns are R_j − R_i R̃, the last is t_j − t_i − R_i t̃ in m.
    """
    i, j = graph.edges.T
    d = graph.group.DIMENSION
    left, right = blocks[i], blocks[j]
    turned = right[..., :d] - left[..., :d] @ graph.rotation
    # The difference of the positions comes first: far from the origin it is the small one.
    moved = right[..., d] - left[..., d] - (left[..., :d] @ graph.translation[..., None])[..., 0]
    return np.concatenate([turned, moved[..., None]], axis=-1)


def edge_blocks(graph: PoseGraph, weights: ArrayLike | None = None) -> Array:
    """Return what each edge adds to M, ``(m, 2, 2, d + 1, d + 1)`` over rows and columns.

    With W = diag(κ, …, κ, τ) and T̃ the homogeneous measurement the blocks of (i, j) are
    [[T̃ W T̃ᵀ, −T̃ W], [−W T̃ᵀ, W]], from tr((X_j − X_i T̃) W (X_j − X_i T̃)ᵀ).

    Raises:
        ValueError, Underdetermined: as ``edge_weights``.
    """
    precision = edge_precisions(graph, weights)
    t = homogeneous(graph)
    loaded = t * precision[:, None, :]
    blocks = np.zeros((len(t), 2, 2, *t.shape[1:]))
    blocks[:, 0, 0] = loaded @ np.swapaxes(t, 1, 2)
    blocks[:, 0, 1] = -loaded
    blocks[:, 1, 0] = -np.swapaxes(loaded, 1, 2)
    blocks[:, 1, 1] = precision[:, :, None] * np.eye(t.shape[-1])
    return blocks


def data_matrix(graph: PoseGraph, weights: ArrayLike | None = None) -> csc_array:
    """Return M ``((d + 1) n, (d + 1) n)``, sparse and symmetric: the cost is tr(X M Xᵀ).

    Raises:
        ValueError, Underdetermined: as ``edge_weights``.

    Source: Rosen et al. 2019, the data matrix of Problem 1, its columns ordered by pose.
    """
    blocks = edge_blocks(graph, weights)
    width = blocks.shape[-1]
    at = width * graph.edges[:, :, None] + np.arange(width)
    row = np.broadcast_to(at[:, :, None, :, None], blocks.shape)
    column = np.broadcast_to(at[:, None, :, None, :], blocks.shape)
    size = width * graph.n
    full = coo_array((blocks.ravel(), (row.ravel(), column.ravel())), shape=(size, size))
    return csc_array(full)


def marginalised(matrix: csc_array, n: int, d: int) -> Array:
    """Return the dense Q ``(d n, d n)`` of the rotations alone, translations at their best.

    ``matrix`` ``((d + 1) n, (d + 1) n)`` is M, or M − Λ. With the map's translations
    eliminated the cost is tr(R Q Rᵀ) with R = [R_0 R_1 …]. Meant for small graphs.

    Raises:
        ValueError: ``matrix`` has another shape.

    Source: Rosen et al. 2019, Problem 4; a Schur complement, one translation pinned at 0.
    """
    size = (d + 1) * n
    if matrix.shape != (size, size):
        raise ValueError(f"matrix: the shape is {matrix.shape}; give ({size}, {size})")
    full = matrix.toarray()
    turns = np.arange(size) % (d + 1) < d
    places = np.flatnonzero(~turns)[1:]
    across = full[np.ix_(places, turns)]
    joint = full[np.ix_(turns, turns)]
    reduced = joint - across.T @ np.linalg.solve(full[np.ix_(places, places)], across)
    return np.asarray(0.5 * (reduced + reduced.T))


def pose_blocks(poses: Array) -> Array:
    """Return ``poses`` ``(n, 3)`` or ``(n, 3, 4)`` as blocks [R | t] ``(n, d, d + 1)``."""
    group = group_of(poses)
    return np.concatenate([group.rotation(poses), group.translation(poses)[..., None]], axis=-1)


def lift(poses: ArrayLike) -> Array:
    """Return X = [R_0 t_0 R_1 t_1 …] ``(d, (d + 1) n)`` of ``poses``.

    ``poses`` are ``(n, 3)`` or ``(n, 3, 4)``.

    Raises:
        ValueError: the shape is neither.
    """
    return as_matrix(pose_blocks(np.asarray(poses, dtype=np.float64)))


def as_matrix(blocks: Array) -> Array:
    """Return X ``(r, (d + 1) n)`` of ``blocks`` ``(n, r, d + 1)``."""
    return np.swapaxes(blocks, 0, 1).reshape(blocks.shape[1], -1)


def as_blocks(matrix: ArrayLike, n: int) -> Array:
    """Return the blocks ``(n, r, d + 1)`` of X ``(r, (d + 1) n)``.

    Raises:
        ValueError: X is not a matrix of 3 n or 4 n columns.
    """
    x = np.asarray(matrix, dtype=np.float64)
    if x.ndim != 2 or x.shape[1] not in (3 * n, 4 * n):
        raise ValueError(f"matrix: the shape is {x.shape}; give (r, {3 * n}) or (r, {4 * n})")
    return np.swapaxes(x.reshape(len(x), n, -1), 0, 1)


def project(matrix: ArrayLike, n: int) -> Array:
    """Return poses ``(n, 3)`` or ``(n, 3, 4)`` near X ``(r, (d + 1) n)`` of any rank r ≥ d.

    X is turned so that its d strongest directions come first, the others are dropped, and
    each rotation is replaced by the nearest. A map comes back up to one common motion.

    Raises:
        ValueError: X is not a matrix of 3 n or 4 n columns and at least d rows.

    Source: Rosen et al. 2019, Algorithm 2, rounding by the singular value decomposition.
    """
    blocks = as_blocks(matrix, n)
    d = blocks.shape[-1] - 1
    if blocks.shape[1] < d:
        raise ValueError(f"matrix: it has {blocks.shape[1]} rows; give at least {d}")
    strongest = np.linalg.svd(as_matrix(blocks[..., :d]), full_matrices=False)[0][:, :d]
    flat = strongest.T @ blocks
    if np.sum(np.linalg.det(flat[..., :d]) < 0.0) > n / 2:
        flat[:, -1] *= -1.0
    group: Group = se2 if d == 2 else se3
    return group.from_parts(nearest_rotations(flat[..., :d]), flat[..., d])


def nearest_rotations(matrices: ArrayLike) -> Array:
    """Return the rotations ``(…, d, d)`` nearest to ``matrices`` in Frobenius norm.

    Source: Umeyama 1991, the singular value decomposition with the sign of its determinant.
    """
    left, _, right = np.linalg.svd(np.asarray(matrices, dtype=np.float64))
    left[..., -1] *= np.sign(np.linalg.det(left) * np.linalg.det(right))[..., None]
    return np.asarray(left @ right)
