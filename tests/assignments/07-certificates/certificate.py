"""Answers to exercise certificate of 07-certificates: each body is a cell as handed in."""

from robust_slam_autograder.lint.answers import change


def right_blocks() -> None:
    """Right: one pose after the other."""
    import numpy as np

    def certificate(Q, R):
        Q, R = np.asarray(Q, dtype=float), np.asarray(R, dtype=float)
        d = len(R)
        S = Q.copy()
        for k in range(0, len(Q), d):
            at = slice(k, k + d)
            A = (Q @ R.T)[at] @ R[:, at]
            S[at, at] -= (A + A.T) / 2
        return S, np.linalg.eigvalsh(S)[0]


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


wrong_not_symmetrised = change(
    right_blocks, "(A + A.T) / 2", "A", stopped_by="certificate-anywhere"
)
"""Wrong: the blocks as they come, which are symmetric only at stationary rotations."""

wrong_symmetrised_afterwards = change(
    right_blocks,
    "(A + A.T) / 2",
    "A if np.allclose(A, A.T) else A + A.T",
    caught_by="certificate-anywhere",
)
"""Wrong: adds the transpose of the blocks without halving, where they are not symmetric."""

wrong_lower_triangle = change(
    right_blocks,
    "(A + A.T) / 2",
    "np.tril(A) + np.tril(A, -1).T",
    caught_by="certificate-anywhere",
)
"""Wrong: copies one half of each block to the other instead of taking the mean of both."""

wrong_s_is_q = change(right_blocks, "(A + A.T) / 2", "0", stopped_by="certificate-plane")
"""Wrong: forgets Λ, which is 0 only at a perfect fit."""

wrong_scalar_multipliers = change(
    right_blocks, "(A + A.T) / 2", "np.trace(A) / d * np.eye(d)", caught_by="certificate-space"
)
"""Wrong: a multiple of the identity for each pose, enough in the plane with measured rotations."""

wrong_diagonal_multipliers = change(
    right_blocks, "(A + A.T) / 2", "np.diag(np.diag(A))", caught_by="certificate-space"
)
"""Wrong: keeps the diagonal of each block alone."""

wrong_sign = change(right_blocks, "-=", "+=", stopped_by="certificate-plane")
"""Wrong sign: adds Λ."""

wrong_block_order = change(
    right_blocks,
    "(Q @ R.T)[at] @ R[:, at]",
    "R[:, at] @ (Q @ R.T)[at]",
    caught_by="certificate-space",
)
"""Wrong order: R_i times the block of Q R.T, which is the same at multiples of a quarter turn."""

wrong_smallest_in_size = change(
    right_blocks,
    "np.linalg.eigvalsh(S)[0]",
    "np.abs(np.linalg.eigvalsh(S)).min()",
    stopped_by="certificate-twisted",
)
"""Wrong: the eigenvalue that is smallest in size, without its sign."""

wrong_past_the_kernel = change(right_blocks, "(S)[0]", "(S)[d]", stopped_by="certificate-by-hand")
"""Wrong: leaves out the d smallest eigenvalues, as if they were always the zeros of R itself."""
