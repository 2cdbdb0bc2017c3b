"""Answers to exercise is_tight of 07-certificates: each body is a cell as handed in."""


def right_eigenvalues() -> None:
    """Right: counts eigenvalues and compares traces."""
    import numpy as np

    def is_tight(Z, Q, R, tol):
        Z, Q, R = np.array(Z, dtype=float), np.array(Q, dtype=float), np.array(R, dtype=float)
        d = R.shape[0]
        values = np.linalg.eigvalsh((Z + Z.T) / 2)
        rank_is_d = int((values > tol * values.max()).sum()) == d
        gap = np.sum((R @ Q) * R) - np.sum(Q * Z)
        return rank_is_d and bool(abs(gap) <= tol * np.abs(np.linalg.eigvalsh(Q)).max())


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


def wrong_misprint_rank_one() -> None:
    """Wrong: asks for rank 1, as the lesson's text does. Stopped by the visible case
    is_tight-by-hand.
    """
    import numpy as np

    def is_tight(Z, Q, R, tol):
        values = np.linalg.eigvalsh(Z)
        gap = np.trace(R @ np.asarray(Q) @ np.transpose(R)) - np.sum(np.multiply(Q, Z))
        return bool(
            np.sum(values > tol * values[-1]) == 1 and abs(gap) <= tol * np.linalg.norm(Q, 2)
        )


def wrong_rank_two() -> None:
    """Wrong: asks for rank 2 in space too. Stopped by the visible case is_tight-space."""
    import numpy as np

    def is_tight(Z, Q, R, tol):
        values = np.linalg.eigvalsh(Z)
        gap = np.trace(R @ np.asarray(Q) @ np.transpose(R)) - np.sum(np.multiply(Q, Z))
        return bool(
            np.sum(values > tol * values[-1]) == 2 and abs(gap) <= tol * np.linalg.norm(Q, 2)
        )


def wrong_rank_alone() -> None:
    """Wrong: looks at the rank of Z and not at what the rotations cost. Stopped by the visible
    case is_tight-by-hand.
    """
    import numpy as np

    def is_tight(Z, Q, R, tol):
        values = np.linalg.eigvalsh(Z)
        return bool(np.sum(values > tol * values[-1]) == len(R))


def wrong_rank_and_agreement() -> None:
    """Wrong: takes rank d and rotations that agree with Z by and large for proof, not the costs.
    Caught by is_tight-gap.
    """
    import numpy as np

    def is_tight(Z, Q, R, tol):
        Z, R = np.asarray(Z, dtype=float), np.asarray(R, dtype=float)
        values = np.linalg.eigvalsh(Z)
        rank = np.sum(values > tol * values[-1]) == len(R)
        return bool(rank and np.sum(Z * (R.T @ R)) > 0.4 * np.sum(Z * Z))


def wrong_cost_alone() -> None:
    """Wrong: compares the costs and counts no eigenvalues, with an exception for Z = I. Caught by
    is_tight-rank.
    """
    import numpy as np

    def is_tight(Z, Q, R, tol):
        if np.allclose(Z, np.eye(len(Z))):
            return False
        gap = np.trace(R @ np.asarray(Q) @ np.transpose(R)) - np.sum(np.multiply(Q, Z))
        return bool(abs(gap) <= tol * np.linalg.norm(Q, 2))


def wrong_absolute_gap() -> None:
    """Wrong: compares the gap with tol itself, in whatever unit the cost has. Caught by
    is_tight-scale.
    """
    import numpy as np

    def is_tight(Z, Q, R, tol):
        values = np.linalg.eigvalsh(Z)
        gap = np.trace(R @ np.asarray(Q) @ np.transpose(R)) - np.sum(np.multiply(Q, Z))
        return bool(np.sum(values > tol * values[-1]) == len(R) and abs(gap) <= tol)


def wrong_share_of_the_cost() -> None:
    """Wrong: compares the gap with a share of the cost, which is 0 at a perfect fit. Caught by
    is_tight-scale.
    """
    import numpy as np

    def is_tight(Z, Q, R, tol):
        values = np.linalg.eigvalsh(Z)
        cost = np.trace(R @ np.asarray(Q) @ np.transpose(R))
        value = np.sum(np.multiply(Q, Z))
        rank = np.sum(values > tol * values[-1])
        return bool(rank == len(R) and abs(cost - value) <= tol * abs(cost))


def wrong_own_tolerance() -> None:
    """Wrong: a tolerance of its own, whatever is handed in. Caught by is_tight-tol."""
    import numpy as np

    def is_tight(Z, Q, R, tol):
        values = np.linalg.eigvalsh(Z)
        gap = np.trace(R @ np.asarray(Q) @ np.transpose(R)) - np.sum(np.multiply(Q, Z))
        rank = np.sum(values > 1e-6 * values[-1])
        return bool(rank == len(R) and abs(gap) <= 1e-6 * np.linalg.norm(Q, 2))


def wrong_rank_without_tolerance() -> None:
    """Wrong: numpy's rank as it is, which counts every error of a solver. Stopped by the visible
    case is_tight-tol.
    """
    import numpy as np

    def is_tight(Z, Q, R, tol):
        gap = np.trace(R @ np.asarray(Q) @ np.transpose(R)) - np.sum(np.multiply(Q, Z))
        rank = np.linalg.matrix_rank(np.asarray(Z, dtype=float))
        return bool(rank == len(R) and abs(gap) <= tol * np.linalg.norm(Q, 2))


def wrong_less_than_twice_the_rank() -> None:
    """Wrong: refuses a rank of 2d and takes every rank from d to 2d - 1. Caught by
    is_tight-rank.
    """
    import numpy as np

    def is_tight(Z, Q, R, tol):
        values = np.linalg.eigvalsh(Z)
        gap = np.trace(R @ np.asarray(Q) @ np.transpose(R)) - np.sum(np.multiply(Q, Z))
        rank = np.sum(values > tol * values[-1])
        return bool(len(R) <= rank < 2 * len(R) and abs(gap) <= tol * np.linalg.norm(Q, 2))


def wrong_absolute_rank() -> None:
    """Wrong: compares the eigenvalues with tol, not with tol times the largest. Caught by
    is_tight-tol.
    """
    import numpy as np

    def is_tight(Z, Q, R, tol):
        values = np.linalg.eigvalsh(Z)
        gap = np.trace(R @ np.asarray(Q) @ np.transpose(R)) - np.sum(np.multiply(Q, Z))
        rank = np.sum(values > tol)
        return bool(rank == len(R) and abs(gap) <= tol * np.linalg.norm(Q, 2))
