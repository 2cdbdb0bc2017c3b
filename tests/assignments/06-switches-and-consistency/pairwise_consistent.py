"""Answers to exercise pairwise_consistent of 06-switches-and-consistency: bodies of cells."""

import numpy as np
from robust_slam_autograder.lint.answers import change


def right_plain() -> None:
    """Right: the statement's formulas, pose and covariance carried along together."""

    def compose(a, b):
        c, s = np.cos(a[2]), np.sin(a[2])
        return np.array([a[0] + c * b[0] - s * b[1], a[1] + s * b[0] + c * b[1], a[2] + b[2]])

    def inverse(a):
        c, s = np.cos(a[2]), np.sin(a[2])
        return np.array([-c * a[0] - s * a[1], s * a[0] - c * a[1], -a[2]])

    def adjoint(a):
        c, s = np.cos(a[2]), np.sin(a[2])
        return np.array([[c, -s, a[1]], [s, c, -a[0]], [0, 0, 1]])

    def log(a):
        angle = np.arctan2(np.sin(a[2]), np.cos(a[2]))
        h = 1.0 if abs(angle) < 1e-9 else angle / 2 / np.tan(angle / 2)
        x, y = a[:2]
        return np.array([h * x + angle / 2 * y, h * y - angle / 2 * x, angle])

    def follow(a, b):
        back = adjoint(inverse(b[0]))
        return compose(a[0], b[0]), back @ a[1] @ back.T + b[1]

    def undo(a):
        carry = adjoint(a[0])
        return inverse(a[0]), carry @ a[1] @ carry.T

    def pairwise_consistent(odometry, odometry_cov, ends, loops, loop_cov, gamma):
        def walk(a, b):
            if a > b:
                return undo(walk(b, a))
            here = np.zeros(3), np.zeros((3, 3))
            for k in range(a, b):
                here = follow(here, (odometry[k], np.array(odometry_cov[k])))
            return here

        z = [(pose, np.array(cov)) for pose, cov in zip(loops, loop_cov)]
        consistent = np.eye(len(z), dtype=bool)
        for q in range(len(z)):
            for p in range(q):
                here = follow(z[p], walk(ends[p][1], ends[q][1]))
                here = follow(here, undo(z[q]))
                here = follow(here, walk(ends[q][0], ends[p][0]))
                e = log(here[0])
                distance = np.sqrt(e @ np.linalg.inv(here[1]) @ e)
                consistent[p, q] = consistent[q, p] = distance <= gamma
        return consistent


def right_one_long_cycle() -> None:
    """Right: each cycle as one list of steps, the covariances summed from its end backwards."""
    from robust_slam.graphs.se2 import adjoint, compose, inverse, log

    def pairwise_consistent(odometry, odometry_cov, ends, loops, loop_cov, gamma):
        steps, z = list(zip(odometry, odometry_cov)), list(zip(loops, loop_cov))

        def walk(a, b):
            if a > b:
                return [(pose, cov, not forward) for pose, cov, forward in walk(b, a)[::-1]]
            return [(pose, cov, True) for pose, cov in steps[a:b]]

        def distance(p, q):
            there, back = walk(ends[p][1], ends[q][1]), walk(ends[q][0], ends[p][0])
            after, total = np.zeros(3), np.zeros((3, 3))
            for pose, cov, forward in [(*z[p], True), *there, (*z[q], False), *back][::-1]:
                after = after if forward else compose(inverse(pose), after)
                carry = adjoint(inverse(after))
                total = total + carry @ np.asarray(cov) @ carry.T
                after = compose(pose, after) if forward else after
            e = log(after)
            return np.sqrt(e @ np.linalg.solve(total, e))

        m = range(len(z))
        return [[p == q or bool(distance(min(p, q), max(p, q)) <= gamma) for q in m] for p in m]


