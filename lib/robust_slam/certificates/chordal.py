"""The chordal problem of a pose graph: least squares that is quadratic in [R | t].

Its cost is Σ κ ‖R_j − R_i R̃‖²_F + τ ‖t_j − t_i − R_i t̃‖² over the edges, without a ½.
It measures rotation errors by chords instead of angles, so its minimum differs slightly
from that of ``pose_graph.cost``. The certificates are about this problem.

The unknown is X = [R_0 t_0 R_1 t_1 …] ``(r, (d + 1) n)``, one block [R | t] of d + 1
columns for each pose; d is 2 or 3, and the rank r is d for a map, more on the Riemannian
staircase. With the data matrix M the cost is tr(X M Xᵀ).

Source: Rosen et al. 2019, "SE-Sync", Problem 1 and its data matrix.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import coo_array, csc_array

from robust_slam._arrays import Array, Indices
from robust_slam.graphs.pose_graph import PoseGraph, check_poses, check_weights, precisions
from robust_slam.groups import se2, se3
from robust_slam.groups.group import Group, group_of
from robust_slam.groups.rotations import nearest_rotations


@dataclass(frozen=True, eq=False)
class ChordalProblem:
    """The chordal problem over the edges of positive weight, as arrays.

    ``measured`` ``(m, d + 1, d + 1)`` holds T̃ = [[R̃, t̃], [0, 1]] and ``precision``
    ``(m, d + 1)`` the weighted (κ, …, κ, τ) of each edge, so that an edge costs
    tr((X_j − X_i T̃) W (X_j − X_i T̃)ᵀ) with W = diag(κ, …, κ, τ). The iterate of its
    functions is ``blocks`` ``(n, r, d + 1)``: [R_i | t_i] for each pose.
    """

    n: int
    d: int
    edges: Indices
    measured: Array
    precision: Array

    @classmethod
    def of(cls, graph: PoseGraph, weights: ArrayLike | None = None) -> ChordalProblem:
        """Return the problem of ``graph``; ``weights`` ``(m,)`` multiply κ and τ.

        They are 1 if None. Edges of weight 0 are left out.

        Raises:
            ValueError: ``weights`` have the wrong shape, are not finite, or one is negative.
            Underdetermined: the edges with positive weight do not connect all poses.
        """
        full = check_weights(weights, graph)
        used = full > 0.0
        d = graph.group.DIMENSION
        kappa, tau = precisions(graph)
        measured = np.zeros((np.count_nonzero(used), d + 1, d + 1))
        measured[:, :d] = pose_blocks(graph.measurement[used])
        measured[:, d, d] = 1.0
        precision = (full[:, None] * np.stack([kappa] * d + [tau], axis=1))[used]
        return cls(graph.n, d, graph.edges[used], measured, precision)

    @cached_property
    def edge_blocks(self) -> Array:
        """The contribution of each edge to M, ``(m, 2, 2, d + 1, d + 1)`` over rows and columns.

        The blocks of (i, j) are [[T̃ W T̃ᵀ, −T̃ W], [−W T̃ᵀ, W]].
        """
        t = self.measured
        weighted = t * self.precision[:, None, :]
        blocks = np.empty((len(t), 2, 2, *t.shape[1:]))
        blocks[:, 0, 0] = weighted @ np.swapaxes(t, 1, 2)
        blocks[:, 0, 1] = -weighted
        blocks[:, 1, 0] = -np.swapaxes(weighted, 1, 2)
        blocks[:, 1, 1] = self.precision[:, :, None] * np.eye(self.d + 1)
        return blocks

    @cached_property
    def pose_blocks(self) -> Array:
        """The diagonal blocks of M, ``(n, d + 1, d + 1)``."""
        blocks = np.zeros((self.n, self.d + 1, self.d + 1))
        np.add.at(blocks, self.edges, self.edge_blocks[:, (0, 1), (0, 1)])
        return blocks


def edge_residuals(problem: ChordalProblem, blocks: Array) -> Array:
    """Return X_j − X_i T̃ of each edge, ``(m, r, d + 1)``.

    The first d columns are R_j − R_i R̃, the last is t_j − t_i − R_i t̃ in m.
    """
    d = problem.d
    i, j = problem.edges.T
    difference = blocks[j]
    # Subtract the positions first: far from the origin this limits cancellation.
    difference[..., d] -= blocks[i][..., d]
    return np.asarray(difference - blocks[i][..., :d] @ problem.measured[:, :d])


def lifted_cost(problem: ChordalProblem, blocks: Array) -> float:
    """Return tr(X M Xᵀ) of ``blocks`` ``(n, r, d + 1)``, as a sum of squares over the edges.

    This avoids cancellation where the cost is small.
    """
    return float(np.sum(problem.precision[:, None] * edge_residuals(problem, blocks) ** 2))


def chordal_cost(graph: PoseGraph, poses: ArrayLike, weights: ArrayLike | None = None) -> float:
    """Return Σ w (κ ‖R_j − R_i R̃‖²_F + τ ‖t_j − t_i − R_i t̃‖²) of ``poses``, without a ½.

    ``poses`` are ``(n, 3)`` or ``(n, 3, 4)``; ``weights`` ``(m,)`` are 1 if None.

    Raises:
        ValueError: ``poses`` or ``weights`` have the wrong shape or are not finite, or a
            weight is negative.
        Underdetermined: the edges with positive weight do not connect all poses.

    Source: Rosen et al. 2019, Problem 1.
    """
    blocks = pose_blocks(check_poses("poses", poses, graph))
    return lifted_cost(ChordalProblem.of(graph, weights), blocks)


def assemble(problem: ChordalProblem, blocks: Array) -> csc_array:
    """Return the sparse sum, of (d + 1) n rows, of blocks as in ``edge_blocks``.

    ``blocks`` are ``(m, 2, 2, d + 1, d + 1)``, over rows and columns.
    """
    width = problem.d + 1
    at = width * problem.edges[:, :, None] + np.arange(width)
    row = np.broadcast_to(at[:, :, None, :, None], blocks.shape)
    column = np.broadcast_to(at[:, None, :, None, :], blocks.shape)
    size = width * problem.n
    full = coo_array((blocks.ravel(), (row.ravel(), column.ravel())), shape=(size, size))
    return csc_array(full)


def edge_gradients(problem: ChordalProblem, blocks: Array) -> Array:
    """Return the contribution of each edge to X M at its ends, ``(m, 2, r, d + 1)``.

    With E = (X_j − X_i T̃) W these are −E T̃ᵀ at i and E at j, half the gradient of the cost.
    """
    weighted = edge_residuals(problem, blocks) * problem.precision[:, None]
    return np.stack([-weighted @ np.swapaxes(problem.measured, 1, 2), weighted], axis=1)


def certificate_blocks(problem: ChordalProblem, blocks: Array) -> Array:
    """Return the contribution of each edge to S = M − Λ, ``(m, 2, 2, d + 1, d + 1)``.

    Λ is block diagonal, Λ_i = sym(R_iᵀ (X M)_i) on the rotation of pose i and 0 on its
    position. X M is a sum over edges, so Λ and S are sums over edges too.

    Source: Rosen et al. 2019, equations (107) and (112), with the translations kept.
    """
    d = problem.d
    rotation = blocks[..., :d][problem.edges]
    product = np.swapaxes(rotation, -1, -2) @ edge_gradients(problem, blocks)[..., :d]
    s = problem.edge_blocks.copy()
    s[:, (0, 1), (0, 1), :d, :d] -= 0.5 * (product + np.swapaxes(product, -1, -2))
    return s


def pose_blocks(poses: Array) -> Array:
    """Return ``poses`` ``(n, 3)`` or ``(n, 3, 4)`` as blocks [R | t] ``(n, d, d + 1)``."""
    group = group_of(poses)
    return np.concatenate([group.rotation(poses), group.translation(poses)[..., None]], axis=-1)


def project(blocks: Array) -> Array:
    """Return poses ``(n, 3)`` or ``(n, 3, 4)`` near ``blocks`` ``(n, r, d + 1)``, r ≥ d.

    X is projected on its d dominant left singular vectors, and each block is replaced by the
    nearest rotation. A map is recovered up to a common rigid motion.

    Source: Rosen et al. 2019, Algorithm 2, rounding by the singular value decomposition.
    """
    n, r, width = blocks.shape
    d = width - 1
    rotations = np.swapaxes(blocks[..., :d], 0, 1).reshape(r, n * d)
    flat = np.linalg.svd(rotations, full_matrices=False)[0][:, :d].T @ blocks
    if np.sum(np.linalg.det(flat[..., :d]) < 0.0) > n / 2:
        flat[:, -1] *= -1.0
    group: Group = se2 if d == 2 else se3
    return group.from_parts(nearest_rotations(flat[..., :d]), flat[..., d])
