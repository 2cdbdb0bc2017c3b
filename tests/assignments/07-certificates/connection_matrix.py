"""Answers to exercise connection_matrix of 07-certificates: each body is a cell as handed in."""


def right_four_blocks() -> None:
    """Right: four blocks for each measurement, added one by one."""
    import numpy as np

    def connection_matrix(n, i, j, R_meas, kappa):
        R_meas = np.asarray(R_meas, dtype=float)
        m, d = R_meas.shape[:2]
        kappa = np.ones(m) * np.asarray(kappa, dtype=float)
        Q = np.zeros((n, d, n, d))
        for k in range(m):
            a, b = i[k], j[k]
            Q[a, :, a] += kappa[k] * np.eye(d)
            Q[b, :, b] += kappa[k] * np.eye(d)
            Q[a, :, b] -= kappa[k] * R_meas[k]
            Q[b, :, a] -= kappa[k] * R_meas[k].T
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


def wrong_sign() -> None:
    """Wrong sign: adds the measured rotation beside the diagonal, so that agreement costs most.
    Stopped by the visible case connection_matrix-plane.
    """
    import numpy as np

    def connection_matrix(n, i, j, R_meas, kappa):
        R_meas = np.asarray(R_meas, dtype=float)
        d = R_meas.shape[1]
        Q = np.zeros((n, d, n, d))
        for a, b, r, k in zip(i, j, R_meas, np.broadcast_to(kappa, len(R_meas))):
            Q[a, :, a] += k * np.eye(d)
            Q[b, :, b] += k * np.eye(d)
            Q[a, :, b] += k * r
            Q[b, :, a] += k * r.T
        return Q.reshape(n * d, n * d)


def wrong_transposed() -> None:
    """Wrong frames: puts the measured rotation where its transpose belongs, as if R_i were R_j
    times it. Caught by connection_matrix-plane.
    """
    import numpy as np

    def connection_matrix(n, i, j, R_meas, kappa):
        R_meas = np.asarray(R_meas, dtype=float)
        d = R_meas.shape[1]
        Q = np.zeros((n, d, n, d))
        for a, b, r, k in zip(i, j, R_meas, np.broadcast_to(kappa, len(R_meas))):
            Q[a, :, a] += k * np.eye(d)
            Q[b, :, b] += k * np.eye(d)
            Q[a, :, b] -= k * r.T
            Q[b, :, a] -= k * r
        return Q.reshape(n * d, n * d)


def wrong_one_sided_transpose() -> None:
    """Wrong: the measured rotation on both sides of the diagonal, without the transpose; Q is not
    symmetric. Stopped by the visible case connection_matrix-by-hand.
    """
    import numpy as np

    def connection_matrix(n, i, j, R_meas, kappa):
        R_meas = np.asarray(R_meas, dtype=float)
        d = R_meas.shape[1]
        Q = np.zeros((n, d, n, d))
        for a, b, r, k in zip(i, j, R_meas, np.broadcast_to(kappa, len(R_meas))):
            Q[a, :, a] += k * np.eye(d)
            Q[b, :, b] += k * np.eye(d)
            Q[a, :, b] -= k * r
            Q[b, :, a] -= k * r
        return Q.reshape(n * d, n * d)


def wrong_without_kappa() -> None:
    """Wrong: every measurement counts the same and κ is ignored. Stopped by the visible case
    connection_matrix-by-hand.
    """
    import numpy as np

    def connection_matrix(n, i, j, R_meas, kappa):
        d = np.shape(R_meas)[1]
        Q = np.zeros((n * d, n * d))
        for a, b, r in zip(i, j, R_meas):
            E = np.zeros((n * d, d))
            E[d * b : d * b + d] = np.eye(d)
            E[d * a : d * a + d] = -np.asarray(r, dtype=float)
            Q += E @ E.T
        return Q


