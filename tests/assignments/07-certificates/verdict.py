"""Answers to exercise verdict of 07-certificates: each body is a cell as handed in."""


def right_in_order() -> None:
    """Right: S by itself, then the two questions in their order."""
    import numpy as np

    def verdict(Q, R, tol):
        Q, R = np.array(Q, dtype=float), np.array(R, dtype=float)
        inside = np.kron(np.eye(len(Q) // len(R)), np.ones((len(R), len(R))))
        A = inside * (Q @ R.T @ R)
        S = Q - (A + A.T) / 2
        scale = np.abs(np.linalg.eigvalsh(Q)).max()
        if (np.abs(S @ R.T) > tol * scale).any():
            return "not stationary"
        if np.linalg.eigvalsh(S)[0] < -tol * scale:
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


def wrong_strictly_positive() -> None:
    """Wrong: asks for λ_min > tol, but S always has R's own directions in its kernel. Stopped by
    the visible case verdict-by-hand.
    """
    import numpy as np

    def verdict(Q, R, tol):
        Q, R = np.array(Q, dtype=float), np.array(R, dtype=float)
        inside = np.kron(np.eye(len(Q) // len(R)), np.ones((len(R), len(R))))
        A = inside * (Q @ R.T @ R)
        S = Q - (A + A.T) / 2
        small = tol * np.linalg.norm(Q, 2)
        if np.abs(S @ R.T).max() > small:
            return "not stationary"
        return "certified" if np.linalg.eigvalsh(S)[0] > small else "not certified"


def wrong_kernel_of_d() -> None:
    """Wrong: asks that the eigenvalue after the first d be positive, and refuses the best
    rotations where others are as good. Caught by verdict-plane.
    """
    import numpy as np

    def verdict(Q, R, tol):
        Q, R = np.array(Q, dtype=float), np.array(R, dtype=float)
        inside = np.kron(np.eye(len(Q) // len(R)), np.ones((len(R), len(R))))
        A = inside * (Q @ R.T @ R)
        S = Q - (A + A.T) / 2
        small = tol * np.linalg.norm(Q, 2)
        if np.abs(S @ R.T).max() > small:
            return "not stationary"
        values = np.linalg.eigvalsh(S)
        good = values[0] >= -small and values[len(R)] > small
        return "certified" if good else "not certified"


def wrong_trace_is_the_cost() -> None:
    """Wrong: takes tr Λ = tr(R Q R.T) for the proof, which holds at any rotations. Stopped by the
    visible case verdict-plane.
    """
    import numpy as np

    def verdict(Q, R, tol):
        Q, R = np.array(Q, dtype=float), np.array(R, dtype=float)
        inside = np.kron(np.eye(len(Q) // len(R)), np.ones((len(R), len(R))))
        A = inside * (Q @ R.T @ R)
        S = Q - (A + A.T) / 2
        small = tol * np.linalg.norm(Q, 2)
        if np.abs(S @ R.T).max() > small:
            return "not stationary"
        gap = np.trace(R @ Q @ R.T) - np.trace(A)
        return "certified" if abs(gap) <= small else "not certified"


def wrong_no_local_minima() -> None:
    """Wrong: calls what stands still certified unless two poses are opposite, as if no twisted
    ring were a local minimum. Caught by verdict-twisted.
    """
    import numpy as np

    def verdict(Q, R, tol):
        Q, R = np.array(Q, dtype=float), np.array(R, dtype=float)
        inside = np.kron(np.eye(len(Q) // len(R)), np.ones((len(R), len(R))))
        A = inside * (Q @ R.T @ R)
        S = Q - (A + A.T) / 2
        if np.abs(S @ R.T).max() > tol * np.linalg.norm(Q, 2):
            return "not stationary"
        opposite = len(Q) == 4 and (R.T @ R).min() < -0.9
        return "not certified" if opposite else "certified"


def wrong_misprint_at_rest() -> None:
    """Wrong: what stands still is certified, as if an iterative solver could end at the best
    rotations alone: so the lesson's text says. Stopped by the visible case verdict-plane.
    """
    import numpy as np

    def verdict(Q, R, tol):
        Q, R = np.array(Q, dtype=float), np.array(R, dtype=float)
        inside = np.kron(np.eye(len(Q) // len(R)), np.ones((len(R), len(R))))
        A = inside * (Q @ R.T @ R)
        S = Q - (A + A.T) / 2
        at_rest = np.abs(S @ R.T).max() <= tol * np.linalg.norm(Q, 2)
        return "certified" if at_rest else "not stationary"


def wrong_misprint_rank_one() -> None:
    """Wrong: asks that the certificate matrix have rank 1, as the lesson's text does: its kernel
    has d dimensions, and its rank is dn − d at most. Stopped by the visible case verdict-by-hand.
    """
    import numpy as np

    def verdict(Q, R, tol):
        Q, R = np.array(Q, dtype=float), np.array(R, dtype=float)
        inside = np.kron(np.eye(len(Q) // len(R)), np.ones((len(R), len(R))))
        A = inside * (Q @ R.T @ R)
        S = Q - (A + A.T) / 2
        if np.abs(S @ R.T).max() > tol * np.linalg.norm(Q, 2):
            return "not stationary"
        rank = np.linalg.matrix_rank(S, rtol=tol, hermitian=True)
        return "certified" if rank == 1 else "not certified"


def wrong_never_asks_for_stationary() -> None:
    """Wrong: looks at λ_min first, and calls not stationary only what that has refused. Caught by
    verdict-stationary.
    """
    import numpy as np

    def verdict(Q, R, tol):
        Q, R = np.array(Q, dtype=float), np.array(R, dtype=float)
        inside = np.kron(np.eye(len(Q) // len(R)), np.ones((len(R), len(R))))
        A = inside * (Q @ R.T @ R)
        S = Q - (A + A.T) / 2
        small = tol * np.linalg.norm(Q, 2)
        if np.linalg.eigvalsh(S)[0] >= -small:
            return "certified"
        return "not stationary" if np.abs(S @ R.T).max() > small else "not certified"


def wrong_order() -> None:
    """Wrong order: what is not certified is called so, though it does not even stand still.
    Stopped by the visible case verdict-by-hand.
    """
    import numpy as np

    def verdict(Q, R, tol):
        Q, R = np.array(Q, dtype=float), np.array(R, dtype=float)
        inside = np.kron(np.eye(len(Q) // len(R)), np.ones((len(R), len(R))))
        A = inside * (Q @ R.T @ R)
        S = Q - (A + A.T) / 2
        small = tol * np.linalg.norm(Q, 2)
        if np.linalg.eigvalsh(S)[0] < -small:
            return "not certified"
        return "not stationary" if np.abs(S @ R.T).max() > small else "certified"


def wrong_absolute_tolerance() -> None:
    """Wrong: compares with tol itself, in whatever unit the cost has. Caught by verdict-scale."""
    import numpy as np

    def verdict(Q, R, tol):
        Q, R = np.array(Q, dtype=float), np.array(R, dtype=float)
        inside = np.kron(np.eye(len(Q) // len(R)), np.ones((len(R), len(R))))
        A = inside * (Q @ R.T @ R)
        S = Q - (A + A.T) / 2
        if np.abs(S @ R.T).max() > tol:
            return "not stationary"
        return "certified" if np.linalg.eigvalsh(S)[0] >= -tol else "not certified"


def wrong_own_tolerance() -> None:
    """Wrong: a tolerance of its own, whatever is handed in. Stopped by the visible case
    verdict-tol.
    """
    import numpy as np

    def verdict(Q, R, tol):
        Q, R = np.array(Q, dtype=float), np.array(R, dtype=float)
        inside = np.kron(np.eye(len(Q) // len(R)), np.ones((len(R), len(R))))
        A = inside * (Q @ R.T @ R)
        S = Q - (A + A.T) / 2
        small = 1e-7 * np.linalg.norm(Q, 2)
        if np.abs(S @ R.T).max() > small:
            return "not stationary"
        return "certified" if np.linalg.eigvalsh(S)[0] >= -small else "not certified"


def wrong_zero_without_tolerance() -> None:
    """Wrong: uses tol for S R.T and then asks for λ_min ≥ −1e-9, so that rounding in large units
    and small faults refuse the best. Caught by verdict-tol.
    """
    import numpy as np

    def verdict(Q, R, tol):
        Q, R = np.array(Q, dtype=float), np.array(R, dtype=float)
        inside = np.kron(np.eye(len(Q) // len(R)), np.ones((len(R), len(R))))
        A = inside * (Q @ R.T @ R)
        S = Q - (A + A.T) / 2
        scale = np.linalg.norm(Q, 2)
        if np.abs(S @ R.T).max() > tol * scale:
            return "not stationary"
        return "certified" if np.linalg.eigvalsh(S)[0] >= -1e-9 * scale else "not certified"
