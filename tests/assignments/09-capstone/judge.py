"""Answers to exercise judge of 09-capstone: each body is a cell as handed in."""

from robust_slam_autograder.lint.answers import change


def right_blocks() -> None:
    """Right: the matrix in blocks, then its smallest eigenvalue."""
    import numpy as np

    def judge(graph, poses):
        def matrix(p):
            c, s = np.cos(p[2]), np.sin(p[2])
            return np.array([[c, -s, p[0]], [s, c, p[1]], [0, 0, 1]])

        n = graph["n"]
        blocks = np.zeros((n, n, 3, 3))
        for (i, j), z, omega in zip(graph["edges"], graph["measurement"], graph["information"]):
            t = matrix(z)
            tau = 2 / np.trace(np.linalg.inv(omega[:2, :2]))
            w = np.diag([omega[2, 2], omega[2, 2], tau])
            blocks[i, i] += t @ w @ t.T
            blocks[j, j] += w
            blocks[i, j] -= t @ w
            blocks[j, i] -= w @ t.T
        m = blocks.transpose(0, 2, 1, 3).reshape(3 * n, 3 * n)
        x = np.hstack([matrix(p)[:2] for p in poses])
        pull = (x @ m).reshape(2, n, 3)
        turn = x.reshape(2, n, 3)
        s = m.copy()
        for k in range(n):
            own = turn[:, k, :2].T @ pull[:, k, :2]
            s[3 * k : 3 * k + 2, 3 * k : 3 * k + 2] -= (own + own.T) / 2
        small = 1e-6 * np.abs(m).max()
        lowest = np.linalg.eigvalsh((s + s.T) / 2)[0]
        if not np.all(np.abs(x @ s) <= small):
            return "not stationary"
        return "certified" if lowest >= -small else "not certified"


def right_cholesky() -> None:
    """Right: a Cholesky test with a small shift, and finite differences of the cost."""
    import numpy as np

    def judge(graph, poses):
        poses = np.array(poses, dtype=float)
        poses[:, :2] -= poses[0, :2]
        i, j = graph["edges"].T
        z, omega = graph["measurement"], graph["information"]
        kappa = omega[:, 2, 2]
        tau = 2 / np.trace(np.linalg.inv(omega[:, :2, :2]), axis1=1, axis2=2)
        n = len(poses)

        def cost(p):
            place, turn = p[:, 0] + 1j * p[:, 1], np.exp(1j * p[:, 2])
            bend = turn[j] - turn[i] * np.exp(1j * z[:, 2])
            gap = place[j] - place[i] - turn[i] * (z[:, 0] + 1j * z[:, 1])
            return np.sum(2 * kappa * np.abs(bend) ** 2 + tau * np.abs(gap) ** 2)

        # The same cost in complex numbers: c = (turns, places), cost = c* M c.
        M = np.zeros((2 * n, 2 * n), dtype=complex)
        for k in range(len(i)):
            row = np.zeros(2 * n, dtype=complex)
            row[j[k]], row[i[k]] = 1, -np.exp(1j * z[k, 2])
            M += 2 * kappa[k] * np.outer(row.conj(), row)
            row = np.zeros(2 * n, dtype=complex)
            row[n + j[k]], row[n + i[k]] = 1, -1
            row[i[k]] -= z[k, 0] + 1j * z[k, 1]
            M += tau[k] * np.outer(row.conj(), row)
        scale = np.abs(M).max()
        slope = np.zeros((n, 3))
        for k in range(n):
            for a in range(3):
                step = np.zeros((n, 3))
                step[k, a] = 1e-5
                slope[k, a] = (cost(poses + step) - cost(poses - step)) / 2e-5
        if np.abs(slope).max() > 1e-5 * scale:
            return "not stationary"
        c = np.concatenate([np.exp(1j * poses[:, 2]), poses[:, 0] + 1j * poses[:, 1]])
        multipliers = np.append(np.real(c[:n].conj() * (M @ c)[:n]), np.zeros(n))
        S = M - np.diag(multipliers) + 1e-6 * scale * np.eye(2 * n)
        try:
            np.linalg.cholesky(S)
        except np.linalg.LinAlgError:
            return "not certified"
        return "certified"


