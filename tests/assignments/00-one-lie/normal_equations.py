"""Answers to exercise normal_equations of 00-one-lie: each body is a cell as handed in."""


def right_jacobian() -> None:
    """Right: builds J row by row and multiplies."""
    import numpy as np

    def normal_equations(n, i, j, z, sigma):
        m = len(z)
        J = np.zeros((m, n))
        for k in range(m):
            J[k, i[k]] = -1
            J[k, j[k]] = 1
        Omega = np.diag(1 / (np.ones(m) * np.asarray(sigma, dtype=float)) ** 2)
        return J.T @ Omega @ J, J.T @ Omega @ np.asarray(z, dtype=float)


def right_edge_by_edge() -> None:
    """Right: each edge adds its four entries of H and two of b; nested lists go out."""

    def normal_equations(n, i, j, z, sigma):
        H = [[0.0] * n for _ in range(n)]
        b = [0.0] * n
        for k, (p, q) in enumerate(zip(i, j)):
            s = sigma[k] if hasattr(sigma, "__len__") else sigma
            w = 1 / float(s) ** 2
            H[p][p] += w
            H[q][q] += w
            H[p][q] -= w
            H[q][p] -= w
            b[p] -= w * z[k]
            b[q] += w * z[k]
        return H, b


def right_laplacian() -> None:
    """Right, an equivalent form: H is the graph's Laplacian, b from weighted counts."""
    import numpy as np

    def normal_equations(n, i, j, z, sigma):
        z = np.asarray(z, dtype=float)
        w = np.full(z.shape, 1.0) / np.square(np.asarray(sigma, dtype=float))
        A = np.zeros((n, n))
        np.add.at(A, (np.asarray(i), np.asarray(j)), w)
        A += A.T
        H = np.diag(A.sum(axis=0)) - A
        b = np.bincount(j, weights=w * z, minlength=n) - np.bincount(i, weights=w * z, minlength=n)
        return H, b


def right_whitened_sparse() -> None:
    """Right, with a library: a sparse J, whitened first."""
    import numpy as np
    from scipy.sparse import coo_matrix

    def normal_equations(n, i, j, z, sigma):
        m = len(z)
        s = np.broadcast_to(np.asarray(sigma, dtype=float), (m,))
        rows = np.concatenate([np.arange(m), np.arange(m)])
        A = coo_matrix((np.concatenate([-1 / s, 1 / s]), (rows, np.concatenate([i, j]))), (m, n))
        return (A.T @ A).toarray(), A.T @ (np.asarray(z) / s)


def right_from_the_cost() -> None:
    """Right, from the cost alone: second differences of a quadratic are exact."""
    import numpy as np

    def normal_equations(n, i, j, z, sigma):
        z, sigma = np.asarray(z, dtype=float), np.asarray(sigma, dtype=float)
        i, j = np.asarray(i), np.asarray(j)

        def cost(x, z):
            return np.sum(((x[j] - x[i] - z) / sigma) ** 2)

        E, silent = np.eye(n), 0 * z
        H = np.array(
            [[(cost(p + q, silent) - cost(p - q, silent)) / 4 for q in E] for p in E], dtype=float
        )
        b = np.array([(cost(-p, z) - cost(p, z)) / 4 for p in E])
        return H, b


def wrong_unweighted() -> None:
    """Wrong: JᵀJ without the information. Stopped by the visible case normal_equations-by-hand."""
    import numpy as np

    def normal_equations(n, i, j, z, sigma):
        J = np.eye(n)[np.asarray(j)] - np.eye(n)[np.asarray(i)]
        return J.T @ J, J.T @ np.asarray(z, dtype=float)


def wrong_sign_of_b() -> None:
    """Wrong: b with the other sign, of a residual measured minus predicted. Stopped by the visible
    case normal_equations-by-hand.
    """
    import numpy as np

    def normal_equations(n, i, j, z, sigma):
        J = np.eye(n)[np.asarray(j)] - np.eye(n)[np.asarray(i)]
        weighted = J.T / np.square(np.asarray(sigma, dtype=float))
        return weighted @ J, -weighted @ np.asarray(z, dtype=float)


def wrong_factor_two() -> None:
    """Wrong: keeps the 2 of the cost's derivative. Stopped by the visible case
    normal_equations-by-hand.
    """
    import numpy as np

    def normal_equations(n, i, j, z, sigma):
        J = np.eye(n)[np.asarray(j)] - np.eye(n)[np.asarray(i)]
        weighted = 2 * J.T / np.square(np.asarray(sigma, dtype=float))
        return weighted @ J, weighted @ np.asarray(z, dtype=float)


def wrong_anchored() -> None:
    """Wrong: a prior holds pose 0 already, so that H has an inverse. Stopped by the visible case
    normal_equations-gauge.
    """
    import numpy as np

    def normal_equations(n, i, j, z, sigma):
        J = np.eye(n)[np.asarray(j)] - np.eye(n)[np.asarray(i)]
        weighted = J.T / np.square(np.asarray(sigma, dtype=float))
        H = weighted @ J
        if n > 2:
            H[0, 0] += 1.0
        return H, weighted @ np.asarray(z, dtype=float)