def right_world_frame() -> None:
    """Right, an equivalent form: every closure as a motion of the world, sums along the way."""
    from robust_slam.graphs.se2 import adjoint, between, compose, inverse, log

    def pairwise_consistent(odometry, odometry_cov, ends, loops, loop_cov, gamma):
        poses, sums = [np.zeros(3)], [np.zeros((3, 3))]
        for step, cov in zip(odometry, odometry_cov):
            poses.append(compose(poses[-1], step))
            carry = adjoint(poses[-1])
            sums.append(sums[-1] + carry @ np.asarray(cov) @ carry.T)

        def between_poses(a, b):
            return sums[max(a, b)] - sums[min(a, b)]

        moves, own = [], []
        for (i, j), z, cov in zip(ends, loops, loop_cov):
            moves.append(compose(compose(poses[i], z), inverse(poses[j])))
            carry = adjoint(poses[j])
            own.append(carry @ np.asarray(cov) @ carry.T)
        m = len(moves)
        distances = np.zeros((m, m))
        for p in range(m):
            for q in range(p + 1, m):
                carry = adjoint(inverse(moves[q]))
                cov = own[p] + own[q] + between_poses(ends[p][1], ends[q][1])
                cov = cov + carry @ between_poses(ends[p][0], ends[q][0]) @ carry.T
                e = log(between(moves[q], moves[p]))
                distances[p, q] = np.sqrt(e @ np.linalg.solve(cov, e))
        return distances + distances.T <= gamma


def right_matrices() -> None:
    """Right: 3 by 3 matrices of the world frame, and a complex logarithm."""

    def matrix(a):
        c, s = np.cos(a[2]), np.sin(a[2])
        return np.array([[c, -s, a[0]], [s, c, a[1]], [0, 0, 1]])

    def carried(T, cov):
        hats = [np.array([[0, -w, x], [w, 0, y], [0, 0, 0]]) for x, y, w in np.eye(3)]
        moved = [T @ hat @ np.linalg.inv(T) for hat in hats]
        carry = np.array([[hat[0, 2], hat[1, 2], hat[1, 0]] for hat in moved]).T
        return carry @ np.asarray(cov) @ carry.T

    def log(T):
        angle = np.arctan2(T[1, 0], T[0, 0])
        bend = 1.0 if abs(angle) < 1e-9 else 1j * angle / np.expm1(1j * angle)
        place = bend * (T[0, 2] + 1j * T[1, 2])
        return np.array([place.real, place.imag, angle])

    def pairwise_consistent(odometry, odometry_cov, ends, loops, loop_cov, gamma):
        poses, sums = [np.eye(3)], [np.zeros((3, 3))]
        for step, cov in zip(odometry, odometry_cov):
            poses.append(poses[-1] @ matrix(step))
            sums.append(sums[-1] + carried(poses[-1], cov))
        moves = [poses[i] @ matrix(z) @ np.linalg.inv(poses[j]) for (i, j), z in zip(ends, loops)]
        own = [carried(poses[j], cov) for (_, j), cov in zip(ends, loop_cov)]

        def distance(p, q):
            (i_p, j_p), (i_q, j_q) = ends[p], ends[q]
            back = np.linalg.inv(moves[q])
            cov = own[p] + own[q] + sums[max(j_p, j_q)] - sums[min(j_p, j_q)]
            cov = cov + carried(back, sums[max(i_p, i_q)] - sums[min(i_p, i_q)])
            e = log(back @ moves[p])
            return np.sqrt(e @ np.linalg.solve(cov, e))

        m = range(len(moves))
        return np.array(
            [[p == q or distance(min(p, q), max(p, q)) <= gamma for q in m] for p in m]
        )


wrong_order_of_the_cycle = change(
    right_plain,
    """
    here = follow(z[p], walk(ends[p][1], ends[q][1]))
    here = follow(here, undo(z[q]))
    """,
    "here = follow(follow(z[p], undo(z[q])), walk(ends[p][1], ends[q][1]))",
    stopped_by="pairwise_consistent-lever",
)
"""Wrong: goes back along the second closure before the odometry has led to its end."""

wrong_square = change(right_plain, "np.sqrt(e", "(e", stopped_by="pairwise_consistent-by-hand")
"""Wrong: compares the square of the distance with gamma, which is a threshold on the distance."""

wrong_squared_threshold = change(
    right_plain, "<= gamma", "<= gamma**2", stopped_by="pairwise_consistent-by-hand"
)
"""Wrong: squares gamma, and compares the distance with χ²."""

wrong_no_transport = change(
    right_plain,
    ("back @ a[1] @ back.T", "a[1]"),
    ("carry @ a[1] @ carry.T", "a[1]"),
    stopped_by="pairwise_consistent-lever",
)
"""Wrong: adds the covariances up as they are, each in a frame of its own."""

wrong_rotation_only = change(
    right_plain, "a[1]], [s, c, -a", "0], [s, c, 0 * a", stopped_by="pairwise_consistent-lever"
)
"""Wrong: turns the covariances into one direction, but leaves the lever arms out."""

