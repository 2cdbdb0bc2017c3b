"""Initial poses for an optimiser, from the chordal relaxation.

Pose 0 is the identity, and edges of weight 0 are left out. Outliers distort this start as
they distort least squares; ``graphs.odometry.spanning_tree`` uses closures only to reach
poses that the odometry does not reach.
"""

import numpy as np
from numpy.typing import ArrayLike

from robust_slam._arrays import Array, Indices, times
from robust_slam.descent.sparse.elimination import Elimination
from robust_slam.descent.sparse.pattern import find_pattern, free_elimination, sum_by_pose
from robust_slam.errors import singular
from robust_slam.graphs.pose_graph import PoseGraph, check_weights, precisions
from robust_slam.groups.rotations import nearest_rotations

_SINGULAR = 1e-13
"""A pivot below this share of its diagonal entry counts as 0."""


def chordal(graph: PoseGraph, weights: ArrayLike | None = None) -> Array:
    """Return the poses ``(n, …)`` of two linear least-squares problems.

    First Σ w κ ‖R_j − R_i R̃‖²_F is minimised over all matrices, with R_0 = I, and each
    matrix is replaced by the nearest rotation. Then Σ w τ ‖t_j − t_i − R_i t̃‖² is minimised
    over the positions, with t_0 = 0. Without noise the result is exact. No initial poses are
    needed, and the result is close to the optimum when the rotation noise is moderate, but
    it is not a minimum. ``weights`` ``(m,)`` are 1 if None.

    Raises:
        ValueError: ``weights`` have the wrong shape, are not finite, or one is negative.
        Underdetermined: edges of positive weight do not connect all poses, or nearly so.

    Source: Martinec and Pajdla 2007; Carlone et al. 2015, "Initialization techniques for
    3D SLAM", the section on chordal relaxation.
    """
    full = check_weights(weights, graph)
    used = np.flatnonzero(full)
    kappa, tau = ((full * precision)[used] for precision in precisions(graph))
    edges = graph.edges[used]
    elimination = free_elimination(graph.n, edges)
    rotations = _rotations(edges, graph.rotation[used], kappa, elimination)
    step = times(rotations[edges[:, 0]], graph.translation[used])
    positions = _positions(edges, step, tau, elimination)
    return graph.group.from_parts(rotations, positions)


def _rotations(edges: Indices, measured: Array, kappa: Array, elimination: Elimination) -> Array:
    """Return the rotations ``(n, d, d)`` nearest to the relaxed optimum with R_0 = I."""
    n, d = elimination.order.size + 1, measured.shape[-1]
    identity = np.broadcast_to(np.eye(d), measured.shape)
    # The unknowns are the transposed rotations, stacked: their d columns are d problems
    # with the same matrix.
    rows = [[identity, -measured], [-np.swapaxes(measured, 1, 2), identity]]
    blocks = kappa[:, None, None, None, None] * np.moveaxis(np.array(rows), 2, 0)
    first = np.zeros((n, d, d))
    first[0] = np.eye(d)
    gradient = (blocks @ first[edges][:, None]).sum(axis=2)
    relaxed = first + _minimise(edges, blocks, np.swapaxes(gradient, 0, 1), elimination)
    return nearest_rotations(np.swapaxes(relaxed, 1, 2))


def _positions(edges: Indices, step: Array, tau: Array, elimination: Elimination) -> Array:
    """Return the positions ``(n, d)`` that minimise Σ τ ‖t_j − t_i − step‖², t_0 = 0."""
    difference = np.array([[1.0, -1.0], [-1.0, 1.0]])
    blocks = tau[:, None, None] * difference
    gradient = np.stack([tau[:, None] * step, -tau[:, None] * step])
    return _minimise(edges, blocks[..., None, None], gradient[:, :, None], elimination)[:, 0]


def _minimise(edges: Indices, blocks: Array, gradient: Array, elimination: Elimination) -> Array:
    """Return the x ``(n, b, c)`` with x_0 = 0 that minimises ½ tr(xᵀ H x) + tr(gᵀ x).

    H is the sum of ``blocks`` ``(m, 2, 2, b, b)`` over both ends of the edges, and g that
    of ``gradient`` ``(2, m, b, c)``.
    """
    pattern = find_pattern(elimination.order.size + 1, edges, blocks.shape[-1], elimination)
    matrix = pattern.sum_edges(blocks)
    factors = pattern.factorise(matrix)
    # A pivot this small relative to its diagonal entry is 0 up to rounding.
    if factors is None or np.any(factors.pivots[1:] <= _SINGULAR * pattern.diagonal(matrix)[1:]):
        raise singular("the chordal problem is")
    return factors.solve(-sum_by_pose(pattern.n, edges, gradient))
