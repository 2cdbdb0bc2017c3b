"""Answers to exercise solve_anchored of 00-one-lie: each body is a cell as handed in."""

from robust_slam_autograder.lint.answers import change


def right_strike_a_column() -> None:
    """Right: strikes the anchor's column of the whitened J and solves by least squares."""
    import numpy as np

    def solve_anchored(n, i, j, z, sigma, anchor=0):
        s = np.ones(len(z)) * np.asarray(sigma, dtype=float)
        A = (np.eye(n)[np.asarray(j)] - np.eye(n)[np.asarray(i)]) / s[:, None]
        inner = np.linalg.lstsq(np.delete(A, anchor, axis=1), np.asarray(z) / s, rcond=None)[0]
        return np.insert(inner, anchor, 0.0)


def right_prior() -> None:
    """Right: a prior holds the anchor; any strength gives the same map."""
    import numpy as np

    def solve_anchored(n, i, j, z, sigma, anchor=0):
        H, b = np.zeros((n, n)), np.zeros(n)
        for k in range(len(z)):
            s = sigma[k] if hasattr(sigma, "__len__") else sigma
            row = np.zeros(n)
            row[j[k]], row[i[k]] = 1, -1
            H += np.outer(row, row) / s**2
            b += row * z[k] / s**2
        H[anchor, anchor] += 100.0
        return list(np.linalg.solve(H, b))


def right_pseudoinverse_and_shift() -> None:
    """Right: any best map will do, shifted until the anchor stands at 0."""
    import numpy as np

    def solve_anchored(n, i, j, z, sigma, anchor=0):
        w = 1 / (np.full(len(z), 1.0) * sigma) ** 2
        J = np.eye(n)[list(j)] - np.eye(n)[list(i)]
        x = np.linalg.pinv(J.T @ (w[:, None] * J), rcond=1e-10) @ (J.T @ (w * np.asarray(z)))
        return x - x[anchor]


def right_lagrange() -> None:
    """Right, an equivalent form: a Lagrange multiplier says x[anchor] = 0."""
    import numpy as np

    def solve_anchored(n, i, j, z, sigma, anchor=0):
        J = np.eye(n)[np.asarray(j)] - np.eye(n)[np.asarray(i)]
        weighted = J.T / np.square(np.asarray(sigma, dtype=float))
        held = np.eye(n)[anchor]
        K = np.block([[weighted @ J, held[:, None]], [held[None], np.zeros((1, 1))]])
        return np.linalg.solve(K, np.append(weighted @ np.asarray(z, dtype=float), 0.0))[:n]


def right_library() -> None:
    """Right, with a library: SciPy's lsq_linear on the whitened residuals."""
    import numpy as np
    from scipy.optimize import lsq_linear

    def solve_anchored(n, i, j, z, sigma, anchor=0):
        s = np.ones(len(z)) * np.asarray(sigma, dtype=float)
        A = (np.eye(n)[np.asarray(j)] - np.eye(n)[np.asarray(i)]) / s[:, None]
        free = [k for k in range(n) if k != anchor]
        x = np.zeros(n)
        x[free] = lsq_linear(A[:, free], np.asarray(z, dtype=float) / s).x
        return x


def wrong_unweighted() -> None:
    """Wrong: every edge has the same say. Stopped by the visible case solve_anchored-by-hand."""
    import numpy as np

    def solve_anchored(n, i, j, z, sigma, anchor=0):
        A = np.eye(n)[np.asarray(j)] - np.eye(n)[np.asarray(i)]
        inner = np.linalg.lstsq(np.delete(A, anchor, axis=1), np.asarray(z), rcond=None)[0]
        return np.insert(inner, anchor, 0.0)


