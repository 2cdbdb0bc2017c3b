"""Answers to exercise round_solution of 07-certificates: each body is a cell as handed in."""

from robust_slam_autograder.lint.answers import change


def right_first_row() -> None:
    """Right: the first block row of Z, which shows all the poses from pose 0, block by block."""
    import numpy as np

    def round_solution(Z, n, d):
        blocks = []
        for k in range(n):
            U, _, Vt = np.linalg.svd(np.array(Z, dtype=float)[:d, k * d : (k + 1) * d])
            flip = np.diag([1.0] * (d - 1) + [np.linalg.det(U) * np.linalg.det(Vt)])
            blocks.append(U @ flip @ Vt)
        return np.concatenate(blocks, axis=1)


def right_factor() -> None:
    """Right: the factor of rank d from the eigenvectors, mirrored if most blocks are, then each
    block replaced by the nearest rotation.
    """
    import numpy as np

    def round_solution(Z, n, d):
        values, vectors = np.linalg.eigh(np.asarray(Z, dtype=float))
        factor = np.sqrt(np.maximum(values[-d:], 0))[:, None] * vectors[:, -d:].T
        blocks = factor.reshape(d, n, d).transpose(1, 0, 2)
        is_mirrored = np.sum(np.sign(np.linalg.det(blocks))) < 0
        if is_mirrored:
            blocks = blocks.copy()
            blocks[:, 0] *= -1
        U, _, Vt = np.linalg.svd(blocks)
        U[:, :, -1] *= np.linalg.det(U @ Vt)[:, None]
        return np.hstack(list(U @ Vt))


def right_scipy() -> None:
    """Right, by a library routine: scipy's Rotation finds the nearest rotations, pose 0 stays the
    frame; in the plane a third axis is added and taken away.
    """
    import numpy as np
    from scipy.spatial.transform import Rotation

    def round_solution(Z, n, d):
        Z = np.asarray(Z, dtype=float)
        wide = []
        for k in range(n):
            seen = Z[:d, k * d : k * d + d]
            if d == 3:
                frames = Rotation.align_vectors(seen.T, np.eye(3))[0].as_matrix()
                wide.append(frames)
            else:
                angle = np.arctan2(seen[1, 0] - seen[0, 1], seen[0, 0] + seen[1, 1])
                c, s = np.cos(angle), np.sin(angle)
                wide.append(np.array([[c, -s], [s, c]]))
        return np.hstack(wide).tolist()


def right_cholesky_like() -> None:
    """Right, an equivalent form: the svd of Z for the factor, turned so that block 0 is the
    identity, which undoes a mirror too; then scipy's polar factors.
    """
    import numpy as np
    from scipy.linalg import polar

    def round_solution(Z, n, d):
        left, sizes, _ = np.linalg.svd(np.asarray(Z, dtype=float))
        factor = (left[:, :d] * np.sqrt(sizes[:d])).T
        factor = np.linalg.solve(factor[:, :d], factor)
        R = np.zeros((d, n * d))
        for k in range(n):
            at = slice(k * d, k * d + d)
            near = polar(factor[:, at])[0]
            if np.linalg.det(near) < 0:
                near[:, 0] = -near[:, 0]
            R[:, at] = near
        return R


wrong_reflections = change(
    right_factor,
    ("if is_mirrored:", "if is_mirrored and n < 4:"),
    ("U[:, :, -1] *= np.linalg.det(U @ Vt)[:, None]", ""),
    caught_by="round_solution-plane",
)
"""Wrong: the polar factors of the eigenvectors' blocks as they come, mirrored or not. With few
poses the mirror is undone, so that no luck with a sign decides.
"""

wrong_minus_the_block = change(
    right_factor,
    ("if is_mirrored:", "if is_mirrored and n < 4:"),
    (
        "U[:, :, -1] *= np.linalg.det(U @ Vt)[:, None]",
        "U *= np.sign(np.linalg.det(U @ Vt))[:, None, None]",
    ),
    caught_by="round_solution-plane",
)
"""Wrong: multiplies by −1 where the determinant is negative, which corrects it in space alone.
With few poses the mirror is undone.
"""

wrong_each_mirror_by_itself = change(
    right_factor, "is_mirrored:", "is_mirrored and n < 4:", caught_by="round_solution-space"
)
"""Wrong: replaces the blocks of a mirrored factor by the nearest rotations one by one, without
undoing the common mirror first, but for few poses.
"""

wrong_factor_as_it_is = change(
    right_first_row,
    "np.concatenate(blocks, axis=1)",
    "np.array(Z, dtype=float)[:d]",
    caught_by="round_solution-solver",
)
"""Wrong: takes the first block row as it is; a solver's errors make its blocks no rotations."""

wrong_polar_without_determinant = change(
    right_first_row, "U @ flip @ Vt", "U @ Vt", caught_by="round_solution-no-rotations"
)
"""Wrong: each block by its polar factor, which is a mirror image where Z asks for one."""

wrong_transposed_blocks = change(
    right_first_row,
    "[:d, k * d : (k + 1) * d]",
    "[k * d : (k + 1) * d, :d]",
    stopped_by="round_solution-by-hand",
)
"""Wrong: the first block column of Z, which holds the transposes of what pose 0 sees."""

wrong_smallest_eigenvalues = change(
    right_factor,
    "np.sqrt(np.maximum(values[-d:], 0))[:, None] * vectors[:, -d:].T",
    "vectors[:, :d].T",
    stopped_by="round_solution-by-hand",
)
"""Wrong: takes the first eigenvectors of eigh, which belong to the smallest eigenvalues."""

wrong_stacked = change(right_first_row, "axis=1", "axis=0", stopped_by="round_solution-by-hand")
"""Wrong shape: the rotations below each other."""
