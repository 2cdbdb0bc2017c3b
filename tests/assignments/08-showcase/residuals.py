"""Answers to exercise residuals of 08-showcase: each body is a cell as handed in."""

from robust_slam_autograder.lint.answers import change


def right_loop() -> None:
    """Right: plain Python, edge by edge, with math alone."""
    import math

    def residuals(poses, graph):
        def seen(a, b):
            x, y = b[0] - a[0], b[1] - a[1]
            c, s = math.cos(a[2]), math.sin(a[2])
            return c * x + s * y, c * y - s * x, math.remainder(b[2] - a[2], 2 * math.pi)

        rows = []
        for (i, j), z in zip(graph["edges"], graph["measurement"]):
            x, y, angle = seen(z, seen(poses[i], poses[j]))
            half = angle / 2
            q = half / math.tan(half) if abs(half) > 1e-9 else 1.0
            rows.append([q * x + half * y, q * y - half * x, angle])
        return rows


def right_matrix_logarithm() -> None:
    """Right, a library routine: the logarithm of a 3×3 matrix."""
    import numpy as np
    from scipy.linalg import logm

    def residuals(poses, graph):
        def matrix(pose):
            x, y, angle = pose
            c, s = np.cos(angle), np.sin(angle)
            return np.array([[c, -s, x], [s, c, y], [0, 0, 1]])

        rows = []
        for (i, j), z in zip(graph["edges"], graph["measurement"]):
            step = np.linalg.solve(matrix(poses[i]), matrix(poses[j]))
            twist = logm(np.linalg.solve(matrix(z), step)).real
            rows.append([twist[0, 2], twist[1, 2], twist[1, 0]])
        return np.array(rows)


def right_complex() -> None:
    """Right: positions and turns as complex numbers; Log divides by the mean direction."""
    import numpy as np

    def residuals(poses, graph):
        def parts(p):
            return p[:, 0] + 1j * p[:, 1], np.exp(1j * p[:, 2])

        place, turn = parts(np.asarray(poses, dtype=float))
        z_place, z_turn = parts(graph["measurement"])
        i, j = graph["edges"][:, 0], graph["edges"][:, 1]
        gap = ((place[j] - place[i]) / turn[i] - z_place) / z_turn
        angle = np.angle(turn[j] / turn[i] / z_turn)
        flat = np.abs(angle) < 1e-9
        safe = np.where(flat, 1.0, angle)
        mean = np.where(flat, 1.0, (np.exp(1j * safe) - 1) / (1j * safe))
        rho = gap / mean
        return np.column_stack([rho.real, rho.imag, angle])


def right_solve_the_bend() -> None:
    """Right: solves with the matrix of Exp for each edge in place of its inverse."""
    import numpy as np

    def residuals(poses, graph):
        def seen(a, b):
            c, s = np.cos(a[2]), np.sin(a[2])
            step = np.array([[c, s], [-s, c]]) @ (b[:2] - a[:2])
            angle = (b[2] - a[2] + np.pi) % (2 * np.pi) - np.pi
            return np.append(step, angle)

        poses = np.array(poses, dtype=float)
        answer = np.empty((len(graph["edges"]), 3))
        for row, (i, j) in enumerate(graph["edges"]):
            error = seen(graph["measurement"][row], seen(poses[i], poses[j]))
            angle = error[2]
            s, k = np.sinc(angle / np.pi), np.sin(angle / 2) * np.sinc(angle / 2 / np.pi)
            answer[row, :2] = np.linalg.solve([[s, -k], [k, s]], error[:2])
            answer[row, 2] = angle
        return answer


def wrong_coordinates() -> None:
    """Wrong: takes x and y of the error as they are, without the logarithm. Stopped by the visible
    case residuals-by-hand.
    """
    import numpy as np

    def residuals(poses, graph):
        def parts(p):
            return p[:, 0] + 1j * p[:, 1], np.exp(1j * p[:, 2])

        place, turn = parts(np.asarray(poses, dtype=float))
        z_place, z_turn = parts(graph["measurement"])
        i, j = graph["edges"].T
        gap = ((place[j] - place[i]) / turn[i] - z_place) / z_turn
        return np.column_stack([gap.real, gap.imag, np.angle(turn[j] / turn[i] / z_turn)])