def wrong_repeats_lost() -> None:
    """Wrong where two edges join the same poses: the last one overwrites the entry. Caught by
    normal_equations-lesson.
    """
    import numpy as np

    def normal_equations(n, i, j, z, sigma):
        H, b = np.zeros((n, n)), np.zeros(n)
        for k in range(len(z)):
            w = 1 / np.ravel(np.ones(len(z)) * np.asarray(sigma, dtype=float))[k] ** 2
            H[i[k], j[k]] = H[j[k], i[k]] = -w
            b[j[k]] += w * z[k]
            b[i[k]] -= w * z[k]
        return H - np.diag(H.sum(axis=0)), b


def wrong_buffered_index() -> None:
    """Wrong where a pose has several edges: H[i, i] += w counts a repeated index once. Stopped by
    the visible case normal_equations-gauge.
    """
    import numpy as np

    def normal_equations(n, i, j, z, sigma):
        i, j = np.asarray(i), np.asarray(j)
        w = np.ones(len(z)) / np.square(np.asarray(sigma, dtype=float))
        H, b = np.zeros((n, n)), np.zeros(n)
        ends = np.concatenate([i, j])
        H[ends, ends] += np.concatenate([w, w])
        H[i, j] -= w
        H[j, i] -= w
        b[j] += w * z
        b[i] -= w * z
        return H, b


def wrong_mean_information() -> None:
    """Wrong: one information for all edges once there are more than four. Caught by
    normal_equations-information.
    """
    import numpy as np

    def normal_equations(n, i, j, z, sigma):
        J = np.eye(n)[np.asarray(j)] - np.eye(n)[np.asarray(i)]
        w = np.ones(len(z)) / np.square(np.asarray(sigma, dtype=float))
        w = w if len(z) <= 4 else np.full(len(z), np.mean(w))
        return (J.T * w) @ J, (J.T * w) @ np.asarray(z, dtype=float)


def wrong_pushes_the_later_pose() -> None:
    """Wrong b for backward edges with a measurement of its own sign: takes the later pose for the
    end. Stopped by the visible case normal_equations-right-hand-side.
    """
    import numpy as np

    def normal_equations(n, i, j, z, sigma):
        w = np.ones(len(z)) / np.square(np.asarray(sigma, dtype=float))
        J = np.eye(n)[np.maximum(i, j)] - np.eye(n)[np.minimum(i, j)]
        return (J.T * w) @ J, (J.T * w) @ np.asarray(z, dtype=float)


def wrong_sizes_in_b() -> None:
    """Wrong b: every edge pushes the later pose forward by the size of what it says. Caught by
    normal_equations-right-hand-side.
    """
    import numpy as np

    def normal_equations(n, i, j, z, sigma):
        w = np.ones(len(z)) / np.square(np.asarray(sigma, dtype=float))
        J = np.eye(n)[np.maximum(i, j)] - np.eye(n)[np.minimum(i, j)]
        return (J.T * w) @ J, (J.T * w) @ np.abs(np.asarray(z, dtype=float))


def wrong_held_when_large() -> None:
    """Wrong: holds the first pose of graphs that a solver would find singular in two directions.
    Caught by normal_equations-gauge.
    """
    import numpy as np

    def normal_equations(n, i, j, z, sigma):
        J = np.eye(n)[np.asarray(j)] - np.eye(n)[np.asarray(i)]
        weighted = J.T / np.square(np.asarray(sigma, dtype=float))
        H = weighted @ J
        if np.linalg.matrix_rank(H) < n - 1:
            H = H + 1e-6 * np.eye(n)
        return H, weighted @ np.asarray(z, dtype=float)


def wrong_whole_numbers() -> None:
    """Wrong: an integer σ gives an integer information, which is 0. Caught by
    normal_equations-shapes.
    """
    import numpy as np

    def normal_equations(n, i, j, z, sigma):
        J = np.eye(n)[np.asarray(j)] - np.eye(n)[np.asarray(i)]
        s = np.asarray(sigma)
        weighted = J.T * (1 / s**2 if s.dtype == float else 1 // s**2)
        return weighted @ J, weighted @ np.asarray(z, dtype=float)


def wrong_room_for_fifty() -> None:
    """Wrong for large graphs: a Jacobian with fifty columns, however many poses there are. Caught
    by normal_equations-information.
    """
    import numpy as np

    def normal_equations(n, i, j, z, sigma):
        J = np.zeros((len(z), 50))
        J[np.arange(len(z)), i] -= 1
        J[np.arange(len(z)), j] += 1
        weighted = J[:, :n].T / np.square(sigma, dtype=float)
        return weighted @ J[:, :n], weighted @ z
