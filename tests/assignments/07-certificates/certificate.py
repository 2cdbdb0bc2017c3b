"""Answers to exercise certificate of 07-certificates: each body is a cell as handed in."""


def right_block_by_block() -> None:
    """Right: one pose after the other."""
    import numpy as np

    def certificate(Q, R):
        Q, R = np.asarray(Q, dtype=float), np.asarray(R, dtype=float)
        d, dn = R.shape
        Lambda = np.zeros((dn, dn))
        for i in range(dn // d):
            at = slice(i * d, (i + 1) * d)
            A = (Q @ R.T)[at] @ R[:, at]
            Lambda[at, at] = 0.5 * (A + A.T)
        S = Q - Lambda
        return S, np.linalg.eigvalsh(S).min()


def right_mask() -> None:
    """Right: vectorised; the diagonal blocks are cut out by a mask, and the answer is lists."""
    import numpy as np

    def certificate(Q, R):
        d, dn = np.shape(R)
        inside = np.kron(np.eye(dn // d), np.ones((d, d)))
        A = inside * (np.array(Q) @ np.transpose(R) @ np.array(R))
        S = np.array(Q) - (A + A.T) / 2
        return S.tolist(), float(np.linalg.eigvalsh(S)[0])


def right_einsum_and_scipy() -> None:
    """Right, by library routines: einsum for the blocks, scipy for the smallest eigenvalue."""
    import numpy as np
    from scipy.linalg import block_diag, eigh

    def certificate(Q, R):
        Q, R = np.asarray(Q, dtype=float), np.asarray(R, dtype=float)
        d = len(R)
        n = R.shape[1] // d
        blocks = R.reshape(d, n, d).transpose(1, 0, 2)
        A = np.einsum("iab,ibc->iac", (Q @ R.T).reshape(n, d, d), blocks)
        S = Q - block_diag(*(0.5 * (A + A.transpose(0, 2, 1))))
        return [S, eigh(S, eigvals_only=True, subset_by_index=[0, 0])[0]]


def right_least_squares() -> None:
    """Right, an equivalent form: each block of Λ is the symmetric matrix that brings its rows of
    S R.T nearest to 0, found by least squares.
    """
    import numpy as np

    def certificate(Q, R):
        Q, R = np.asarray(Q, dtype=float), np.asarray(R, dtype=float)
        d = len(R)
        S = Q.copy()
        pairs = [(a, b) for a in range(d) for b in range(a, d)]
        for k in range(0, R.shape[1], d):
            at = slice(k, k + d)
            shapes = []
            for a, b in pairs:
                unit = np.zeros((d, d))
                unit[a, b] = unit[b, a] = 1.0
                shapes.append(unit)
            A = np.array([(unit @ R[:, at].T).ravel() for unit in shapes]).T
            x = np.linalg.lstsq(A, (Q @ R.T)[at].ravel(), rcond=None)[0]
            S[at, at] -= sum(value * unit for value, unit in zip(x, shapes))
        return S, min(np.linalg.eigvalsh(S))


def wrong_not_symmetrised() -> None:
    """Wrong: the blocks as they come, which are symmetric only where the cost stands still.
    Stopped by the visible case certificate-anywhere.
    """
    import numpy as np

    def certificate(Q, R):
        Q, R = np.asarray(Q, dtype=float), np.asarray(R, dtype=float)
        d = len(R)
        S = Q.copy()
        M = Q @ R.T @ R
        for k in range(0, len(Q), d):
            S[k : k + d, k : k + d] -= M[k : k + d, k : k + d]
        return S, np.linalg.eigvalsh(S)[0]


def wrong_symmetrised_afterwards() -> None:
    """Wrong: adds the transpose of the blocks without halving, where they are not symmetric by
    themselves. Caught by certificate-anywhere.
    """
    import numpy as np

    def certificate(Q, R):
        Q, R = np.asarray(Q, dtype=float), np.asarray(R, dtype=float)
        d = len(R)
        S = Q.copy()
        M = Q @ R.T @ R
        for k in range(0, len(Q), d):
            A = M[k : k + d, k : k + d]
            S[k : k + d, k : k + d] -= A if np.allclose(A, A.T) else A + A.T
        return S, np.linalg.eigvalsh(S)[0]


def wrong_lower_triangle() -> None:
    """Wrong: copies one half of each block to the other instead of taking the mean of both. Caught
    by certificate-anywhere.
    """
    import numpy as np

    def certificate(Q, R):
        Q, R = np.asarray(Q, dtype=float), np.asarray(R, dtype=float)
        d = len(R)
        S = Q.copy()
        M = Q @ R.T @ R
        for k in range(0, len(Q), d):
            A = np.tril(M[k : k + d, k : k + d])
            S[k : k + d, k : k + d] -= A + np.tril(A, -1).T
        return S, np.linalg.eigvalsh(S)[0]


def wrong_s_is_q() -> None:
    """Wrong: forgets Λ, which is 0 only at a perfect fit. Stopped by the visible case
    certificate-plane.
    """
    import numpy as np

    def certificate(Q, R):
        return np.asarray(Q, dtype=float), np.linalg.eigvalsh(Q)[0]


def wrong_scalar_multipliers() -> None:
    """Wrong: a number times the identity for each pose, which is enough in the plane where Q comes
    from measured turns. Caught by certificate-space.
    """
    import numpy as np

    def certificate(Q, R):
        Q, R = np.asarray(Q, dtype=float), np.asarray(R, dtype=float)
        d = len(R)
        S = Q.copy()
        M = Q @ R.T @ R
        for k in range(0, len(Q), d):
            S[k : k + d, k : k + d] -= np.trace(M[k : k + d, k : k + d]) / d * np.eye(d)
        return S, np.linalg.eigvalsh(S)[0]


def wrong_diagonal_multipliers() -> None:
    """Wrong: keeps the diagonal of each block alone. Caught by certificate-space."""
    import numpy as np

    def certificate(Q, R):
        Q, R = np.asarray(Q, dtype=float), np.asarray(R, dtype=float)
        S = Q - np.diag(np.diag(Q @ R.T @ R))
        return S, np.linalg.eigvalsh(S)[0]


def wrong_sign() -> None:
    """Wrong sign: adds Λ. Stopped by the visible case certificate-plane."""
    import numpy as np

    def certificate(Q, R):
        Q, R = np.asarray(Q, dtype=float), np.asarray(R, dtype=float)
        inside = np.kron(np.eye(len(Q) // len(R)), np.ones((len(R), len(R))))
        A = inside * (Q @ R.T @ R)
        S = Q + (A + A.T) / 2
        return S, np.linalg.eigvalsh(S)[0]


def wrong_block_order() -> None:
    """Wrong order: R_i times the block of Q R.T instead of the other way round, which is the same
    at poses turned by multiples of a quarter turn and by nothing. Caught by certificate-space.
    """
    import numpy as np

    def certificate(Q, R):
        Q, R = np.asarray(Q, dtype=float), np.asarray(R, dtype=float)
        d = len(R)
        S = Q.copy()
        for k in range(0, len(Q), d):
            A = R[:, k : k + d] @ (Q @ R.T)[k : k + d]
            S[k : k + d, k : k + d] -= (A + A.T) / 2
        return S, np.linalg.eigvalsh(S)[0]


def wrong_smallest_in_size() -> None:
    """Wrong: the eigenvalue that is smallest in size, without its sign. Stopped by the visible
    case certificate-twisted.
    """
    import numpy as np

    def certificate(Q, R):
        Q, R = np.asarray(Q, dtype=float), np.asarray(R, dtype=float)
        inside = np.kron(np.eye(len(Q) // len(R)), np.ones((len(R), len(R))))
        A = inside * (Q @ R.T @ R)
        S = Q - (A + A.T) / 2
        return S, np.abs(np.linalg.eigvalsh(S)).min()


def wrong_past_the_kernel() -> None:
    """Wrong: leaves out the d smallest eigenvalues, as if they were always the zeros of R's own
    directions. Stopped by the visible case certificate-by-hand.
    """
    import numpy as np

    def certificate(Q, R):
        Q, R = np.asarray(Q, dtype=float), np.asarray(R, dtype=float)
        inside = np.kron(np.eye(len(Q) // len(R)), np.ones((len(R), len(R))))
        A = inside * (Q @ R.T @ R)
        S = Q - (A + A.T) / 2
        return S, np.linalg.eigvalsh(S)[len(R)]
