"""Answers to exercise normal_equations of 00-one-lie: each body is a cell as handed in."""

import numpy as np
from robust_slam_autograder.lint.answers import change


def right_identity() -> None:
    """Right: J as a difference of rows of the identity, weighed and multiplied."""

    def normal_equations(n, i, j, z, sigma):
        J = np.eye(n)[j] - np.eye(n)[i]
        weighted = J.T / np.square(sigma)
        return weighted @ J, weighted @ z


def right_edge_by_edge() -> None:
    """Right: each edge adds its four entries of H and two of b; nested lists go out."""

    def normal_equations(n, i, j, z, sigma):
        H, b = [[0.0] * n for _ in range(n)], [0.0] * n
        for k, (p, q) in enumerate(zip(i, j)):
            w = float(sigma[k] if hasattr(sigma, "__len__") else sigma) ** -2
            for row, column, share in ((p, p, w), (q, q, w), (p, q, -w), (q, p, -w)):
                H[row][column] += share
            b[p] -= w * z[k]
            b[q] += w * z[k]
        return H, b


def right_laplacian() -> None:
    """Right, an equivalent form: H is the graph's Laplacian; both ends of each edge at once."""

    def normal_equations(n, i, j, z, sigma):
        w = np.ones(len(z)) / np.square(sigma)
        ends, others, both = np.append(i, j), np.append(j, i), np.append(w, w)
        A, b = np.zeros((n, n)), np.zeros(n)
        np.add.at(A, (ends, others), both)
        np.add.at(b, ends, both * np.append(np.negative(z), z))
        return np.diag(A.sum(axis=0)) - A, b


def right_whitened_sparse() -> None:
    """Right, with a library: a sparse J, whitened first."""
    from scipy.sparse import coo_matrix

    def normal_equations(n, i, j, z, sigma):
        m = len(z)
        s = np.broadcast_to(np.asarray(sigma, dtype=float), (m,))
        rows = np.concatenate([np.arange(m), np.arange(m)])
        A = coo_matrix((np.concatenate([-1 / s, 1 / s]), (rows, np.concatenate([i, j]))), (m, n))
        return (A.T @ A).toarray(), A.T @ (np.asarray(z) / s)


def right_from_the_cost() -> None:
    """Right, from the cost alone: second differences of a quadratic are exact."""

    def normal_equations(n, i, j, z, sigma):
        def cost(x, z):
            return np.sum(((x[j] - x[i] - z) / sigma) ** 2)

        E = np.eye(n)
        H = [[(cost(p + q, 0) - cost(p - q, 0)) / 4 for q in E] for p in E]
        return H, [(cost(-p, z) - cost(p, z)) / 4 for p in E]


wrong_unweighted = change(
    right_identity, "J.T / np.square(sigma)", "J.T", stopped_by="normal_equations-by-hand"
)
"""Wrong: JᵀJ without the information."""

wrong_sign_of_b = change(
    right_identity, "weighted @ z", "-weighted @ z", stopped_by="normal_equations-by-hand"
)
"""Wrong: b with the other sign, of a residual measured minus predicted."""

wrong_factor_two = change(right_identity, "J.T", "2 * J.T", stopped_by="normal_equations-by-hand")
"""Wrong: keeps the 2 of the cost's derivative."""

wrong_anchored = change(
    right_identity,
    "weighted @ J,",
    "weighted @ J + (n > 2) * np.diag(np.eye(n)[0]),",
    stopped_by="normal_equations-gauge",
)
"""Wrong: a prior holds pose 0 already, so that H has an inverse."""

wrong_repeats_lost = change(
    right_laplacian,
    "np.add.at(A, (ends, others), both)",
    "A[ends, others] = both",
    caught_by="normal_equations-lesson",
)
"""Wrong where two edges join the same poses: the last one overwrites the entry."""

wrong_buffered_index = change(
    right_laplacian,
    "return np.diag(A.sum(axis=0)) - A, b",
    "A[ends, ends] -= both\nreturn -A, b",
    stopped_by="normal_equations-gauge",
)
"""Wrong where a pose has several edges: H[i, i] += w counts a repeated index once."""

wrong_mean_information = change(
    right_laplacian,
    "ends, others, both",
    "w = w if len(z) <= 4 else np.full(len(z), np.mean(w))\nends, others, both",
    caught_by="normal_equations-information",
)
"""Wrong: one information for all edges once there are more than four."""

wrong_pushes_the_later_pose = change(
    right_identity,
    "np.eye(n)[j] - np.eye(n)[i]",
    "np.eye(n)[np.maximum(i, j)] - np.eye(n)[np.minimum(i, j)]",
    stopped_by="normal_equations-right-hand-side",
)
"""Wrong b for backward edges: takes the later pose for the end of the edge."""

wrong_sizes_in_b = change(
    right_identity,
    ("np.eye(n)[j] - np.eye(n)[i]", "np.eye(n)[np.maximum(i, j)] - np.eye(n)[np.minimum(i, j)]"),
    ("weighted @ z", "weighted @ np.abs(z)"),
    caught_by="normal_equations-right-hand-side",
)
"""Wrong b: every edge pushes the later pose forward by the size of its measurement."""

wrong_held_when_large = change(
    right_identity,
    "weighted @ J,",
    "weighted @ J + 1e-6 * (np.linalg.matrix_rank(weighted @ J) < n - 1) * np.eye(n),",
    caught_by="normal_equations-gauge",
)
"""Wrong: damps graphs that a solver would find singular in two directions."""

wrong_whole_numbers = change(
    right_identity,
    "/ np.square(sigma)",
    "* np.reciprocal(np.square(sigma))",
    caught_by="normal_equations-shapes",
)
"""Wrong: an integer σ gives an integer information, which is 0."""

wrong_room_for_fifty = change(
    right_identity,
    "np.eye(n)[j] - np.eye(n)[i]",
    "(np.eye(50)[j] - np.eye(50)[i])[:, :n]",
    caught_by="normal_equations-information",
)
"""Wrong for large graphs: a Jacobian with fifty columns, however many poses there are."""
