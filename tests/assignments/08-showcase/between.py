"""Answers to exercise between of 08-showcase: each body is a cell as handed in."""

from robust_slam_autograder.lint.answers import change


def right_complex() -> None:
    """Right: a position as a complex number, which is turned by a complex phase."""
    import numpy as np

    def between(a, b):
        a, b = np.asarray(a, dtype=float), np.asarray(b, dtype=float)
        gap = ((b - a)[..., 0] + 1j * (b - a)[..., 1]) * np.exp(-1j * a[..., 2])
        angle = np.angle(np.exp(1j * (b - a)[..., 2]))
        return np.stack([gap.real, gap.imag, angle], axis=-1)


def right_matrices() -> None:
    """Right, a library routine: solves with 3×3 matrices, pose by pose, and reads off the pose."""
    import numpy as np

    def between(a, b):
        def matrix(pose):
            x, y, angle = pose
            c, s = np.cos(angle), np.sin(angle)
            return np.array([[c, -s, x], [s, c, y], [0, 0, 1]])

        rows = []
        for one, two in zip(np.atleast_2d(a), np.atleast_2d(b)):
            m = np.linalg.solve(matrix(one), matrix(two))
            rows.append([m[0, 2], m[1, 2], np.arctan2(m[1, 0], m[0, 0])])
        return rows if np.ndim(a) == 2 else rows[0]


def right_remainder() -> None:
    """Right, an equivalent form: takes the whole turns out by a remainder, math for one pose."""
    import math

    def between(a, b):
        if hasattr(a[0], "__len__"):
            return [between(one, two) for one, two in zip(a, b)]
        x, y = b[0] - a[0], b[1] - a[1]
        c, s = math.cos(a[2]), math.sin(a[2])
        return [c * x + s * y, c * y - s * x, math.remainder(b[2] - a[2], 2 * math.pi)]


def right_inverse_then_compose() -> None:
    """Right: the inverse first, then the composition, as it is written."""
    import numpy as np

    def between(a, b):
        def turned(angle, v):
            c, s = np.cos(angle), np.sin(angle)
            return np.stack([c * v[..., 0] - s * v[..., 1], s * v[..., 0] + c * v[..., 1]], -1)

        a, b = np.array(a, dtype=float), np.array(b, dtype=float)
        back = -turned(-a[..., 2], a[..., :2])
        place = back + turned(-a[..., 2], b[..., :2])
        angle = (b[..., 2] - a[..., 2] + np.pi) % (2 * np.pi) - np.pi
        return np.concatenate([place, angle[..., None]], axis=-1)


wrong_no_wrap = change(
    right_complex,
    "angle = np.angle(np.exp(1j * (b - a)[..., 2]))",
    "angle = (b - a)[..., 2]",
    stopped_by="between-wrap",
)
"""Wrong: the difference of the angles with its whole turns."""

wrong_one_turn_only = change(
    right_complex,
    "angle = np.angle(np.exp(1j * (b - a)[..., 2]))",
    """
    angle = (b - a)[..., 2]
    angle = np.where(angle > np.pi, angle - 2 * np.pi, angle)
    angle = np.where(angle <= -np.pi, angle + 2 * np.pi, angle)
    """,
    caught_by="between-wrap",
)
"""Wrong: takes out one turn at most, so that angles of several turns keep some."""

wrong_swapped = change(
    right_complex,
    "a, b = np.asarray(a, dtype=float), np.asarray(b, dtype=float)",
    "a, b = np.asarray(b, dtype=float), np.asarray(a, dtype=float)",
    stopped_by="between-by-hand",
)
"""Wrong: the inverse of the other pose, a as seen from b."""

wrong_turned_forth = change(right_complex, "-1j", "1j", stopped_by="between-by-hand")
"""Wrong: turns the difference by the angle of a, not back by it."""

wrong_first_angle_for_all = change(
    right_complex, ".exp(-1j * a[..., 2])", ".exp(-1j * np.ravel(a)[2])", caught_by="between-rows"
)
"""Wrong: turns all rows by the angle of the first."""

wrong_whole_numbers = change(
    right_complex,
    ("= np.asarray(a, dtype=float), np.asarray(b, dtype=float)", "= np.asarray(a), np.asarray(b)"),
    ("angle], axis=-1)", "angle], axis=-1).astype((b - a).dtype)"),
    caught_by="between-lists",
)
"""Wrong: integers in, integers out, so the position is cut off."""

wrong_two_turns_only = change(
    right_complex,
    "angle = np.angle(np.exp(1j * (b - a)[..., 2]))",
    """
    angle = (b - a)[..., 2]
    for _ in range(3):
        angle = np.where(angle > np.pi, angle - 2 * np.pi, angle)
        angle = np.where(angle <= -np.pi, angle + 2 * np.pi, angle)
    """,
    caught_by="between-wrap",
)
"""Wrong: takes out two turns at most."""
