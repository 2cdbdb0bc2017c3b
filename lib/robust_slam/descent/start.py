"""First poses for an optimiser: along a spanning tree, or from the chordal relaxation.

Both put pose 0 at the identity and leave out edges of weight 0. A wrong closure spoils
the chordal start as it spoils least squares; the tree takes closures only to reach poses
that the odometry does not reach.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from robust_slam._arrays import Array, Indices
from robust_slam.descent.sparse.elimination import Elimination
from robust_slam.descent.sparse.pattern import (
    by_pose,
    find_pattern,
    free_elimination,
    pieces_of,
)
from robust_slam.errors import Underdetermined
from robust_slam.graphs.isotropic import precisions
from robust_slam.graphs.pose_graph import PoseGraph, check_weights
from robust_slam.graphs.rotations import nearest_rotations

_LOST = 1e-13
"""The share of a diagonal entry below which its pivot has lost its digits."""


def chordal(graph: PoseGraph, weights: ArrayLike | None = None) -> Array:
    """Return the poses ``(n, …)`` of two linear least-squares problems.

    First Σ w κ ‖R_j − R_i R̃‖²_F is minimised over all matrices, with R_0 = I, and each is
    replaced by the nearest rotation; then Σ w τ ‖t_j − t_i − R_i t̃‖² is minimised over
    the positions, with t_0 = 0. Without noise that is the truth. It needs no first poses
    and is near the optimum as long as the noise of the rotations is moderate, but it is a
    start, not a minimum. ``weights`` ``(m,)`` are 1 if None.

    Raises:
        ValueError: ``weights`` have the wrong shape, are not finite, or one is negative.
        Underdetermined: the edges with positive weight leave a pose loose, or do so to
            working precision.

    Source: Martinec and Pajdla 2007; Carlone et al. 2015, "Initialization techniques for
    3D SLAM".
    """
    full = check_weights(weights, graph)
    used = np.flatnonzero(full)
    kappa, tau = ((full * precision)[used] for precision in precisions(graph))
    edges = graph.edges[used]
    elimination = free_elimination(graph.n, edges)
    turn = _rotations(edges, graph.rotation[used], kappa, elimination)
    step = (turn[edges[:, 0]] @ graph.translation[used][..., None])[..., 0]
    place = _positions(edges, step, tau, elimination)
    return graph.group.from_parts(turn, place)


def _rotations(edges: Indices, measured: Array, kappa: Array, elimination: Elimination) -> Array:
    """Return the rotations ``(n, d, d)`` nearest to the relaxed optimum with R_0 = I."""
    n, d = elimination.order.size + 1, measured.shape[-1]
    one = np.broadcast_to(np.eye(d), measured.shape)
    # The unknowns are the transposed rotations, one below the other: their d columns are
    # d problems with the same matrix.
    rows = [[one, -measured], [-np.swapaxes(measured, 1, 2), one]]
    blocks = kappa[:, None, None, None, None] * np.moveaxis(np.array(rows), 2, 0)
    first = np.zeros((n, d, d))
    first[0] = np.eye(d)
    pull = (blocks @ first[edges][:, None]).sum(axis=2)
    relaxed = first + _least(edges, blocks, np.swapaxes(pull, 0, 1), elimination)
    return nearest_rotations(np.swapaxes(relaxed, 1, 2))


def _positions(edges: Indices, step: Array, tau: Array, elimination: Elimination) -> Array:
    """Return the positions ``(n, d)`` of least Σ τ ‖t_j − t_i − step‖² with t_0 = 0."""
    difference = np.array([[1.0, -1.0], [-1.0, 1.0]])
    blocks = tau[:, None, None] * difference
    pull = np.stack([tau[:, None] * step, -tau[:, None] * step])
    return _least(edges, blocks[..., None, None], pull[:, :, None], elimination)[:, 0]


def _least(edges: Indices, blocks: Array, pull: Array, elimination: Elimination) -> Array:
    """Return the x ``(n, b, c)`` with x_0 = 0 that minimises ½ tr(xᵀ H x) + tr(gᵀ x).

    H is the sum of ``blocks`` ``(m, 2, 2, b, b)`` over both ends of the edges, and g that
    of ``pull`` ``(2, m, b, c)``.
    """
    pattern = find_pattern(elimination.order.size + 1, edges, blocks.shape[-1], elimination)
    matrix = pattern.sum(pieces_of(blocks))
    factors = pattern.factorise(matrix)
    # A pivot this small beside its diagonal entry is what rounding left of a 0.
    if factors is None or np.any(factors.pivots[1:] <= _LOST * pattern.diagonal(matrix)[1:]):
        raise Underdetermined(
            "the chordal problem is singular to working precision: some edges weigh almost "
            "nothing beside the others; give such edges weight 0 or trust more edges"
        )
    return factors.solve(-by_pose(pattern.n, edges, pull))
