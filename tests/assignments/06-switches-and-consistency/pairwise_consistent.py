"""Answers to exercise pairwise_consistent of 06-switches-and-consistency: bodies of cells."""

from robust_slam_autograder.lint.answers import change


def right_plain_numpy() -> None:
    """Right: the statement's formulas, pose and covariance carried along together."""
    import numpy as np

    def compose(a, b):
        c, s = np.cos(a[2]), np.sin(a[2])
        turn = np.array([[c, -s], [s, c]])
        return np.append(a[:2] + turn @ b[:2], a[2] + b[2])

    def inverse(a):
        c, s = np.cos(a[2]), np.sin(a[2])
        return np.array([-c * a[0] - s * a[1], s * a[0] - c * a[1], -a[2]])

    def adjoint(a):
        c, s = np.cos(a[2]), np.sin(a[2])
        return np.array([[c, -s, a[1]], [s, c, -a[0]], [0, 0, 1]])

    def log(a):
        angle = np.arctan2(np.sin(a[2]), np.cos(a[2]))
        h = 1.0 if abs(angle) < 1e-9 else angle / 2 / np.tan(angle / 2)
        x, y = a[0], a[1]
        return np.array([h * x + angle / 2 * y, h * y - angle / 2 * x, angle])

    def follow(a, b):
        back = adjoint(inverse(b[0]))
        return compose(a[0], b[0]), back @ a[1] @ back.T + b[1]

    def undo(a):
        carry = adjoint(a[0])
        return inverse(a[0]), carry @ a[1] @ carry.T

    def pairwise_consistent(odometry, odometry_cov, ends, loops, loop_cov, gamma):
        odometry, odometry_cov = np.array(odometry, float), np.array(odometry_cov, float)
        loops, loop_cov = np.array(loops, float), np.array(loop_cov, float)

        def walk(a, b):
            if a > b:
                return undo(walk(b, a))
            here = np.zeros(3), np.zeros((3, 3))
            for k in range(a, b):
                here = follow(here, (odometry[k], odometry_cov[k]))
            return here

        m = len(loops)
        consistent = np.eye(m, dtype=bool)
        for q in range(m):
            for p in range(q):
                here = follow((loops[p], loop_cov[p]), walk(ends[p][1], ends[q][1]))
                here = follow(here, undo((loops[q], loop_cov[q])))
                here = follow(here, walk(ends[q][0], ends[p][0]))
                e = log(here[0])
                distance = np.sqrt(e @ np.linalg.inv(here[1]) @ e)
                consistent[p, q] = consistent[q, p] = distance <= gamma
        return consistent


def right_library_group() -> None:
    """Right: the group from the library; the parts' covariances summed at the cycle's end."""
    import numpy as np
    from robust_slam.graphs import se2

    def pairwise_consistent(odometry, odometry_cov, ends, loops, loop_cov, gamma):
        def walk(a, b):
            pose, cov = np.zeros(3), np.zeros((3, 3))
            for k in range(min(a, b), max(a, b)):
                back = se2.adjoint(se2.inverse(odometry[k]))
                pose = se2.compose(pose, odometry[k])
                cov = back @ cov @ back.T + odometry_cov[k]
            return (pose, cov) if a <= b else turned(pose, cov)

        def turned(pose, cov):
            carry = se2.adjoint(pose)
            return se2.inverse(pose), carry @ np.asarray(cov) @ carry.T

        def distance(p, q):
            parts = [
                (np.asarray(loops[p], dtype=float), np.asarray(loop_cov[p], dtype=float)),
                walk(ends[p][1], ends[q][1]),
                turned(loops[q], loop_cov[q]),
                walk(ends[q][0], ends[p][0]),
            ]
            behind, total = np.zeros(3), np.zeros((3, 3))
            for pose, cov in reversed(parts):
                back = se2.adjoint(se2.inverse(behind))
                total = total + back @ cov @ back.T
                behind = se2.compose(pose, behind)
            e = se2.log(behind)
            return np.sqrt(e @ np.linalg.solve(total, e))

        m = range(len(loops))
        return [[p == q or bool(distance(min(p, q), max(p, q)) <= gamma) for q in m] for p in m]


def right_world_frame() -> None:
    """Right, an equivalent form: every closure as a motion of the world, sums along the way."""
    import numpy as np
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


