"""Answers to exercise jacobians of 08-showcase: each body is a cell as handed in."""

from robust_slam_autograder.lint.answers import change


def right_closed() -> None:
    """Right: the inverse right Jacobian of the residual, and the adjoint for pose i."""
    import numpy as np

    def jacobians(pose_i, pose_j, z):
        def seen(a, b):
            c, s = np.cos(a[2]), np.sin(a[2])
            step = np.array([[c, s], [-s, c]]) @ (b[:2] - a[:2])
            return np.append(step, (b[2] - a[2] + np.pi) % (2 * np.pi) - np.pi)

        i, j, z = (np.array(p, dtype=float) for p in (pose_i, pose_j, z))
        x, y, angle = seen(z, seen(i, j))
        half = angle / 2
        q = np.cos(half) / np.sinc(half / np.pi)
        bend = (1 - q) / angle if abs(angle) > 1e-3 else angle / 12
        x, y = q * x + half * y, q * y - half * x
        by_j = np.array([[q, -half, bend * x + y / 2], [half, q, bend * y - x / 2], [0, 0, 1]])
        back = seen(j, i)
        c, s = np.cos(back[2]), np.sin(back[2])
        adjoint = np.array([[c, -s, back[1]], [s, c, -back[0]], [0, 0, 1]])
        return -by_j @ adjoint, by_j


def right_matrix_differences() -> None:
    """Right, library routines: central differences of logarithms of matrices."""
    import numpy as np
    from scipy.linalg import expm, logm

    def jacobians(pose_i, pose_j, z):
        def matrix(pose):
            x, y, angle = pose
            c, s = np.cos(angle), np.sin(angle)
            return np.array([[c, -s, x], [s, c, y], [0, 0, 1]])

        def hat(d):
            return np.array([[0, -d[2], d[0]], [d[2], 0, d[1]], [0, 0, 0]])

        def error(by_i, by_j):
            i, j = matrix(pose_i) @ expm(hat(by_i)), matrix(pose_j) @ expm(hat(by_j))
            twist = logm(np.linalg.inv(matrix(z)) @ np.linalg.inv(i) @ j).real
            return np.array([twist[0, 2], twist[1, 2], twist[1, 0]])

        h, none = 1e-5, np.zeros(3)
        by_i = [(error(h * e, none) - error(-h * e, none)) / (2 * h) for e in np.eye(3)]
        by_j = [(error(none, h * e) - error(none, -h * e)) / (2 * h) for e in np.eye(3)]
        return np.transpose(by_i), np.transpose(by_j)


def right_scipy() -> None:
    """Right: scipy's numerical Jacobian of a function of all six numbers; lists come back."""
    import numpy as np
    from scipy.optimize._numdiff import approx_derivative

    def jacobians(pose_i, pose_j, z):
        def moved(p, d):
            angle = d[2]
            bow = 1.0 if angle == 0 else (np.exp(1j * angle) - 1) / (1j * angle)
            place = complex(p[0], p[1]) + np.exp(1j * p[2]) * complex(d[0], d[1]) * bow
            return place, p[2] + angle

        def residual(d):
            (at_i, turn_i), (at_j, turn_j) = moved(pose_i, d[:3]), moved(pose_j, d[3:])
            gap = (at_j - at_i) * np.exp(-1j * turn_i) - complex(z[0], z[1])
            gap = gap * np.exp(-1j * z[2])
            angle = np.angle(np.exp(1j * (turn_j - turn_i - z[2])))
            half = angle / 2
            rho = gap * (np.cos(half) / np.sinc(half / np.pi) - 1j * half)
            return np.array([rho.real, rho.imag, angle])

        both = approx_derivative(residual, np.zeros(6), method="3-point")
        return both[:, :3].tolist(), both[:, 3:].tolist()


wrong_left_perturbation = change(
    right_scipy,
    "complex(p[0], p[1]) + np.exp(1j * p[2]) * complex(d[0], d[1]) * bow",
    "complex(d[0], d[1]) * bow + np.exp(1j * angle) * complex(p[0], p[1])",
    stopped_by="jacobians-by-hand",
)
"""Wrong: moves the poses on the left, by a step in the world's frame."""

wrong_without_the_bend = change(
    right_closed, "= seen(z, seen(i, j))", "= np.zeros(3)", stopped_by="jacobians-random"
)
"""Wrong: the identity, and the adjoint alone, which is right for a residual of zero only."""

wrong_first_order_bend = change(
    right_closed,
    "[[q, -half, bend * x + y / 2], [half, q, bend * y - x / 2], [0, 0, 1]]",
    "[[1, -half, y / 2], [half, 1, -x / 2], [0, 0, 1]]",
    caught_by="jacobians-random",
)
"""Wrong: the bend of the logarithm to first order in the residual."""

wrong_additive_steps = change(
    right_scipy,
    "complex(p[0], p[1]) + np.exp(1j * p[2]) * complex(d[0], d[1]) * bow",
    "complex(p[0] + d[0], p[1] + d[1])",
    stopped_by="jacobians-small",
)
"""Wrong: adds the step to x, y and θ of the pose, which is no step of the robot's."""

wrong_transposed = change(
    right_closed,
    "-by_j @ adjoint, by_j",
    "-(by_j @ adjoint).T, by_j.T",
    stopped_by="jacobians-by-hand",
)
"""Wrong: rows for columns."""

wrong_turns_in_the_difference = change(
    right_scipy,
    "np.angle(np.exp(1j * (turn_j - turn_i - z[2])))",
    "turn_j - turn_i - z[2]",
    caught_by="jacobians-far",
)
"""Wrong: the angle of the residual keeps whole turns, which bends the logarithm."""
