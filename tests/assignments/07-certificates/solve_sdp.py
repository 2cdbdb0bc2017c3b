"""Answers to exercise solve_sdp of 07-certificates: each body is a cell as handed in."""


def right_clarabel() -> None:
    """Right: a variable that is positive semidefinite, and Clarabel."""
    import cvxpy as cp
    import numpy as np

    def solve_sdp(Q, n, d):
        Z = cp.Variable((n * d, n * d), PSD=True)
        blocks = [Z[k * d : (k + 1) * d, k * d : (k + 1) * d] == np.eye(d) for k in range(n)]
        problem = cp.Problem(cp.Minimize(cp.sum(cp.multiply(np.array(Q), Z))), blocks)
        problem.solve(solver=cp.CLARABEL)
        return Z.value


def right_default_solver() -> None:
    """Right: a symmetric variable, Z >> 0, and the solver that cvxpy takes by itself."""
    import cvxpy as cp
    import numpy as np

    def solve_sdp(Q, n, d):
        Z = cp.Variable((n * d, n * d), symmetric=True)
        constraints = [Z >> 0]
        for k in range(n):
            at = slice(k * d, (k + 1) * d)
            constraints.append(Z[at, at] == np.identity(d))
        cp.Problem(cp.Minimize(cp.trace(np.asarray(Q) @ Z)), constraints).solve()
        return Z.value.tolist()


def right_dual() -> None:
    """Right, an equivalent form: maximise tr Λ with Q − Λ ⪰ 0; Z is the multiplier of that."""
    import cvxpy as cp
    import numpy as np

    def solve_sdp(Q, n, d):
        Q = np.asarray(Q, dtype=float)
        parts = [cp.Variable((d, d), symmetric=True) for _ in range(n)]
        units = np.split(np.eye(n * d), n, axis=1)
        Lambda = sum(unit @ part @ unit.T for unit, part in zip(units, parts))
        psd = Q - Lambda >> 0
        value = cp.Maximize(sum(cp.trace(part) for part in parts))
        cp.Problem(value, [psd]).solve(solver=cp.CLARABEL)
        Z = psd.dual_value
        return (Z + Z.T) / 2


def right_low_rank() -> None:
    """Right, without cvxpy: Z = Y.T Y with Y of full height, one block of Y at a time moved to the
    best place, from many rounds; no rank is fixed below dn, so nothing is lost.
    """
    import numpy as np

    def solve_sdp(Q, n, d):
        Q = np.asarray(Q, dtype=float)
        rows = np.random.default_rng(0).normal(size=(n * d, n, d))
        Y = np.stack([np.linalg.qr(rows[:, k])[0] for k in range(n)])
        previous = None
        for _ in range(20_000):
            for k in range(n):
                others = [a for a in range(n) if a != k]
                pull = sum(Y[a] @ Q[a * d : a * d + d, k * d : k * d + d] for a in others)
                if len(others):
                    left, _, right = np.linalg.svd(-pull, full_matrices=False)
                    Y[k] = left @ right
            wide = np.hstack(list(Y))
            value = np.sum((wide @ Q) * wide)
            if previous is not None and abs(previous - value) <= 1e-9 * np.linalg.norm(Q, 2):
                break
            previous = value
        return wide.T @ wide


def wrong_unit_diagonal() -> None:
    """Wrong: asks for diag(Z) = 1 and leaves the rest of each diagonal block free, which is enough
    for the rings of the plane alone. Caught by solve_sdp-space.
    """
    import cvxpy as cp
    import numpy as np

    def solve_sdp(Q, n, d):
        Z = cp.Variable((n * d, n * d), PSD=True)
        problem = cp.Problem(cp.Minimize(cp.trace(np.asarray(Q) @ Z)), [cp.diag(Z) == 1])
        problem.solve(solver=cp.CLARABEL)
        return Z.value


