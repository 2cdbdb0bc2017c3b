"""Pose graphs in TORO's text format.

Tags: ``VERTEX2 id x y θ``; ``EDGE2 i j x y θ`` and 6 numbers of information in TORO's own
order, I_xx I_xy I_yy I_θθ I_xθ I_yθ; ``VERTEX3 id x y z roll pitch yaw``; ``EDGE3 i j x y z
roll pitch yaw`` and 21 numbers, the upper triangle, row by row, in the order of the pose.
Metres and radians. An edge ``i j`` measures pose j in the frame of pose i. The rotation is
R = R_z(yaw) R_y(pitch) R_x(roll). TORO weighs the three angles of a residual, which for a small
one are its rotation vector, so the matrix needs no conversion. Lines ``EQUIV i j`` are
skipped: they mark an edge that is there.

Many files with the tag EDGE2 write the upper triangle row by row, as g2o does. A file whose
matrices are all positive definite in that order, but not in TORO's, is read row by row, and a
remark says so. GTSAM's ``load2D`` goes by the zeros of the matrix, and takes the
numbers for a covariance unless told ``NoiseFormatTORO``; its ``load3D`` leaves the order of the
21 numbers as it is, though GTSAM has the rotation first.

Source: Grisetti et al. 2007, "A tree parameterisation for efficiently computing maximum
likelihood maps using gradient descent", and the page of its program TORO for the format.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from robust_slam._arrays import Array
from robust_slam.graphs import quaternions, se3
from robust_slam.graphs.lines import Rows
from robust_slam.graphs.matrices import row_by_row, symmetric
from robust_slam.graphs.tagged import Format, Layout

_ROWS, _COLUMNS = np.array([0, 0, 1, 2, 0, 1]), np.array([0, 1, 1, 2, 2, 2])


def _poses_of(rows: Rows) -> Array:
    """Return the poses ``(k, 3, 4)`` of lines that begin with x y z roll pitch yaw."""
    # Rotations about the fixed axes x, then y, then z are R_z R_y R_x.
    turn = Rotation.from_euler("xyz", rows.numbers[:, 3:6]).as_quat()
    matrices = quaternions.matrices(quaternions.on_grid(np.asarray(turn)))
    return se3.from_parts(matrices, rows.numbers[:, :3])


def _matrices(numbers: Array, dof: int) -> tuple[Array, tuple[str, ...]]:
    """Return information matrices ``(k, 3, 3)`` in TORO's order, or else in g2o's."""
    ours, _ = row_by_row(numbers, dof)
    theirs = symmetric(numbers, _ROWS, _COLUMNS)
    if _all_definite(theirs) or not _all_definite(ours):
        return theirs, ()
    return ours, (
        "the matrices of the EDGE2 lines are read row by row, as in g2o: in TORO's order they "
        "are not positive definite",
    )


def _all_definite(matrices: Array) -> bool:
    return bool(np.all(np.linalg.eigvalsh(matrices)[:, 0] > 0.0))


TORO = Format(
    Layout("VERTEX2", "EDGE2", 3, 3, lambda rows: rows.numbers[:, :3], _matrices, angles=(2,)),
    Layout("VERTEX3", "EDGE3", 6, 6, _poses_of, angles=(3, 4, 5)),
    passed=("EQUIV",),
)
"""What the lines of a TORO file mean."""
