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

        poses, z = np.asarray(poses, dtype=float), graph["measurement"]
        (place, turn), (z_place, z_turn) = parts(poses), parts(z)
        i, j = graph["edges"].T
        gap = ((place[j] - place[i]) / turn[i] - z_place) / z_turn
        angle = np.angle(turn[j] / turn[i] / z_turn)
        flat = np.abs(angle) < 1e-9
        safe = np.where(flat, 1.0, angle)
        mean = np.where(flat, 1.0, (np.exp(1j * safe) - 1) / (1j * safe))
        rho = gap / mean
        r = np.column_stack([rho.real, rho.imag, angle])
        return r


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


wrong_coordinates = change(right_complex, "gap / mean", "gap", stopped_by="residuals-by-hand")
"""Wrong: takes x and y of the error as they are, without the logarithm."""

wrong_division_at_zero = change(
    right_complex, "flat = np.abs(angle) < 1e-9", "flat = False", stopped_by="residuals-exact"
)
"""Wrong: divides by an angle of zero: NaN where the map fits."""

wrong_small_angle_log = change(
    right_complex, "gap / mean", "gap * (1 - 0.5j * angle)", stopped_by="residuals-by-hand"
)
"""Wrong: the matrix of the half angle for small angles, its diagonal always 1."""

wrong_no_wrap = change(
    right_complex,
    "angle = np.angle(turn[j] / turn[i] / z_turn)",
    "angle = poses[j, 2] - poses[i, 2] - z[:, 2]",
    stopped_by="residuals-wrap",
)
"""Wrong: subtracts angles with their whole turns."""

wrong_wraps_before_z = change(
    right_complex,
    "angle = np.angle(turn[j] / turn[i] / z_turn)",
    "angle = np.angle(turn[j] / turn[i]) - z[:, 2]",
    caught_by="residuals-wrap",
)
"""Wrong: takes whole turns out of the step, and none out after the measurement is taken off."""

wrong_whitened = change(
    right_complex,
    "return r",
    'return np.einsum("kba,kb->ka", np.linalg.cholesky(graph["information"]), r)',
    caught_by="residuals-edges",
)
"""Wrong: whitens by the information, which is the solver's business."""

wrong_forward_edges = change(
    right_complex,
    'graph["edges"].T',
    'np.sort(graph["edges"], axis=1).T',
    stopped_by="residuals-edges",
)
"""Wrong: sorts the two ends of an edge, so that closures to earlier poses are turned round."""
