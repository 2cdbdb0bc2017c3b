"""Answers to exercise is_tight of 07-certificates: each body is a cell as handed in."""

from robust_slam_autograder.lint.answers import change


def right_traces() -> None:
    """Right: counts eigenvalues and compares traces."""
    import numpy as np

    def is_tight(Z, Q, R, tol):
        Z, Q, R = np.array(Z, dtype=float), np.array(Q, dtype=float), np.array(R, dtype=float)
        values = np.linalg.eigvalsh((Z + Z.T) / 2)
        rank = np.sum(values > tol * values[-1])
        gap = np.trace(R @ Q @ R.T) - np.sum(Q * Z)
        return bool(rank == len(R) and abs(gap) <= tol * np.linalg.norm(Q, 2))


def right_matrix_rank() -> None:
    """Right, by a library routine: numpy's matrix_rank, and a numpy boolean."""
    import numpy as np

    def is_tight(Z, Q, R, tol):
        rank = np.linalg.matrix_rank(np.asarray(Z), rtol=tol, hermitian=True)
        scale = np.linalg.svd(np.asarray(Q), compute_uv=False)[0]
        gap = np.trace(np.asarray(R) @ Q @ np.transpose(R)) - np.trace(np.asarray(Q) @ Z)
        return np.logical_and(rank == len(R), np.abs(gap) <= tol * scale)


def right_loops() -> None:
    """Right: singular values of Z, the costs entry by entry, the gap on its upper side alone."""
    import numpy as np

    def is_tight(Z, Q, R, tol):
        d = len(R)
        rank = 0
        sizes = np.linalg.svd(Z)[1]
        for size in sizes:
            if size > tol * sizes[0]:
                rank += 1
        if rank != d:
            return False
        bound = cost = 0.0
        for a in range(len(Q)):
            for b in range(len(Q)):
                bound += Q[a][b] * Z[b][a]
                cost += Q[a][b] * sum(R[row][a] * R[row][b] for row in range(d))
        return cost - bound <= tol * float(np.linalg.norm(Q, 2))


wrong_misprint_rank_one = change(right_traces, "len(R)", "1", stopped_by="is_tight-by-hand")
"""Wrong: asks for rank 1, as the lesson's text does."""

wrong_rank_two = change(right_traces, "== len(R)", "== 2", stopped_by="is_tight-space")
"""Wrong: asks for rank 2 in space too."""

wrong_rank_alone = change(
    right_traces, " and abs(gap) <= tol * np.linalg.norm(Q, 2)", "", stopped_by="is_tight-by-hand"
)
"""Wrong: looks at the rank of Z and not at what the rotations cost."""

wrong_rank_and_agreement = change(
    right_traces,
    "abs(gap) <= tol * np.linalg.norm(Q, 2)",
    "np.sum(Z * (R.T @ R)) > 0.4 * np.sum(Z * Z)",
    caught_by="is_tight-gap",
)
"""Wrong: takes rank d and rotations that agree with Z by and large for proof, not the costs."""

wrong_cost_alone = change(
    right_traces, "rank == len(R)", "not np.allclose(Z, np.eye(len(Z)))", caught_by="is_tight-rank"
)
"""Wrong: compares the costs and counts no eigenvalues, with an exception for Z = I."""

wrong_absolute_gap = change(
    right_traces, " * np.linalg.norm(Q, 2)", "", caught_by="is_tight-scale"
)
"""Wrong: compares the gap with tol itself, in whatever unit the cost has."""

wrong_share_of_the_cost = change(
    right_traces, "np.linalg.norm(Q, 2)", "abs(np.trace(R @ Q @ R.T))", caught_by="is_tight-scale"
)
"""Wrong: compares the gap with a share of the cost, which is 0 at a perfect fit."""

wrong_own_tolerance = change(
    right_traces, ("tol * values", "1e-6 * values"), ("tol *", "1e-6 *"), caught_by="is_tight-tol"
)
"""Wrong: a tolerance of its own, whatever is handed in."""

wrong_rank_without_tolerance = change(
    right_traces,
    "np.sum(values > tol * values[-1])",
    "np.linalg.matrix_rank(Z)",
    stopped_by="is_tight-tol",
)
"""Wrong: numpy's rank as it is, which counts every error of a solver."""

wrong_less_than_twice_the_rank = change(
    right_traces, "rank == len(R)", "len(R) <= rank < 2 * len(R)", caught_by="is_tight-rank"
)
"""Wrong: refuses a rank of 2d and takes every rank from d to 2d - 1."""

wrong_absolute_rank = change(right_traces, " * values[-1]", "", caught_by="is_tight-tol")
"""Wrong: compares the eigenvalues with tol, not with tol times the largest."""
