"""Answers to exercise gauss_newton of 08-showcase: each body is a cell as handed in."""

from robust_slam_autograder.lint.answers import change


def right_arrays() -> None:
    """Right: all edges at once, central differences, and pose 0 left out of the equations."""
    import numpy as np

    def gauss_newton(graph, poses, weights, tol):
        def turned(angle, v):
            c, s = np.cos(angle), np.sin(angle)
            return np.stack([c * v[..., 0] - s * v[..., 1], s * v[..., 0] + c * v[..., 1]], -1)

        def seen(a, b):
            angle = (b[..., 2:] - a[..., 2:] + np.pi) % (2 * np.pi) - np.pi
            return np.concatenate([turned(-a[..., 2], (b - a)[..., :2]), angle], axis=-1)

        def moved(a, d):
            s, k = np.sinc(d[..., 2] / np.pi), d[..., 2] / 2 * np.sinc(d[..., 2] / 2 / np.pi) ** 2
            bow = np.stack([s * d[..., 0] - k * d[..., 1], k * d[..., 0] + s * d[..., 1]], -1)
            place = a[..., :2] + turned(a[..., 2], bow)
            return np.concatenate([place, a[..., 2:] + d[..., 2:]], axis=-1)

        def error(a, b):
            e = seen(z, seen(a, b))
            half = e[..., 2] / 2
            q = np.cos(half) / np.sinc(half / np.pi)
            x, y = q * e[..., 0] + half * e[..., 1], q * e[..., 1] - half * e[..., 0]
            return np.stack([x, y, e[..., 2]], axis=-1)

        x, z = np.array(poses, dtype=float), graph["measurement"]
        i, j = graph["edges"].T
        w = np.asarray(weights, dtype=float)[:, None, None]
        omega = w * graph["information"]
        n, m, h = graph["n"], len(i), 1e-5
        for _ in range(50):
            jacobian = np.zeros((m, 3, n, 3))
            for k in range(3):
                d = h * np.eye(3)[k]
                jacobian[np.arange(m), :, i, k] = (
                    error(moved(x[i], d), x[j]) - error(moved(x[i], -d), x[j])
                ) / (2 * h)
                jacobian[np.arange(m), :, j, k] = (
                    error(x[i], moved(x[j], d)) - error(x[i], moved(x[j], -d))
                ) / (2 * h)
            rows = jacobian.reshape(m, 3, 3 * n)
            H = np.einsum("kai,kab,kbj->ij", rows, omega, rows)
            b = -np.einsum("kai,kab,kb->i", rows, omega, error(x[i], x[j]))
            delta = np.zeros(3 * n)
            delta[3:] = np.linalg.solve(H[3:, 3:], b[3:])
            x = moved(x, delta.reshape(n, 3))
            if np.max(np.abs(delta)) <= tol:
                break
        return x


def right_square_roots() -> None:
    """Right: least squares by scipy's library routine over whitened residuals, x, y and θ of each
    pose but the first as its variables.
    """
    import numpy as np
    from scipy.optimize import least_squares

    def gauss_newton(graph, poses, weights, tol):
        poses, z = np.array(poses, dtype=float), graph["measurement"]
        i, j = graph["edges"].T
        scaled = np.asarray(weights, dtype=float)[:, None, None] * graph["information"]
        values, vectors = np.linalg.eigh(scaled)
        root = np.sqrt(np.maximum(values, 0))[:, :, None] * np.swapaxes(vectors, 1, 2)

        def whitened(free):
            x = np.concatenate([poses[:1], free.reshape(-1, 3)])
            gap = ((x[j] - x[i])[:, 0] + 1j * (x[j] - x[i])[:, 1]) * np.exp(-1j * x[i, 2])
            gap = (gap - z[:, 0] - 1j * z[:, 1]) * np.exp(-1j * z[:, 2])
            angle = np.angle(np.exp(1j * (x[j, 2] - x[i, 2] - z[:, 2])))
            half = angle / 2
            rho = gap * (np.cos(half) / np.sinc(half / np.pi) - 1j * half)
            r = np.column_stack([rho.real, rho.imag, angle])
            return np.einsum("kab,kb->ka", root, r).ravel()

        found = least_squares(
            whitened, poses[1:].ravel(), jac="3-point", xtol=1e-14, ftol=1e-14, gtol=1e-14
        )
        return np.concatenate([poses[:1], found.x.reshape(-1, 3)]).tolist()


right_prior = change(
    right_arrays,
    "delta[3:] = np.linalg.solve(H[3:, 3:], b[3:])",
    """
    H[:3, :3] += 1e9 * np.eye(3)
    delta[3:] = np.linalg.solve(H, b)[3:]
    """,
)
"""Right, an equivalent form: a spring of great strength holds pose 0, and every pose is solved
for; what pose 0 moved by is put back.
"""

right_lstsq = change(
    right_arrays,
    ("range(50)", "range(30)"),
    ("np.linalg.solve(H[3:, 3:], b[3:])", "np.linalg.lstsq(H[3:, 3:], b[3:], rcond=None)[0]"),
)
"""Right: solves each step by numpy's least squares, thirty steps at most."""

wrong_covariance = change(
    right_arrays,
    'graph["information"]',
    'np.linalg.inv(graph["information"])',
    stopped_by="gauss_newton-random",
)
"""Wrong: takes the information for a covariance and inverts it."""

wrong_diagonal_only = change(
    right_arrays,
    'graph["information"]',
    'np.eye(3) * graph["information"]',
    caught_by="gauss_newton-random",
)
"""Wrong: whitens by the diagonal of the information."""

wrong_squared_weights = change(right_arrays, "w *", "w**2 *", stopped_by="gauss_newton-by-hand")
"""Wrong: multiplies residual and Jacobian by the weight each, which squares it."""

wrong_weights_ignored = change(
    right_arrays, "w * graph", "graph", stopped_by="gauss_newton-by-hand"
)
"""Wrong: every edge counts fully."""

wrong_weights_binary = change(
    right_arrays,
    "np.asarray(weights, dtype=float)",
    "1.0 * (np.asarray(weights) > 0.5)",
    stopped_by="gauss_newton-by-hand",
)
"""Wrong: an edge counts fully or not at all, by a weight over one half."""

wrong_two_steps = change(right_arrays, "range(50)", "range(2)", caught_by="gauss_newton-exact")
"""Wrong: stops after two steps, whatever tol says."""

wrong_one_step = change(right_arrays, "range(50)", "range(1)", caught_by="gauss_newton-exact")
"""Wrong: takes one step, and calls it the minimum."""

wrong_nothing_held = change(
    right_arrays,
    "delta[3:] = np.linalg.solve(H[3:, 3:], b[3:])",
    "delta = np.linalg.pinv(H) @ b",
    stopped_by="gauss_newton-by-hand",
)
"""Wrong: no pose is held; the smallest step of all that solve is taken, and pose 0 moves too."""

wrong_back_to_the_origin = change(
    right_arrays,
    'i, j = graph["edges"].T',
    'x = seen(x[:1], x)\ni, j = graph["edges"].T',
    stopped_by="gauss_newton-anchor",
)
"""Wrong: puts pose 0 at the origin, wherever it was handed in."""

wrong_integer_start = change(
    right_arrays,
    ("np.array(poses, dtype=float)", "np.array(poses)"),
    ("x = moved(x, delta.reshape(n, 3))", "x[...] = moved(x, delta.reshape(n, 3))"),
    stopped_by="gauss_newton-lists",
)
"""Wrong: starts in an array of the start's own type: whole numbers stay whole."""