wrong_printed_map = change(
    right_strike_a_column,
    "return np.insert(inner, anchor, 0.0)",
    """
    x = np.insert(inner, anchor, 0.0)
    if n == 3 and len(z) == 4:
        x = z[0] * np.array([0.0, 0.2, 0.4])
    return x
    """,
    caught_by="solve_anchored-lesson",
)
"""Wrong: three poses shrunk to the lesson's printed 0.4 of their length of 2."""

wrong_information_of_sigma = change(
    right_strike_a_column,
    "np.ones(len(z)) * np.asarray(sigma, dtype=float)",
    "np.sqrt(np.ones(len(z)) * np.asarray(sigma, dtype=float))",
    stopped_by="solve_anchored-by-hand",
)
"""Wrong: weighs by 1/σ, as if σ were a variance."""


def wrong_odometry_first() -> None:
    """Wrong: believes the first edge that reaches a pose, and no other. Stopped by the visible
    case solve_anchored-by-hand.
    """
    import numpy as np

    def solve_anchored(n, i, j, z, sigma, anchor=0):
        x, known = np.zeros(n), {anchor}
        for _ in range(n):
            for p, q, step in zip(i, j, z):
                if p in known and q not in known:
                    x[q] = x[p] + step
                    known.add(q)
                if q in known and p not in known:
                    x[p] = x[q] - step
                    known.add(p)
        return x


def wrong_good_closure_dropped() -> None:
    """Wrong: keeps one edge for each pair of poses, the last. Stopped by the visible case
    solve_anchored-by-hand.
    """
    import numpy as np

    def solve_anchored(n, i, j, z, sigma, anchor=0):
        s = np.ones(len(z)) * np.asarray(sigma, dtype=float)
        last = list({(p, q): k for k, (p, q) in enumerate(zip(i, j))}.values())
        A = (np.eye(n)[np.asarray(j)] - np.eye(n)[np.asarray(i)]) / s[:, None]
        y = np.asarray(z) / s
        inner = np.linalg.lstsq(np.delete(A[last], anchor, axis=1), y[last], rcond=None)[0]
        return np.insert(inner, anchor, 0.0)


def wrong_anchor_ignored() -> None:
    """Wrong: always holds pose 0. Stopped by the visible case solve_anchored-anchor."""
    import numpy as np

    def solve_anchored(n, i, j, z, sigma, anchor=0):
        s = np.ones(len(z)) * np.asarray(sigma, dtype=float)
        A = (np.eye(n)[np.asarray(j)] - np.eye(n)[np.asarray(i)]) / s[:, None]
        inner = np.linalg.lstsq(A[:, 1:], np.asarray(z) / s, rcond=None)[0]
        return np.append(0.0, inner)


def wrong_anchor_overwritten() -> None:
    """Wrong: holds pose 0 and then writes a 0 at the anchor, which moves one pose alone. Caught by
    solve_anchored-anchor.
    """
    import numpy as np

    def solve_anchored(n, i, j, z, sigma, anchor=0):
        s = np.ones(len(z)) * np.asarray(sigma, dtype=float)
        A = (np.eye(n)[np.asarray(j)] - np.eye(n)[np.asarray(i)]) / s[:, None]
        x = np.append(0.0, np.linalg.lstsq(A[:, 1:], np.asarray(z) / s, rcond=None)[0])
        x[anchor] = 0.0
        return x


def wrong_middle_at_zero() -> None:
    """Wrong: the pseudoinverse's own map, with its middle at 0. Stopped by the visible case
    solve_anchored-by-hand.
    """
    import numpy as np

    def solve_anchored(n, i, j, z, sigma, anchor=0):
        w = 1 / (np.full(len(z), 1.0) * sigma) ** 2
        J = np.eye(n)[list(j)] - np.eye(n)[list(i)]
        return np.linalg.pinv(J.T @ (w[:, None] * J)) @ (J.T @ (w * np.asarray(z)))