def wrong_mean_kappa() -> None:
    """Wrong: the mean of all κ for every measurement, right where they are equal. Caught by
    connection_matrix-kappa.
    """
    import numpy as np

    def connection_matrix(n, i, j, R_meas, kappa):
        d = np.shape(R_meas)[1]
        Q = np.zeros((n * d, n * d))
        for a, b, r in zip(i, j, R_meas):
            E = np.zeros((n * d, d))
            E[d * b : d * b + d] = np.eye(d)
            E[d * a : d * a + d] = -np.asarray(r, dtype=float)
            Q += np.mean(kappa) * E @ E.T
        return Q


def wrong_square_kappa() -> None:
    """Wrong: takes κ for a deviation whose inverse it is, and counts a measurement with κ².
    Stopped by the visible case connection_matrix-by-hand.
    """
    import numpy as np

    def connection_matrix(n, i, j, R_meas, kappa):
        d = np.shape(R_meas)[1]
        Q = np.zeros((n * d, n * d))
        for a, b, r, k in zip(i, j, R_meas, np.broadcast_to(kappa, len(R_meas))):
            E = np.zeros((n * d, d))
            E[d * b : d * b + d] = np.eye(d)
            E[d * a : d * a + d] = -np.asarray(r, dtype=float)
            Q += k**2 * E @ E.T
        return Q


def wrong_last_measurement_wins() -> None:
    """Wrong: sets the block of a pair of poses instead of adding to it, so the last of several
    measurements wins; the diagonal is right. Caught by connection_matrix-parallel.
    """
    import numpy as np

    def connection_matrix(n, i, j, R_meas, kappa):
        R_meas = np.asarray(R_meas, dtype=float)
        d = R_meas.shape[1]
        Q = np.zeros((n, d, n, d))
        for a, b, r, k in zip(i, j, R_meas, np.broadcast_to(kappa, len(R_meas))):
            Q[a, :, a] += k * np.eye(d)
            Q[b, :, b] += k * np.eye(d)
            Q[a, :, b] = -k * r
            Q[b, :, a] = -k * r.T
        return Q.reshape(n * d, n * d)


def wrong_upward_only() -> None:
    """Wrong: sorts the ends of each measurement and keeps its rotation, as if all went from the
    lower pose to the higher one. Caught by connection_matrix-parallel.
    """
    import numpy as np

    def connection_matrix(n, i, j, R_meas, kappa):
        d = np.shape(R_meas)[1]
        Q = np.zeros((n * d, n * d))
        for a, b, r, k in zip(i, j, R_meas, np.broadcast_to(kappa, len(R_meas))):
            a, b = min(a, b), max(a, b)
            E = np.zeros((n * d, d))
            E[d * b : d * b + d] = np.eye(d)
            E[d * a : d * a + d] = -np.asarray(r, dtype=float)
            Q += k * E @ E.T
        return Q


def wrong_measured_poses_only() -> None:
    """Wrong: counts the poses in the measurements and forgets those that have none. Stopped by
    the visible case connection_matrix-lists.
    """
    import numpy as np

    def connection_matrix(n, i, j, R_meas, kappa):
        d = np.shape(R_meas)[1]
        n = max(*i, *j) + 1
        Q = np.zeros((n * d, n * d))
        for a, b, r, k in zip(i, j, R_meas, np.broadcast_to(kappa, len(R_meas))):
            E = np.zeros((n * d, d))
            E[d * b : d * b + d] = np.eye(d)
            E[d * a : d * a + d] = -np.asarray(r, dtype=float)
            Q += k * E @ E.T
        return Q


def wrong_diagonal_set_once() -> None:
    """Wrong: sets the diagonal blocks instead of adding to them, which is right where a pose has
    one measurement. Stopped by the visible case connection_matrix-parallel.
    """
    import numpy as np

    def connection_matrix(n, i, j, R_meas, kappa):
        R_meas = np.asarray(R_meas, dtype=float)
        d = R_meas.shape[1]
        Q = np.zeros((n, d, n, d))
        for a, b, r, k in zip(i, j, R_meas, np.broadcast_to(kappa, len(R_meas))):
            Q[a, :, a] = Q[b, :, b] = k * np.eye(d)
            Q[a, :, b] -= k * r
            Q[b, :, a] -= k * r.T
        return Q.reshape(n * d, n * d)