def right_matrices_differences() -> None:
    """Right: 3 by 3 matrices, a complex logarithm, and all transports by differences."""
    import numpy as np

    def hat(v):
        return np.array([[0, -v[2], v[0]], [v[2], 0, v[1]], [0, 0, 0]])

    def matrix(a):
        c, s = np.cos(a[2]), np.sin(a[2])
        return np.array([[c, -s, a[0]], [s, c, a[1]], [0, 0, 1]])

    def vee(T):
        return np.array([T[0, 2], T[1, 2], T[1, 0]])

    def log(T):
        """A motion along an arc ends at (exp(iθ) - 1)/(iθ) times its first direction."""
        angle = np.arctan2(T[1, 0], T[0, 0])
        bend = 1.0 if abs(angle) < 1e-9 else 1j * angle / np.expm1(1j * angle)
        place = bend * (T[0, 2] + 1j * T[1, 2])
        return np.array([place.real, place.imag, angle])

    tiny = 1e-6
    nudges = [(np.eye(3) + hat(tiny * v), np.eye(3) - hat(tiny * v)) for v in np.eye(3)]

    def slope(before, after):
        """How the product moves on its right when what stands between is nudged on its right."""
        whole = np.linalg.inv(before @ after)
        columns = [vee(whole @ before @ (up - down) @ after) / (2 * tiny) for up, down in nudges]
        return np.column_stack(columns)

    def pairwise_consistent(odometry, odometry_cov, ends, loops, loop_cov, gamma):
        steps = [matrix(step) for step in odometry]

        def walk(a, b):
            total, cov = np.eye(3), np.zeros((3, 3))
            for k in reversed(range(min(a, b), max(a, b))):
                J = slope(np.linalg.inv(total), total)
                cov = cov + J @ np.asarray(odometry_cov[k]) @ J.T
                total = steps[k] @ total
            return turned(total, cov) if a > b else (total, cov)

        def turned(T, cov):
            J = slope(T, np.linalg.inv(T))
            return np.linalg.inv(T), J @ np.asarray(cov) @ J.T

        m = len(loops)
        z = [(matrix(loops[p]), np.asarray(loop_cov[p], dtype=float)) for p in range(m)]
        consistent = np.eye(m, dtype=bool)
        for p in range(m):
            for q in range(p + 1, m):
                parts = [z[p], walk(ends[p][1], ends[q][1]), turned(*z[q])]
                parts.append(walk(ends[q][0], ends[p][0]))
                total, after = np.zeros((3, 3)), np.eye(3)
                for T, cov in reversed(parts):
                    J = slope(np.linalg.inv(after), after)
                    total = total + J @ cov @ J.T
                    after = T @ after
                e = log(after)
                consistent[p, q] = consistent[q, p] = (
                    np.sqrt(e @ np.linalg.solve(total, e)) <= gamma
                )
        return consistent


wrong_order_of_the_cycle = change(
    right_plain_numpy,
    """
    here = follow((loops[p], loop_cov[p]), walk(ends[p][1], ends[q][1]))
    here = follow(here, undo((loops[q], loop_cov[q])))
    """,
    """
    here = follow((loops[p], loop_cov[p]), undo((loops[q], loop_cov[q])))
    here = follow(here, walk(ends[p][1], ends[q][1]))
    """,
    stopped_by="pairwise_consistent-lever",
)
"""Wrong: goes back along the second closure before the odometry has led to its end."""

wrong_square = change(
    right_plain_numpy,
    "np.sqrt(e @ np.linalg.inv(here[1]) @ e)",
    "e @ np.linalg.inv(here[1]) @ e",
    stopped_by="pairwise_consistent-by-hand",
)
"""Wrong: compares the square of the distance with gamma, which is a threshold on the distance."""

wrong_squared_threshold = change(
    right_plain_numpy,
    "distance <= gamma",
    "distance <= gamma**2",
    stopped_by="pairwise_consistent-by-hand",
)
"""Wrong: squares gamma, as if it were a root still to be undone, and compares the distance with
χ².
"""

wrong_no_transport = change(
    right_plain_numpy,
    ("back @ a[1] @ back.T", "a[1]"),
    ("return inverse(a[0]), carry @ a[1] @ carry.T", "return inverse(a[0]), a[1]"),
    stopped_by="pairwise_consistent-lever",
)
"""Wrong: adds the covariances up as they are, each in a frame of its own."""

wrong_rotation_only = change(
    right_plain_numpy,
    "[[c, -s, a[1]], [s, c, -a[0]], [0, 0, 1]]",
    "[[c, -s, 0], [s, c, 0], [0, 0, 1]]",
    stopped_by="pairwise_consistent-lever",
)
"""Wrong: turns the covariances into one direction, but leaves the lever arms out."""

wrong_adjoint_the_other_way = change(
    right_plain_numpy, "inverse(b[0])", "b[0]", stopped_by="pairwise_consistent-lever"
)
"""Wrong: carries a covariance past a pose with its adjoint, where the inverse belongs."""

wrong_transposed = change(
    right_plain_numpy,
    ("back @ a[1] @ back.T", "back.T @ a[1] @ back"),
    ("carry @ a[1] @ carry.T", "carry.T @ a[1] @ carry"),
    stopped_by="pairwise_consistent-lever",
)
"""Wrong: Adᵀ Σ Ad in place of Ad Σ Adᵀ."""

