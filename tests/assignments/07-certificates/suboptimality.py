"""Answers to exercise suboptimality of 07-certificates: each body is a cell as handed in."""

from robust_slam_autograder.lint.answers import change


def right_formula() -> None:
    """Right: the formula, with S made on the spot."""
    import numpy as np

    def suboptimality(Q, R):
        Q, R = np.array(Q, dtype=float), np.array(R, dtype=float)
        inside = np.kron(np.eye(len(Q) // len(R)), np.ones((len(R), len(R))))
        A = inside * (Q @ R.T @ R)
        lowest = np.linalg.eigvalsh(Q - (A + A.T) / 2)[0]
        return np.maximum(0.0, -len(Q) * lowest)


def right_largest_of_the_negative() -> None:
    """Right, by a library routine: scipy's largest eigenvalue of Λ − Q, and a plain float."""
    import numpy as np
    from scipy.linalg import eigh

    def suboptimality(Q, R):
        R = np.asarray(R, dtype=float)
        d, dn = R.shape
        minus_s = -np.asarray(Q, dtype=float)
        pulls = -minus_s @ R.T
        for k in range(0, dn, d):
            A = pulls[k : k + d] @ R[:, k : k + d]
            minus_s[k : k + d, k : k + d] += (A + A.T) / 2
        top = eigh(minus_s, eigvals_only=True, subset_by_index=[dn - 1, dn - 1])[0]
        return float(dn * top) if top > 0 else 0.0


def right_cost_minus_bound() -> None:
    """Right, an equivalent form: the cost less the value of the dual problem, cut off near 0."""
    import numpy as np

    def suboptimality(Q, R):
        Q, R = np.array(Q, dtype=float), np.array(R, dtype=float)
        d, dn = R.shape
        Lambda = np.zeros_like(Q)
        for k in range(0, dn, d):
            at = slice(k, k + d)
            A = Q[at] @ R.T @ R[:, at]
            Lambda[at, at] = (A + A.T) / 2
        shifted = Lambda + min(np.linalg.eigvalsh(Q - Lambda)) * np.eye(dn)
        gap = np.trace(R @ Q @ R.T) - np.trace(shifted)
        return gap if gap > 1e-12 * np.linalg.norm(Q) * dn else 0


wrong_without_dn = change(
    right_formula, "-len(Q) * lowest", "-lowest", stopped_by="suboptimality-by-hand"
)
"""Wrong: −λ_min alone."""

wrong_half = change(
    right_formula, "-len(Q)", "-len(Q) / len(R)", stopped_by="suboptimality-by-hand"
)
"""Wrong: counts one row for each pose, n for dn."""

wrong_plane_only = change(
    right_formula, "-len(Q)", "-2 * len(Q) / len(R)", caught_by="suboptimality-space"
)
"""Wrong: two rows for each pose, in space too."""

wrong_dn_of_four = change(right_formula, "-len(Q)", "-4", caught_by="suboptimality-plane")
"""Wrong: a factor of 4, which is dn for two poses in the plane."""

wrong_negative = change(
    right_formula,
    "np.maximum(0.0, -len(Q) * lowest)",
    "-len(Q) * lowest",
    caught_by="suboptimality-best",
)
"""Wrong: nothing stops it at 0, so that rounding makes rotations better than the best."""

wrong_cost = change(
    right_formula, "-len(Q) * lowest", "np.trace(R @ Q @ R.T)", caught_by="suboptimality-space"
)
"""Wrong: gives the cost, which is the gap where the best cost is 0."""

wrong_without_multipliers = change(
    right_formula, "Q - (A + A.T) / 2", "Q", stopped_by="suboptimality-by-hand"
)
"""Wrong: the eigenvalue of Q and not of S."""

wrong_not_symmetrised = change(
    right_formula, "(A + A.T) / 2", "A", caught_by="suboptimality-anywhere"
)
"""Wrong: the blocks of Λ as they come; eigvalsh then reads one half of S alone."""
