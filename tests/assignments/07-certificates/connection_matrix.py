"""Answers to exercise connection_matrix of 07-certificates: each body is a cell as handed in."""

from robust_slam_autograder.lint.answers import change


def right_blocks() -> None:
    """Right: four blocks for each measurement, added one by one."""
    import numpy as np

    def connection_matrix(n, i, j, R_meas, kappa):
        R_meas = np.asarray(R_meas, dtype=float)
        d = R_meas.shape[1]
        Q = np.zeros((n, d, n, d))
        for a, b, r, k in zip(i, j, R_meas, np.broadcast_to(kappa, len(R_meas))):
            Q[a, :, a] += k * np.eye(d)
            Q[b, :, b] += k * np.eye(d)
            Q[a, :, b] -= k * r
            Q[b, :, a] -= k * r.T
        return Q.reshape(n * d, n * d)


def right_stacked_misfits() -> None:
    """Right, an equivalent form: the misfits of all measurements as one matrix A."""
    import numpy as np

    def connection_matrix(n, i, j, R_meas, kappa):
        d = np.shape(R_meas)[-1]
        units = np.eye(n * d).reshape(n * d, n, d)
        columns = [units[:, b] - units[:, a] @ np.array(r) for a, b, r in zip(i, j, R_meas)]
        A = np.hstack(columns)
        return A * np.repeat(np.broadcast_to(kappa, len(columns)), d) @ A.T


def right_add_at() -> None:
    """Right: vectorised, np.add.at on blocks."""
    import numpy as np

    def connection_matrix(n, i, j, R_meas, kappa):
        R_meas = np.array(R_meas, dtype=float)
        d = R_meas.shape[2]
        scaled = np.reshape(kappa, (-1, 1, 1)) * R_meas
        degree = np.zeros(n)
        np.add.at(degree, np.asarray(i), np.broadcast_to(kappa, len(R_meas)))
        np.add.at(degree, np.asarray(j), np.broadcast_to(kappa, len(R_meas)))
        half = np.zeros((n, n, d, d))
        np.add.at(half, (np.asarray(i), np.asarray(j)), scaled)
        half = half.transpose(0, 2, 1, 3).reshape(n * d, n * d)
        return np.kron(np.diag(degree), np.eye(d)) - half - half.T


def right_scipy_sparse() -> None:
    """Right, by a library routine: scipy's sparse matrix adds up the entries; nested lists out."""
    import numpy as np
    from scipy.sparse import coo_matrix

    def connection_matrix(n, i, j, R_meas, kappa):
        R_meas = np.asarray(R_meas, dtype=float)
        m, d, _ = R_meas.shape
        rows, columns, values = [], [], []
        for k in range(m):
            weight = float(np.broadcast_to(kappa, m)[k])
            block = np.block([[np.eye(d), -R_meas[k]], [-R_meas[k].T, np.eye(d)]])
            at = [d * i[k] + r for r in range(d)] + [d * j[k] + r for r in range(d)]
            for p in range(2 * d):
                for q in range(2 * d):
                    rows.append(at[p])
                    columns.append(at[q])
                    values.append(weight * block[p, q])
        return coo_matrix((values, (rows, columns)), shape=(d * n, d * n)).toarray().tolist()


wrong_sign = change(
    right_blocks,
    "np.asarray(R_meas, dtype=float)",
    "np.negative(R_meas)",
    stopped_by="connection_matrix-plane",
)
"""Wrong sign: adds the measured rotation beside the diagonal, so that agreement costs most."""

wrong_transposed = change(
    right_blocks,
    "np.asarray(R_meas, dtype=float)",
    "np.swapaxes(R_meas, 1, 2)",
    caught_by="connection_matrix-plane",
)
"""Wrong frames: the transpose of the measured rotation, as if R_i were R_j times it."""

wrong_one_sided_transpose = change(
    right_blocks, "r.T", "r", stopped_by="connection_matrix-by-hand"
)
"""Wrong: the measured rotation on both sides of the diagonal: Q is not symmetric."""

wrong_without_kappa = change(
    right_blocks,
    "np.broadcast_to(kappa, len(R_meas))",
    "np.ones(len(R_meas))",
    stopped_by="connection_matrix-by-hand",
)
"""Wrong: every measurement counts the same and κ is ignored."""

wrong_mean_kappa = change(
    right_blocks,
    "np.broadcast_to(kappa, len(R_meas))",
    "np.full(len(R_meas), np.mean(kappa))",
    caught_by="connection_matrix-kappa",
)
"""Wrong: the mean of all κ for every measurement, right where they are equal."""

wrong_square_kappa = change(
    right_blocks, "kappa,", "np.square(kappa),", stopped_by="connection_matrix-by-hand"
)
"""Wrong: takes κ for a deviation whose inverse it is, and counts a measurement with κ²."""

wrong_last_measurement_wins = change(
    right_blocks,
    ("Q[a, :, b] -= k * r", "Q[a, :, b] = -k * r"),
    ("Q[b, :, a] -= k * r.T", "Q[b, :, a] = -k * r.T"),
    caught_by="connection_matrix-parallel",
)
"""Wrong: sets the blocks beside the diagonal, so the last of several measurements wins."""

wrong_upward_only = change(
    right_blocks,
    "zip(i, j, R_meas",
    "zip(np.minimum(i, j), np.maximum(i, j), R_meas",
    caught_by="connection_matrix-parallel",
)
"""Wrong: keeps the rotation, as if each measurement went from the lower pose to the higher one."""

wrong_measured_poses_only = change(
    right_blocks,
    "d = R_meas.shape[1]",
    "d, n = R_meas.shape[1], max(*i, *j) + 1",
    stopped_by="connection_matrix-lists",
)
"""Wrong: counts the poses in the measurements and forgets those that have none."""

wrong_diagonal_set_once = change(
    right_blocks,
    ("Q[a, :, a] +=", "Q[a, :, a] ="),
    ("Q[b, :, b] +=", "Q[b, :, b] ="),
    stopped_by="connection_matrix-parallel",
)
"""Wrong: sets the diagonal blocks, which is right where a pose has one measurement."""