def wrong_traces_of_blocks() -> None:
    """Wrong: fixes the trace of each diagonal block and not the block. Caught by
    solve_sdp-any-matrix.
    """
    import cvxpy as cp
    import numpy as np

    def solve_sdp(Q, n, d):
        Z = cp.Variable((n * d, n * d), PSD=True)
        traces = [cp.trace(Z[k : k + d, k : k + d]) == d for k in range(0, n * d, d)]
        cp.Problem(cp.Minimize(cp.trace(np.asarray(Q) @ Z)), traces).solve(solver=cp.CLARABEL)
        return Z.value


def wrong_rotations_only() -> None:
    """Wrong: looks for the best rotations by a local search and returns their RᵀR, which is no
    lower bound where no rotations reach it. Caught by solve_sdp-gap.
    """
    import numpy as np

    def solve_sdp(Q, n, d):
        Q = np.asarray(Q, dtype=float)
        best = None
        for start in range(4):
            rows = np.random.default_rng(start).normal(size=(n, d, d))
            R = np.linalg.qr(rows)[0]
            R[:, :, -1] *= np.linalg.det(R)[:, None]
            for _ in range(60):
                for k in range(n):
                    others = [a for a in range(n) if a != k]
                    pull = sum(R[a] @ Q[a * d : a * d + d, k * d : k * d + d] for a in others)
                    left, _, right = np.linalg.svd(-pull)
                    left[:, -1] *= np.linalg.det(left @ right)
                    R[k] = left @ right
            wide = np.hstack(list(R))
            cost = np.sum((wide @ Q) * wide)
            if best is None or cost < best[0]:
                best = (cost, wide.T @ wide)
        return best[1]


def wrong_indefinite() -> None:
    """Wrong: forgets Z ⪰ 0 and bounds the entries by 1 instead. Caught by solve_sdp-space."""
    import cvxpy as cp
    import numpy as np

    def solve_sdp(Q, n, d):
        Z = cp.Variable((n * d, n * d), symmetric=True)
        constraints = [Z[k : k + d, k : k + d] == np.eye(d) for k in range(0, n * d, d)]
        constraints += [Z <= 1, Z >= -1]
        problem = cp.Problem(cp.Minimize(cp.trace(np.asarray(Q) @ Z)), constraints)
        problem.solve(solver=cp.CLARABEL)
        return Z.value


def wrong_value() -> None:
    """Wrong: returns the least value and not the matrix. Stopped by the visible case
    solve_sdp-by-hand.
    """
    import cvxpy as cp
    import numpy as np

    def solve_sdp(Q, n, d):
        Z = cp.Variable((n * d, n * d), PSD=True)
        blocks = [Z[k : k + d, k : k + d] == np.eye(d) for k in range(0, n * d, d)]
        problem = cp.Problem(cp.Minimize(cp.trace(np.asarray(Q) @ Z)), blocks)
        return problem.solve(solver=cp.CLARABEL)


def wrong_maximum() -> None:
    """Wrong: maximises. Stopped by the visible case solve_sdp-by-hand."""
    import cvxpy as cp
    import numpy as np

    def solve_sdp(Q, n, d):
        Z = cp.Variable((n * d, n * d), PSD=True)
        blocks = [Z[k : k + d, k : k + d] == np.eye(d) for k in range(0, n * d, d)]
        problem = cp.Problem(cp.Maximize(cp.trace(np.asarray(Q) @ Z)), blocks)
        problem.solve(solver=cp.CLARABEL)
        return Z.value


def wrong_plane_only() -> None:
    """Wrong: writes 2 for d. Stopped by the visible case solve_sdp-space."""
    import cvxpy as cp
    import numpy as np

    def solve_sdp(Q, n, d):
        Z = cp.Variable((2 * n, 2 * n), PSD=True)
        blocks = [Z[k : k + 2, k : k + 2] == np.eye(2) for k in range(0, 2 * n, 2)]
        problem = cp.Problem(cp.Minimize(cp.trace(np.asarray(Q) @ Z)), blocks)
        problem.solve(solver=cp.CLARABEL)
        return Z.value


def wrong_equal_poses() -> None:
    """Wrong: takes Z for the matrix of identity blocks everywhere, as if all poses were equal.
    Stopped by the visible case solve_sdp-gap.
    """
    import numpy as np

    def solve_sdp(Q, n, d):
        return np.kron(np.ones((n, n)), np.eye(d))
