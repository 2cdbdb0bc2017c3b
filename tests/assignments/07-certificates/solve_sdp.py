"""Answers to exercise solve_sdp of 07-certificates: each body is a cell as handed in."""

from robust_slam_autograder.lint.answers import change


def right_clarabel() -> None:
    """Right: a variable that is positive semidefinite, and Clarabel."""
    import cvxpy as cp
    import numpy as np

    def solve_sdp(Q, n, d):
        Z = cp.Variable((n * d, n * d), PSD=True)
        blocks = [Z[k : k + d, k : k + d] == np.eye(d) for k in range(0, n * d, d)]
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


wrong_unit_diagonal = change(
    right_clarabel,
    "blocks = [Z[k : k + d, k : k + d] == np.eye(d) for k in range(0, n * d, d)]",
    "blocks = [cp.diag(Z) == 1]",
    caught_by="solve_sdp-space",
)
"""Wrong: asks for diag(Z) = 1 alone, which is enough for the rings of the plane."""

wrong_traces_of_blocks = change(
    right_clarabel,
    "Z[k : k + d, k : k + d] == np.eye(d)",
    "cp.trace(Z[k : k + d, k : k + d]) == d",
    caught_by="solve_sdp-any-matrix",
)
"""Wrong: fixes the trace of each diagonal block and not the block."""

wrong_rotations_only = change(
    right_low_rank,
    ("size=(n * d, n, d)", "size=(d, n, d)"),
    ("= left @ right", "= left * [*np.ones(d - 1), np.linalg.det(left @ right)] @ right"),
    caught_by="solve_sdp-gap",
)
"""Wrong: returns RᵀR of the best rotations, which is no lower bound where there is a gap."""

wrong_indefinite = change(
    right_clarabel,
    ("PSD=True", "symmetric=True"),
    ("), blocks)", "), [*blocks, Z <= 1, Z >= -1])"),
    caught_by="solve_sdp-space",
)
"""Wrong: forgets Z ⪰ 0 and bounds the entries by 1 instead."""

wrong_value = change(right_clarabel, "return Z", "return problem", stopped_by="solve_sdp-by-hand")
"""Wrong: returns the least value and not the matrix."""

wrong_maximum = change(right_clarabel, "Minimize", "Maximize", stopped_by="solve_sdp-by-hand")
"""Wrong: maximises."""

wrong_plane_only = change(right_clarabel, "Z = cp.", "d, Z = 2, cp.", stopped_by="solve_sdp-space")
"""Wrong: writes 2 for d."""

wrong_equal_poses = change(
    right_clarabel, "Z.value", "np.kron(np.ones((n, n)), np.eye(d))", stopped_by="solve_sdp-gap"
)
"""Wrong: takes Z for the matrix of identity blocks everywhere, as if all poses were equal."""