def right_marginalised() -> None:
    """Right, an equivalent form: positions are eliminated, and rotations alone are left."""
    import numpy as np
    from scipy.linalg import block_diag

    def judge(graph, poses):
        poses, n = np.asarray(poses, dtype=float), graph["n"]
        turns = np.array([0, 1]) + 3 * np.arange(n)[:, None]
        M = np.zeros((3 * n, 3 * n))
        for k, (i, j) in enumerate(graph["edges"]):
            x, y, a = graph["measurement"][k]
            c, s = np.cos(a), np.sin(a)
            T = np.array([[c, -s, x], [s, c, y], [0, 0, 1]])
            covariance = np.linalg.inv(graph["information"][k][:2, :2])
            kappa = graph["information"][k][2, 2]
            W = np.diag([kappa, kappa, 2 / (covariance[0, 0] + covariance[1, 1])])
            at = np.concatenate([3 * i + np.arange(3), 3 * j + np.arange(3)])
            M[np.ix_(at, at)] += np.block([[T @ W @ T.T, -T @ W], [-W @ T.T, W]])
        r = turns.ravel()
        t = 3 * np.arange(n) + 2
        Q = M[np.ix_(r, r)] - M[np.ix_(r, t)] @ np.linalg.pinv(M[np.ix_(t, t)]) @ M[np.ix_(t, r)]
        c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
        R = np.stack([np.stack([c, -s], -1).ravel(), np.stack([s, c], -1).ravel()])
        zero = 1e-6 * np.abs(M).max()
        X = np.zeros((2, 3 * n))
        X[:, r], X[:, t] = R, poses[:, :2].T
        if np.abs((X @ M)[:, t]).max() > zero:
            return "not stationary"
        P = R @ Q
        blocks = [R[:, k : k + 2].T @ P[:, k : k + 2] for k in range(0, 2 * n, 2)]
        S = Q - block_diag(*[(b + b.T) / 2 for b in blocks])
        if np.abs(R @ S).max() > zero:
            return "not stationary"
        return "certified" if np.linalg.eigvalsh(S).min() > -zero else "not certified"


wrong_positive_definite = change(right_blocks, ">= -small", "> small", stopped_by="judge-by-hand")
"""Wrong: asks for a smallest eigenvalue above 0, and refuses every map."""

wrong_trace = change(
    right_blocks,
    "lowest >= -small",
    "abs(np.trace(m - s) - np.trace(x @ m @ x.T)) <= small",
    stopped_by="judge-by-hand",
)
"""Wrong: takes the trace of Λ, which is the cost at any map at rest, for a proof."""

wrong_misprint_stationary_is_best = change(
    right_blocks, "lowest >= -small", "True", stopped_by="judge-by-hand"
)
"""Wrong: a stationary map is certified, as if no other were stationary: the lesson says so."""

wrong_never_at_rest = change(
    right_blocks,
    "not np.all(np.abs(x @ s) <= small)",
    "np.trace(x @ m @ x.T) > small",
    stopped_by="judge-by-hand",
)
"""Wrong: asks for a cost of zero, or else the map is not at rest."""

wrong_rotations_at_rest = change(
    right_blocks, "x @ s", "(x @ s).reshape(2, n, 3)[:, :, :2]", stopped_by="judge-rest"
)
"""Wrong: looks at the rotations alone, and positions may be pulled."""

wrong_positions_at_rest = change(
    right_blocks, "x @ s", "(x @ s).reshape(2, n, 3)[:, :, 2]", stopped_by="judge-by-hand"
)
"""Wrong: looks at the positions alone, and rotations may be pulled."""

wrong_not_symmetric = change(right_blocks, "(own + own.T) / 2", "own", stopped_by="judge-by-hand")
"""Wrong: Λ as it comes, not made symmetric, so that every map seems at rest."""

wrong_matrix_of_the_cost = change(
    right_blocks, "lowest >= -", "np.linalg.eigvalsh(m)[0] >= -", stopped_by="judge-by-hand"
)
"""Wrong: looks at the eigenvalues of M, which are never negative, in place of those of S."""

wrong_mean_information = change(
    right_blocks,
    "2 / np.trace(np.linalg.inv(omega[:2, :2]))",
    "(omega[0, 0] + omega[1, 1]) / 2",
    caught_by="judge-precisions",
)
"""Wrong: τ is the mean of two entries of the information, right only where these are all."""

wrong_half_kappa = change(
    right_blocks,
    "[omega[2, 2], omega[2, 2], tau]",
    "[omega[2, 2] / 2, omega[2, 2] / 2, tau]",
    caught_by="judge-optimum",
)
"""Wrong: half of Ω_θθ for κ, so that turns weigh too little beside steps."""

wrong_absolute_zero = change(
    right_blocks, "1e-6 * np.abs(m).max()", "1e-6", caught_by="judge-precisions"
)
"""Wrong: takes 1e-6 itself for zero, in whatever unit the information is."""