wrong_division_at_zero = change(
    right_complex,
    ('i, j = graph["edges"][:, 0], graph["edges"][:, 1]', 'i, j = graph["edges"].T'),
    (
        """
        flat = np.abs(angle) < 1e-9
        safe = np.where(flat, 1.0, angle)
        mean = np.where(flat, 1.0, (np.exp(1j * safe) - 1) / (1j * safe))
        rho = gap / mean
        """,
        "rho = gap * (angle / 2 / np.tan(angle / 2) - 0.5j * angle)",
    ),
    stopped_by="residuals-exact",
)
"""Wrong: divides by the tangent of a half angle of zero: NaN where the map fits."""

wrong_small_angle_log = change(
    right_complex,
    ('i, j = graph["edges"][:, 0], graph["edges"][:, 1]', 'i, j = graph["edges"].T'),
    (
        """
        flat = np.abs(angle) < 1e-9
        safe = np.where(flat, 1.0, angle)
        mean = np.where(flat, 1.0, (np.exp(1j * safe) - 1) / (1j * safe))
        rho = gap / mean
        """,
        "rho = gap * (1 - 0.5j * angle)",
    ),
    stopped_by="residuals-by-hand",
)
"""Wrong: the matrix of the half angle for small angles, its diagonal always 1."""


def wrong_no_wrap() -> None:
    """Wrong: subtracts angles with their whole turns. Stopped by the visible case
    residuals-wrap.
    """
    import numpy as np

    def residuals(poses, graph):
        poses, z = np.asarray(poses, dtype=float), graph["measurement"]
        i, j = graph["edges"].T
        place = poses[:, 0] + 1j * poses[:, 1]
        gap = (place[j] - place[i]) * np.exp(-1j * poses[i, 2]) - (z[:, 0] + 1j * z[:, 1])
        gap = gap * np.exp(-1j * z[:, 2])
        angle = poses[j, 2] - poses[i, 2] - z[:, 2]
        half = angle / 2
        rho = gap * (np.cos(half) / np.sinc(half / np.pi) - 1j * half)
        return np.column_stack([rho.real, rho.imag, angle])


def wrong_wraps_before_z() -> None:
    """Wrong: takes whole turns out of the step, and none out after the measurement is taken off.
    Caught by residuals-wrap.
    """
    import numpy as np

    def residuals(poses, graph):
        poses, z = np.asarray(poses, dtype=float), graph["measurement"]
        i, j = graph["edges"].T
        place = poses[:, 0] + 1j * poses[:, 1]
        gap = (place[j] - place[i]) * np.exp(-1j * poses[i, 2]) - (z[:, 0] + 1j * z[:, 1])
        gap = gap * np.exp(-1j * z[:, 2])
        angle = np.angle(np.exp(1j * (poses[j, 2] - poses[i, 2]))) - z[:, 2]
        half = angle / 2
        rho = gap * (np.cos(half) / np.sinc(half / np.pi) - 1j * half)
        return np.column_stack([rho.real, rho.imag, angle])


def wrong_whitened() -> None:
    """Wrong: whitens by the information, which is the solver's business. Caught by
    residuals-edges.
    """
    import numpy as np

    def residuals(poses, graph):
        def parts(p):
            return p[:, 0] + 1j * p[:, 1], np.exp(1j * p[:, 2])

        place, turn = parts(np.asarray(poses, dtype=float))
        z_place, z_turn = parts(graph["measurement"])
        i, j = graph["edges"].T
        gap = ((place[j] - place[i]) / turn[i] - z_place) / z_turn
        angle = np.angle(turn[j] / turn[i] / z_turn)
        half = angle / 2
        rho = gap * (np.cos(half) / np.sinc(half / np.pi) - 1j * half)
        r = np.column_stack([rho.real, rho.imag, angle])
        root = np.linalg.cholesky(graph["information"])
        return np.einsum("kba,kb->ka", root, r)


def wrong_forward_edges() -> None:
    """Wrong: sorts the two ends of an edge, so that closures to earlier poses are turned round.
    Stopped by the visible case residuals-edges.
    """
    import numpy as np

    def residuals(poses, graph):
        def parts(p):
            return p[:, 0] + 1j * p[:, 1], np.exp(1j * p[:, 2])

        place, turn = parts(np.asarray(poses, dtype=float))
        z_place, z_turn = parts(graph["measurement"])
        i, j = np.sort(graph["edges"], axis=1).T
        gap = ((place[j] - place[i]) / turn[i] - z_place) / z_turn
        angle = np.angle(turn[j] / turn[i] / z_turn)
        half = angle / 2
        rho = gap * (np.cos(half) / np.sinc(half / np.pi) - 1j * half)
        return np.column_stack([rho.real, rho.imag, angle])
