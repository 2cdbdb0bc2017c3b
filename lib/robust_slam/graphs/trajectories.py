"""Poses as text files that other tools read: TUM's and KITTI's formats.

TUM: one line ``time x y z qx qy qz qw`` a pose. KITTI: the twelve entries of [R | t], row by
row, a line a pose. Metres. Poses in the plane are written with z = 0.

Source: Sturm et al. 2012, "A benchmark for the evaluation of RGB-D SLAM systems"; Geiger et
al. 2012, "Are we ready for autonomous driving?".
"""

from __future__ import annotations

import os
from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from robust_slam._arrays import Array, finite
from robust_slam._files import write_lines
from robust_slam.graphs import se2


def write_tum(
    path: str | os.PathLike[str], poses: ArrayLike, times: ArrayLike | None = None
) -> None:
    """Write poses in TUM's format, as the tool evo reads it.

    ``poses`` are ``(n, 3)`` or ``(n, 3, 4)``; their ``times`` ``(n,)`` (s) are by default 0, 1,
    2, …. The file is written at once or not at all.

    Raises:
        TypeError: ``poses`` are not numbers, for instance a graph.
        ValueError: the shape does not fit, or an entry is not finite.
        OSError: the file cannot be written.

    Source: Sturm et al. 2012.
    """
    matrices = _in_space(poses)
    given = np.arange(len(matrices)) if times is None else times
    stamps = finite("times", given, (len(matrices),))
    # A copy, since SciPy 1.14 takes no array that is only to be read.
    turns = Rotation.from_matrix(matrices[:, :, :3].copy())
    quaternions = np.asarray(turns.as_quat(canonical=True))
    write_lines(path, _rows(np.column_stack([stamps, matrices[:, :, 3], quaternions])))


def write_kitti(path: str | os.PathLike[str], poses: ArrayLike) -> None:
    """Write poses ``(n, 3)`` or ``(n, 3, 4)`` in KITTI's format, [R | t] row by row.

    The file is written at once or not at all.

    Raises:
        ValueError: the shape does not fit, or an entry is not finite.
        OSError: the file cannot be written.

    Source: Geiger et al. 2012.
    """
    write_lines(path, _rows(_in_space(poses).reshape(-1, 12)))


def _in_space(poses: ArrayLike) -> Array:
    """Return poses as ``(n, 3, 4)``; those in the plane turn about z."""
    if np.ndim(poses) == 3:
        return finite("poses", poses, (-1, 3, 4))
    plane = finite("poses", poses, (-1, 3))
    matrices = np.zeros((len(plane), 3, 4))
    matrices[:, :2, :2] = se2.rotation(plane)
    matrices[:, 2, 2] = 1.0
    matrices[:, :2, 3] = plane[:, :2]
    return matrices


def _rows(numbers: Array) -> Iterator[str]:
    for row in numbers.tolist():
        yield " ".join(map(repr, row)) + "\n"
