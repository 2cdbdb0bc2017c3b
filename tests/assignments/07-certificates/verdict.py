"""Answers to exercise verdict of 07-certificates: each body is a cell as handed in."""

from robust_slam_autograder.lint.answers import change


def right_in_order() -> None:
    """Right: S by itself, then the two questions in their order."""
    import numpy as np

    def verdict(Q, R, tol):
        Q, R = np.array(Q, dtype=float), np.array(R, dtype=float)
        inside = np.kron(np.eye(len(Q) // len(R)), np.ones((len(R), len(R))))
        A = inside * (Q @ R.T @ R)
        S = Q - (A + A.T) / 2
        small = tol * np.abs(np.linalg.eigvalsh(Q)).max()
        lowest = np.linalg.eigvalsh(S)[0]
        if (np.abs(S @ R.T) > small).any():
            return "not stationary"
        if lowest < -small:
            return "not certified"
        return "certified"


def right_rescaled() -> None:
    """Right, an equivalent form: divides Q by its largest |eigenvalue|, and asks pose by pose."""
    import numpy as np

    def verdict(Q, R, tol):
        R = np.asarray(R, dtype=float)
        Q = np.asarray(Q, dtype=float) / np.linalg.svd(np.asarray(Q, dtype=float))[1][0]
        d = len(R)
        S = Q.copy()
        for k in range(0, len(Q), d):
            A = Q[k : k + d] @ R.T @ R[:, k : k + d]
            S[k : k + d, k : k + d] -= (A + A.T) / 2
        for k in range(0, len(Q), d):
            if np.abs(S[k : k + d] @ R.T).max() > tol:
                return "not stationary"
        return "certified" if min(np.linalg.eigvalsh(S)) >= -tol else "not certified"


def right_cholesky() -> None:
    """Right, by a library routine: S + tol·s·I has a Cholesky factor, or it has none; the order of
    magnitude of S R.T is asked with its norm.
    """
    import numpy as np
    from scipy.linalg import LinAlgError, cholesky

    def verdict(Q, R, tol):
        Q, R = np.asarray(Q, dtype=float), np.asarray(R, dtype=float)
        inside = np.kron(np.eye(len(Q) // len(R)), np.ones((len(R), len(R))))
        A = inside * (Q @ R.T @ R)
        S = Q - (A + A.T) / 2
        small = tol * np.linalg.norm(Q, ord=2)
        if np.linalg.norm(S @ R.T, ord=np.inf) > small:
            return "not stationary"
        try:
            cholesky(S + small * np.eye(len(S)))
        except LinAlgError:
            return "not certified"
        return "certified"


wrong_strictly_positive = change(
    right_in_order, "lowest < -small", "lowest <= small", stopped_by="verdict-by-hand"
)
"""Wrong: asks for λ_min > tol, but S always has R's own directions in its kernel."""

wrong_kernel_of_d = change(
    right_in_order,
    "lowest < -small",
    "lowest < -small or np.linalg.eigvalsh(S)[len(R)] <= small",
    caught_by="verdict-plane",
)
"""Wrong: asks that the eigenvalue after the first d be positive; others may be as good."""

wrong_trace_is_the_cost = change(
    right_in_order,
    "lowest < -small",
    "abs(np.trace(R @ Q @ R.T) - np.trace(A)) > small",
    stopped_by="verdict-plane",
)
"""Wrong: takes tr Λ = tr(R Q R.T) for the proof, which holds at any rotations."""

wrong_no_local_minima = change(
    right_in_order,
    "lowest < -small",
    "len(Q) == 4 and (R.T @ R).min() < -0.9",
    caught_by="verdict-twisted",
)
"""Wrong: certifies what is stationary unless two poses are opposite: no twisted ring is."""

wrong_misprint_at_rest = change(
    right_in_order, "lowest < -small", "False", stopped_by="verdict-plane"
)
"""Wrong: what is stationary is certified, as if no other rotations were: the lesson says so."""

wrong_misprint_rank_one = change(
    right_in_order,
    "lowest < -small",
    "np.linalg.matrix_rank(S, rtol=tol, hermitian=True) != 1",
    stopped_by="verdict-by-hand",
)
"""Wrong: asks that S have rank 1, as the lesson's text does; its rank is dn − d at most."""

wrong_never_asks_for_stationary = change(
    right_in_order,
    "if (np.abs(S @ R.T) > small).any():",
    "if lowest < -small and (np.abs(S @ R.T) > small).any():",
    caught_by="verdict-stationary",
)
"""Wrong: looks at λ_min first, and calls not stationary only what that has refused."""

wrong_order = change(
    right_in_order,
    "if (np.abs(S @ R.T) > small).any():",
    "if lowest >= -small and (np.abs(S @ R.T) > small).any():",
    stopped_by="verdict-by-hand",
)
"""Wrong order: what is not certified is called so, though it is not even stationary."""

wrong_absolute_tolerance = change(
    right_in_order, " * np.abs(np.linalg.eigvalsh(Q)).max()", "", caught_by="verdict-scale"
)
"""Wrong: compares with tol itself, in whatever unit the cost has."""

wrong_own_tolerance = change(right_in_order, "tol *", "1e-7 *", stopped_by="verdict-tol")
"""Wrong: a tolerance of its own, whatever is handed in."""

wrong_zero_without_tolerance = change(
    right_in_order, "lowest < -small", "lowest < -1e-9 * small / tol", caught_by="verdict-tol"
)
"""Wrong: uses tol for S R.T alone, and asks for λ_min ≥ −1e-9."""