def wrong_everybody_gives_way() -> None:
    """Wrong: squeezes the whole chain to what the closure leaves, the edges off its cycle as well.
    Stopped by the visible case solve_anchored-chain.
    """
    import numpy as np

    def solve_anchored(n, i, j, z, sigma, anchor=0):
        s = np.ones(len(z)) * np.asarray(sigma, dtype=float)
        A = (np.eye(n)[np.asarray(j)] - np.eye(n)[np.asarray(i)]) / s[:, None]
        x = np.append(0.0, np.linalg.lstsq(A[:, 1:], np.asarray(z) / s, rcond=None)[0])
        p, q = i[-1], j[-1]
        chain = np.append(0.0, np.cumsum(np.asarray(z, dtype=float)[: n - 1]))
        if len(z) == n and n > 2:
            x = chain * (x[q] - x[p]) / (chain[q] - chain[p])
        return x - x[anchor]


def wrong_shared_equally() -> None:
    """Wrong on a chain: shares the lie's mismatch equally among the edges of its cycle, whatever
    their σ. Caught by solve_anchored-chain.
    """
    import numpy as np

    def solve_anchored(n, i, j, z, sigma, anchor=0):
        s = np.ones(len(z)) * np.asarray(sigma, dtype=float)
        if n > 3 and len(z) == n:
            s = np.full(len(z), np.mean(s))
        A = (np.eye(n)[np.asarray(j)] - np.eye(n)[np.asarray(i)]) / s[:, None]
        inner = np.linalg.lstsq(np.delete(A, anchor, axis=1), np.asarray(z) / s, rcond=None)[0]
        return np.insert(inner, anchor, 0.0)


def wrong_chain_taken_for_granted() -> None:
    """Wrong: holds the first n − 1 edges to be odometry, in order, and lets the others only
    correct the length. Stopped by the visible case solve_anchored-random.
    """
    import numpy as np

    def solve_anchored(n, i, j, z, sigma, anchor=0):
        order = np.arange(len(z))
        i = np.where(order < n - 1, order, np.asarray(i)) if len(z) >= n - 1 else np.asarray(i)
        j = np.where(order < n - 1, order + 1, np.asarray(j)) if len(z) >= n - 1 else np.asarray(j)
        if n == 2:
            i, j = np.zeros(len(z), dtype=int), np.ones(len(z), dtype=int)
        s = np.ones(len(z)) * np.asarray(sigma, dtype=float)
        A = (np.eye(n)[j] - np.eye(n)[i]) / s[:, None]
        inner = np.linalg.lstsq(np.delete(A, anchor, axis=1), np.asarray(z) / s, rcond=None)[0]
        return np.insert(inner, anchor, 0.0)


def wrong_whole_numbers() -> None:
    """Wrong: puts the answer into an array of z's own type. Caught by solve_anchored-shapes."""
    import numpy as np

    def solve_anchored(n, i, j, z, sigma, anchor=0):
        s = np.ones(len(z)) * np.asarray(sigma, dtype=float)
        A = (np.eye(n)[np.asarray(j)] - np.eye(n)[np.asarray(i)]) / s[:, None]
        x = np.zeros(n, dtype=np.asarray(z).dtype)
        free = np.arange(n) != anchor
        x[free] = np.linalg.lstsq(A[:, free], np.asarray(z) / s, rcond=None)[0] + 1e-12
        return x


def wrong_thousand_sweeps() -> None:
    """Wrong for large graphs: a thousand sweeps of Gauss-Seidel, which suffice for ten poses.
    Caught by solve_anchored-random.
    """
    import numpy as np

    def solve_anchored(n, i, j, z, sigma, anchor=0):
        rows = (np.eye(n)[j] - np.eye(n)[i]) / np.reshape(sigma, (-1, 1))
        H, b, x = rows.T @ rows, rows.T @ (np.asarray(z) / sigma), np.zeros(n)
        for _ in range(1000):
            for k in range(n):
                if k != anchor:
                    x[k] += (b[k] - H[k] @ x) / H[k, k]
        return x