wrong_lever_arms = change(
    right_plain_numpy,
    "[[c, -s, a[1]], [s, c, -a[0]], [0, 0, 1]]",
    "[[c, -s, -a[1]], [s, c, a[0]], [0, 0, 1]]",
    stopped_by="pairwise_consistent-lever",
)
"""Wrong: the lever arms in the adjoint have their signs changed."""

wrong_inverse_keeps_its_covariance = change(
    right_plain_numpy, "carry @ a[1] @ carry.T", "a[1]", caught_by="pairwise_consistent-lever"
)
"""Wrong: an inverse has the covariance of the pose itself, not carried to its other end."""

wrong_exact_odometry = change(
    right_plain_numpy,
    "odometry_cov[k]",
    "0 * odometry_cov[k]",
    caught_by="pairwise_consistent-lever",
)
"""Wrong: the odometry between the ends counts as exact."""

wrong_only_the_translation = change(
    right_plain_numpy,
    "e @ np.linalg.inv(here[1]) @ e",
    "e[:2] @ np.linalg.inv(here[1][:2, :2]) @ e[:2]",
    caught_by="pairwise_consistent-lever",
)
"""Wrong: compares the positions alone, and lets the angles disagree."""

wrong_only_variances = change(
    right_plain_numpy,
    "np.linalg.inv(here[1])",
    "np.diag(1 / np.diag(here[1]))",
    caught_by="pairwise_consistent-lever",
)
"""Wrong: divides by the variances alone, as if the coordinates of the error were independent."""

wrong_not_wrapped = change(
    right_plain_numpy,
    "np.arctan2(np.sin(a[2]), np.cos(a[2]))",
    "a[2]",
    stopped_by="pairwise_consistent-turns",
)
"""Wrong: the angle is not brought into (-π, π], so that a whole turn is a large error."""

wrong_no_logarithm = change(
    right_plain_numpy,
    """
    h = 1.0 if abs(angle) < 1e-9 else angle / 2 / np.tan(angle / 2)
    x, y = a[0], a[1]
    return np.array([h * x + angle / 2 * y, h * y - angle / 2 * x, angle])
    """,
    "return np.array([a[0], a[1], angle])",
    caught_by="pairwise_consistent-turns",
)
"""Wrong: takes [x, y, θ] itself, wrapped, for its logarithm."""

wrong_bend = change(
    right_plain_numpy,
    "[h * x + angle / 2 * y, h * y - angle / 2 * x, angle]",
    "[h * x - angle / 2 * y, h * y + angle / 2 * x, angle]",
    caught_by="pairwise_consistent-turns",
)
"""Wrong: the logarithm bends the translation to the other side."""

wrong_never_backwards = change(
    right_plain_numpy,
    "undo(walk(b, a))",
    "walk(b, a)",
    stopped_by="pairwise_consistent-directions",
)
"""Wrong: the odometry between two poses is always taken forwards."""

wrong_one_step_late = change(
    right_plain_numpy,
    "range(a, b)",
    "range(a + 1, min(b + 1, len(odometry)))",
    stopped_by="pairwise_consistent-lever",
)
"""Wrong: the way from a to b takes the steps a + 1 to b, one too late, while there are any."""

wrong_noise_on_the_left = change(
    right_plain_numpy,
    (
        """
        back = adjoint(inverse(b[0]))
        return compose(a[0], b[0]), back @ a[1] @ back.T + b[1]
        """,
        "return compose(a[0], b[0]), a[1] + adjoint(a[0]) @ b[1] @ adjoint(a[0]).T",
    ),
    ("carry = adjoint(a[0])", "carry = adjoint(inverse(a[0]))"),
    stopped_by="pairwise_consistent-lever",
)
"""Wrong: takes the covariances for those of a motion on the left, before the measurement."""

wrong_half_a_matrix = change(
    right_plain_numpy,
    "consistent[p, q] = consistent[q, p] = distance <= gamma",
    "consistent[p, q] = distance <= gamma",
    stopped_by="pairwise_consistent-by-hand",
)
"""Wrong: fills the matrix above its diagonal alone."""

wrong_ends_sorted = change(
    right_plain_numpy,
    "m = len(loops)",
    "ends = np.sort(ends, axis=1)\nm = len(loops)",
    stopped_by="pairwise_consistent-directions",
)
"""Wrong: sorts the ends of every closure, though some point back."""

wrong_mean_of_the_covariances = change(
    right_plain_numpy, "here[1]", "here[1] / 4", stopped_by="pairwise_consistent-by-hand"
)
"""Wrong: scales the covariance down to the mean of its four parts."""