wrong_adjoint_the_other_way = change(
    right_plain, "inverse(b[0])", "b[0]", stopped_by="pairwise_consistent-lever"
)
"""Wrong: carries a covariance past a pose with its adjoint, where the inverse belongs."""

wrong_transposed = change(
    right_plain,
    ("back @ a[1] @ back.T", "back.T @ a[1] @ back"),
    ("carry @ a[1] @ carry.T", "carry.T @ a[1] @ carry"),
    stopped_by="pairwise_consistent-lever",
)
"""Wrong: Adᵀ Σ Ad in place of Ad Σ Adᵀ."""

wrong_lever_arms = change(
    right_plain, "a[1]], [s, c, -a", "-a[1]], [s, c, a", stopped_by="pairwise_consistent-lever"
)
"""Wrong: the lever arms in the adjoint have their signs changed."""

wrong_inverse_keeps_its_covariance = change(
    right_plain, "carry @ a[1] @ carry.T", "a[1]", caught_by="pairwise_consistent-lever"
)
"""Wrong: an inverse has the covariance of the pose itself, not carried to its other end."""

wrong_exact_odometry = change(
    right_plain, "(odometry_cov[k])", "(np.zeros((3, 3)))", caught_by="pairwise_consistent-lever"
)
"""Wrong: the odometry between the ends counts as exact."""

wrong_only_the_translation = change(
    right_plain,
    "e @ np.linalg.inv(here[1]) @ e",
    "e[:2] @ np.linalg.inv(here[1][:2, :2]) @ e[:2]",
    caught_by="pairwise_consistent-lever",
)
"""Wrong: compares the positions alone, and lets the angles disagree."""

wrong_only_variances = change(
    right_plain, "inv(here[1])", "inv(here[1] * np.eye(3))", caught_by="pairwise_consistent-lever"
)
"""Wrong: divides by the variances alone, as if the coordinates of the error were independent."""

wrong_not_wrapped = change(
    right_plain, "h = 1.0", "angle = a[2]\nh = 1.0", stopped_by="pairwise_consistent-turns"
)
"""Wrong: the angle is not brought into (-π, π], so that a whole turn is a large error."""

wrong_no_logarithm = change(
    right_plain, "x, y = a[:2]", "return [*a[:2], angle]", caught_by="pairwise_consistent-turns"
)
"""Wrong: takes [x, y, θ] itself, wrapped, for its logarithm."""

wrong_bend = change(
    right_plain, ("x + a", "x - a"), ("y - a", "y + a"), caught_by="pairwise_consistent-turns"
)
"""Wrong: the logarithm bends the translation to the other side."""

wrong_never_backwards = change(
    right_plain, "undo(walk(b, a))", "walk(b, a)", stopped_by="pairwise_consistent-directions"
)
"""Wrong: the odometry between two poses is always taken forwards."""

wrong_one_step_late = change(
    right_plain,
    "range(a, b)",
    "range(a + 1, min(b + 1, len(odometry)))",
    stopped_by="pairwise_consistent-lever",
)
"""Wrong: the way from a to b takes the steps a + 1 to b, one too late, while there are any."""

wrong_noise_on_the_left = change(
    right_plain,
    ("back = adjoint(inverse(b[0]))", "back = adjoint(a[0])"),
    ("back @ a[1] @ back.T + b[1]", "a[1] + back @ b[1] @ back.T"),
    ("carry = adjoint(a[0])", "carry = adjoint(inverse(a[0]))"),
    stopped_by="pairwise_consistent-lever",
)
"""Wrong: takes the covariances for those of a motion on the left, before the measurement."""

wrong_half_a_matrix = change(
    right_plain, "= consistent[q, p] =", "=", stopped_by="pairwise_consistent-by-hand"
)
"""Wrong: fills the matrix above its diagonal alone."""

wrong_ends_sorted = change(
    right_plain,
    "consistent = np",
    "ends = np.sort(ends, axis=1)\nconsistent = np",
    stopped_by="pairwise_consistent-directions",
)
"""Wrong: sorts the ends of every closure, though some point back."""

wrong_mean_of_the_covariances = change(
    right_plain, "here[1]", "here[1] / 4", stopped_by="pairwise_consistent-by-hand"
)
"""Wrong: scales the covariance down to the mean of its four parts."""
