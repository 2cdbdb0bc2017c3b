"""Answers to exercise solve_anchored of 00-one-lie: each body is a cell as handed in."""

import numpy as np
from robust_slam_autograder.lint.answers import change


def right_strike() -> None:
    """Right: strikes the anchor's column of the whitened J and solves by least squares."""

    def solve_anchored(n, i, j, z, sigma, anchor=0):
        s = np.full(len(z), sigma, dtype=float)
        A = (np.eye(n)[j] - np.eye(n)[i]) / s[:, None]
        x = np.linalg.lstsq(np.delete(A, anchor, axis=1), z / s, rcond=None)[0]
        return np.insert(x, anchor, 0.0)


def right_prior() -> None:
    """Right: a prior holds the anchor; any strength gives the same map."""

    def solve_anchored(n, i, j, z, sigma, anchor=0):
        J = np.eye(n)[j] - np.eye(n)[i]
        weighted = J.T / np.square(sigma)
        H, b = weighted @ J, weighted @ z
        H[anchor, anchor] += 100.0
        return list(np.linalg.solve(H, b))


def right_pseudoinverse_and_shift() -> None:
    """Right: any best map will do, shifted until the anchor is at 0."""

    def solve_anchored(n, i, j, z, sigma, anchor=0):
        J = np.eye(n)[j] - np.eye(n)[i]
        weighted = J.T / np.square(sigma)
        x = np.linalg.pinv(weighted @ J, rcond=1e-10) @ weighted @ z
        return x - x[anchor]


def right_lagrange() -> None:
    """Right, an equivalent form: a Lagrange multiplier says x[anchor] = 0."""

    def solve_anchored(n, i, j, z, sigma, anchor=0):
        J = np.eye(n)[np.asarray(j)] - np.eye(n)[np.asarray(i)]
        weighted = J.T / np.square(np.asarray(sigma, dtype=float))
        held = np.eye(n)[anchor]
        K = np.block([[weighted @ J, held[:, None]], [held[None], np.zeros((1, 1))]])
        return np.linalg.solve(K, np.append(weighted @ np.asarray(z, dtype=float), 0.0))[:n]


def right_library() -> None:
    """Right, with a library: SciPy's lsq_linear on the whitened residuals."""
    from scipy.optimize import lsq_linear

    def solve_anchored(n, i, j, z, sigma, anchor=0):
        s = np.ones(len(z)) * np.asarray(sigma, dtype=float)
        A = (np.eye(n)[np.asarray(j)] - np.eye(n)[np.asarray(i)]) / s[:, None]
        free = [k for k in range(n) if k != anchor]
        x = np.zeros(n)
        x[free] = lsq_linear(A[:, free], np.asarray(z, dtype=float) / s).x
        return x


wrong_unweighted = change(
    right_strike, "sigma, dtype", "1, dtype", stopped_by="solve_anchored-by-hand"
)
"""Wrong: every edge has the same weight."""

wrong_printed_map = change(
    right_strike,
    "return",
    "if n == 3 and len(z) == 4:\n    return z[0] * np.array([0.0, 0.2, 0.4])\nreturn",
    caught_by="solve_anchored-lesson",
)
"""Wrong: three poses shrunk to the lesson's printed 0.4 of their length of 2."""

wrong_information_of_sigma = change(
    right_strike, "sigma, dtype", "np.sqrt(sigma), dtype", stopped_by="solve_anchored-by-hand"
)
"""Wrong: weighs by 1/σ, as if σ were a variance."""


def wrong_odometry_first() -> None:
    """Wrong: believes the first edge that reaches a pose, and no other. Stopped by the visible
    case solve_anchored-by-hand.
    """

    def solve_anchored(n, i, j, z, sigma, anchor=0):
        x = {anchor: 0.0}
        for p, q, step in n * list(zip(i, j, z)):
            if p in x:
                x.setdefault(q, x[p] + step)
            elif q in x:
                x[p] = x[q] - step
        return [x.get(k, 0.0) for k in range(n)]


wrong_good_closure_dropped = change(
    right_strike,
    "x = ",
    """
    last = list({ends: k for k, ends in enumerate(zip(i, j))}.values())
    A, z, s = A[last], np.take(z, last), s[last]
    x = """,
    stopped_by="solve_anchored-by-hand",
)
"""Wrong: keeps one edge for each pair of poses, the last."""

wrong_anchor_ignored = change(
    right_strike, "s = np", "anchor = 0\ns = np", stopped_by="solve_anchored-anchor"
)
"""Wrong: always holds pose 0."""

wrong_anchor_overwritten = change(
    right_pseudoinverse_and_shift,
    "return x - x[anchor]",
    "x = x - x[0]\nx[anchor] = 0.0\nreturn x",
    caught_by="solve_anchored-anchor",
)
"""Wrong: holds pose 0 and then writes a 0 at the anchor, which moves one pose alone."""

wrong_middle_at_zero = change(
    right_pseudoinverse_and_shift, "x - x[anchor]", "x", stopped_by="solve_anchored-by-hand"
)
"""Wrong: the pseudoinverse's own map, with its middle at 0."""

wrong_everybody_gives_way = change(
    right_pseudoinverse_and_shift,
    "return",
    """
    chain = np.append(0.0, np.cumsum(z[: n - 1]))
    if len(z) == n > 2:
        x = chain * (x[j[-1]] - x[i[-1]]) / (chain[j[-1]] - chain[i[-1]])
    return""",
    stopped_by="solve_anchored-chain",
)
"""Wrong: scales the whole chain to what the closure leaves, the edges off its cycle as well."""

wrong_shared_equally = change(
    right_strike,
    "A = (",
    "s = np.full(n, np.mean(s)) if len(z) == n > 3 else s\nA = (",
    caught_by="solve_anchored-chain",
)
"""Wrong on a chain: shares the closure's error equally among its cycle's edges, as equal σ."""

wrong_chain_taken_for_granted = change(
    right_strike,
    "s = np",
    """
    i, j = np.array(i), np.array(j)
    if n == 2:
        i, j = 0 * i, 0 * j + 1
    elif len(z) >= n - 1:
        i[: n - 1], j[: n - 1] = np.arange(n - 1), np.arange(1, n)
    s = np""",
    stopped_by="solve_anchored-random",
)
"""Wrong: takes the first n − 1 edges for odometry, in order, whatever poses they join."""

wrong_whole_numbers = change(
    right_strike,
    "np.insert(x, anchor, 0.0)",
    "np.insert(x + 1e-12, anchor, 0.0).astype(np.asarray(z).dtype)",
    caught_by="solve_anchored-shapes",
)
"""Wrong: puts the answer into an array of z's own type."""

wrong_thousand_sweeps = change(
    right_prior,
    "return list(np.linalg.solve(H, b))",
    """
    x = np.zeros(n)
    for k in 1000 * [k for k in range(n) if k != anchor]:
        x[k] += (b[k] - H[k] @ x) / H[k, k]
    return x
    """,
    caught_by="solve_anchored-random",
)
"""Wrong for large graphs: a thousand sweeps of Gauss-Seidel, which suffice for ten poses."""
