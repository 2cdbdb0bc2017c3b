"""Answers to exercise ate of 08-showcase: each body is a cell as handed in."""

from robust_slam_autograder.lint.answers import change


def right_svd() -> None:
    """Right: the best rotation by the singular value decomposition, its determinant held at 1."""
    import numpy as np

    def ate(estimate, truth):
        p, q = np.array(estimate, dtype=float)[:, :2], np.array(truth, dtype=float)[:, :2]
        p, q = p - p.mean(axis=0), q - q.mean(axis=0)
        u, _, vt = np.linalg.svd(q.T @ p)
        turn = u @ np.diag([1, np.sign(np.linalg.det(u @ vt))]) @ vt
        return np.sqrt(np.mean(np.sum((p @ turn.T - q) ** 2, axis=1)))


def right_scipy_rotation() -> None:
    """Right, a library routine: scipy aligns vectors in space, here with its z axis held."""
    import numpy as np
    from scipy.spatial.transform import Rotation

    def ate(estimate, truth):
        p, q = np.array(estimate, dtype=float)[:, :2], np.array(truth, dtype=float)[:, :2]
        p, q = p - p.mean(axis=0), q - q.mean(axis=0)
        if len(p) == 1:
            return 0.0
        flat = np.zeros((len(p), 1))
        above = [[0.0, 0.0, 1.0]]
        weights = np.append(np.ones(len(p)), 1e9)
        turn, _ = Rotation.align_vectors(
            np.concatenate([np.hstack([q, flat]), above]),
            np.concatenate([np.hstack([p, flat]), above]),
            weights=weights,
        )
        moved = turn.apply(np.hstack([p, flat]))[:, :2]
        return float(np.sqrt(np.mean(np.sum((moved - q) ** 2, axis=1))))


def right_arctangent() -> None:
    """Right: plain sums; the best angle is the arctangent of the crossed and the dotted ones."""
    import math

    def ate(estimate, truth):
        n = len(truth)
        mx, my = sum(p[0] for p in estimate) / n, sum(p[1] for p in estimate) / n
        tx, ty = sum(p[0] for p in truth) / n, sum(p[1] for p in truth) / n
        pairs = [(p[0] - mx, p[1] - my, q[0] - tx, q[1] - ty) for p, q in zip(estimate, truth)]
        angle = math.atan2(
            sum(a * d - b * c for a, b, c, d in pairs), sum(a * c + b * d for a, b, c, d in pairs)
        )
        c0, s0 = math.cos(angle), math.sin(angle)
        square = sum(
            (c0 * a - s0 * b - c) ** 2 + (s0 * a + c0 * b - d) ** 2 for a, b, c, d in pairs
        )
        return math.sqrt(square / n)


def right_search() -> None:
    """Right: looks for the angle on a grid, and then refines it."""
    import numpy as np
    from scipy.optimize import minimize_scalar

    def ate(estimate, truth):
        a, b = (np.array(m, dtype=float)[:, :2] @ [1, 1j] for m in (estimate, truth))
        a, b = a - a.mean(), b - b.mean()

        def rmse(angle):
            return np.sqrt(np.mean(np.abs(np.exp(1j * angle) * a - b) ** 2))

        start = min(np.linspace(-np.pi, np.pi, 721), key=rmse)
        found = minimize_scalar(
            rmse, bounds=(start - 0.01, start + 0.01), method="bounded", options={"xatol": 1e-12}
        )
        return min(rmse(start), found.fun)


wrong_not_aligned = change(
    right_svd,
    ("p, q = p - p.mean(axis=0), q - q.mean(axis=0)", ""),
    ("p @ turn.T", "p"),
    stopped_by="ate-by-hand",
)
"""Wrong: compares positions as they lie."""

wrong_shift_only = change(right_svd, "p @ turn.T", "p", stopped_by="ate-moved")
"""Wrong: puts the middles on each other and does not turn."""

wrong_with_scale = change(
    right_svd,
    "p @ turn.T",
    "p @ turn.T * np.sum(q * (p @ turn.T)) / max(np.sum(p**2), 1e-300)",
    stopped_by="ate-by-hand",
)
"""Wrong: scales the estimate too, and a map of the wrong size has no error."""

wrong_mirrored = change(
    right_svd, "np.diag([1, np.sign(np.linalg.det(u @ vt))]) @ vt", "vt", stopped_by="ate-mirror"
)
"""Wrong: takes the best orthogonal matrix, be it a reflection."""

wrong_mean_distance = change(
    right_svd,
    "np.sqrt(np.mean(np.sum((p @ turn.T - q) ** 2, axis=1)))",
    "np.mean(np.linalg.norm(p @ turn.T - q, axis=1))",
    caught_by="ate-random",
)
"""Wrong: the mean of the distances in place of the root of the mean square."""

wrong_sum_of_squares = change(
    right_svd,
    "np.sqrt(np.mean(np.sum((p @ turn.T - q) ** 2, axis=1)))",
    "np.linalg.norm(p @ turn.T - q)",
    stopped_by="ate-by-hand",
)
"""Wrong: the root of the sum, so that a longer way is a worse one."""

wrong_aligned_by_the_first = change(
    right_svd,
    ("p, q = p - p.mean(axis=0), q - q.mean(axis=0)", "p, q = p - p[0], q - q[0]"),
    (
        "turn = u @ np.diag([1, np.sign(np.linalg.det(u @ vt))]) @ vt",
        """
        angle = truth[0][2] - estimate[0][2]
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        """,
    ),
    stopped_by="ate-by-hand",
)
"""Wrong: lays the first pose of one map on the first of the other, heading on heading."""

wrong_headings_judged = change(
    right_svd,
    "return np.sqrt(np.mean(np.sum((p @ turn.T - q) ** 2, axis=1)))",
    """
    angle = np.arctan2(turn[1, 0], turn[0, 0])
    heading = np.array(estimate)[:, 2] + angle - np.array(truth)[:, 2]
    heading = np.angle(np.exp(1j * heading))
    return np.sqrt(np.mean(np.sum((p @ turn.T - q) ** 2, axis=1) + heading**2))
    """,
    stopped_by="ate-moved",
)
"""Wrong: the error of the headings is added."""
