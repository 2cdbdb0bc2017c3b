"""The text formats of TORO and of PyFactorGraph: what their lines mean.

**TORO**: ``VERTEX2 id x y θ``; ``EDGE2 i j x y θ`` and 6 numbers of information in an order of
its own, I_xx I_xy I_yy I_θθ I_xθ I_yθ; ``VERTEX3 id x y z roll pitch yaw``; ``EDGE3 i j x y z
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

**PyFactorGraph** (``.pyfg``): the lines of g2o with a time (s) behind the tag, and with 6 or 21
numbers of covariance, not of information, in the order of g2o. The vertices are the true poses
where the file is a simulation. An id is a letter, which names the robot, and a number: A7. As a
whole number it is GTSAM's key, letter · 2⁵⁶ + number. Priors, landmarks and ranges are refused
or, on demand, skipped.

Source: Grisetti et al. 2007, "A tree parameterisation for efficiently computing maximum
likelihood maps using gradient descent", and the page of its program TORO; the module
``pyfg_text`` of the program PyFactorGraph.
"""

import re
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from robust_slam._arrays import Array, Ids
from robust_slam.files.g2o import PLANE, SPACE
from robust_slam.files.graph_file import Names
from robust_slam.files.lines import Rows
from robust_slam.files.matrices import row_by_row, symmetric
from robust_slam.files.tagged import Format, Layout, poses_of

BITS = 56
"""Behind these bits of a key is the letter of a robot."""
_ID = re.compile(r"[A-Za-z][0-9]{1,16}", re.ASCII)
_ROWS, _COLUMNS = np.array([0, 0, 1, 2, 0, 1]), np.array([0, 1, 1, 2, 2, 2])


def _poses_of(rows: Rows) -> Array:
    """Return the poses ``(k, 3, 4)`` of lines that begin with x y z roll pitch yaw."""
    # Rotations about the fixed axes x, then y, then z are R_z R_y R_x.
    turns = Rotation.from_euler("xyz", rows.numbers[:, 3:6]).as_quat()
    return poses_of(Rows(rows.line, rows.ids, np.column_stack([rows.numbers[:, :3], turns])))


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
    Layout("VERTEX2", "EDGE2", 3, 3, matrices=_matrices, angles=(2,)),
    Layout("VERTEX3", "EDGE3", 6, 6, _poses_of, angles=(3, 4, 5)),
    passed=("EQUIV",),
)
"""What the lines of a TORO file mean."""


def read_id(field: str) -> int | None:
    """Return the key of an id such as A7, or None where the field is not one."""
    return (ord(field[0]) << BITS) + int(field[1:]) if _ID.fullmatch(field) else None


def _names(ids: Ids) -> Names:
    words = [f"{chr(key >> BITS)}{key & (2**BITS - 1)}" for key in ids.ravel().tolist()]
    return np.array(words).reshape(ids.shape)


PYFG = Format(
    replace(PLANE, covariance=True, as_edge=()),
    replace(SPACE, covariance=True, as_edge=()),
    stamps=1,
    read_id=read_id,
    ids_are="a letter and a number, such as A7",
    names=_names,
    robots=lambda ids: np.asarray(ids >> BITS),
)
"""What the lines of a .pyfg file mean."""
