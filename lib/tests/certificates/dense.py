"""The chordal problem as dense matrices, which are the reference."""

import numpy as np
from robust_slam.certificates.chordal import ChordalProblem, assemble, pose_blocks


def lift(poses):
    """X = [R_0 t_0 R_1 t_1 …] ``(d, (d + 1) n)`` of poses."""
    return np.concatenate(list(pose_blocks(poses)), axis=1)


def data_matrix(graph, weights=None):
    """M: the cost is tr(X M Xᵀ)."""
    problem = ChordalProblem.of(graph, weights)
    return assemble(problem, problem.edge_blocks).toarray()


def marginalised(matrix, d):
    """M, or M − Λ, over the rotations: a Schur complement with one translation fixed at 0."""
    rotations = np.arange(len(matrix)) % (d + 1) < d
    positions = np.flatnonzero(~rotations)[1:]
    across = matrix[np.ix_(positions, rotations)]
    inner = np.linalg.solve(matrix[np.ix_(positions, positions)], across)
    reduced = matrix[np.ix_(rotations, rotations)] - across.T @ inner
    return 0.5 * (reduced + reduced.T)
