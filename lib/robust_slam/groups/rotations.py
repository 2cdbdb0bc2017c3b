"""Rotation matrices: their check, projections onto them, and quaternions (x, y, z, w) of them.

A quaternion of any length but 0 represents a rotation. It is rounded to a grid of 2⁻⁵⁰ that can be
recovered from the rotation matrix, so a graph that was read and written is read again with the
same numbers. Other rotation matrices are recovered within 3e-15 once, and exactly from then on.

Source: Umeyama 1991, the lemma on the nearest rotation; Absil, Mahony and Sepulchre 2008, the
polar factor; the grid is derived here.
"""

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from robust_slam._arrays import Array, refuse

_ORTHOGONALITY = 1e-6
"""The largest accepted entry of |R Rᵀ − I|; rounding stays far below."""
_STEP = 2.0**-50
"""The grid of quaternions: rounding in a rotation matrix stays below half a step."""
_COARSE = 2.0**20


def nearest_rotations(matrices: ArrayLike) -> Array:
    """Return the rotations ``(…, d, d)`` nearest to ``matrices`` in Frobenius norm."""
    left, _, right = np.linalg.svd(np.asarray(matrices, dtype=np.float64))
    left[..., -1] *= np.sign(np.linalg.det(left) * np.linalg.det(right))[..., None]
    return np.asarray(left @ right)


def check_rotations(told: str, matrices: Array) -> None:
    """Refuse, by a ValueError about ``told``, ``matrices`` ``(m, d, d)`` that are no rotations."""
    gap = np.abs(matrices @ np.swapaxes(matrices, 1, 2) - np.eye(matrices.shape[-1]))
    invalid = gap.max(axis=(1, 2), initial=0.0) > _ORTHOGONALITY
    invalid |= np.linalg.det(matrices) < 0.0
    must = "its columns must be orthonormal and its determinant 1"
    refuse(invalid, lambda k: f"{told} {k} is not a rotation matrix; {must}")


def nearest_stiefel(matrices: ArrayLike) -> Array:
    """Return the matrices ``(…, r, d)`` of orthonormal columns nearest to ``matrices``."""
    left, _, right = np.linalg.svd(np.asarray(matrices, dtype=np.float64), full_matrices=False)
    return np.asarray(left @ right)


def from_quaternions(quaternion: Array) -> Array:
    """Return the rotation matrices ``(k, 3, 3)`` of quaternions ``(k, 4)``."""
    # Adding 0 turns −0 into 0, so that equal matrices have equal bits.
    return np.asarray(Rotation.from_quat(quaternion).as_matrix()) + 0.0


def on_grid(quaternion: Array) -> Array:
    """Return unit quaternions ``(k, 4)`` that can be recovered from their matrices.

    The three smaller components are multiples of ``_STEP``, and rounding a matrix changes them by
    less than half of it. They determine the largest, chosen from coarsely rounded values.
    """
    # Scaling by a power of two is exact; the squares of 1e200 and 1e-200 are out of range.
    _, exponent = np.frexp(np.abs(quaternion).max(axis=1, keepdims=True))
    scaled = np.ldexp(quaternion, -exponent)
    unit = scaled / np.linalg.norm(scaled, axis=1, keepdims=True)
    top = np.argmax(np.round(_COARSE * np.abs(unit)), axis=1)[:, None]
    unit = unit * np.sign(np.take_along_axis(unit, top, axis=1))
    smaller = np.where(np.arange(4) == top, 0.0, _STEP * np.round(unit / _STEP))
    largest = np.sqrt(1.0 - np.sum(smaller**2, axis=1, keepdims=True))
    return np.where(np.arange(4) == top, largest, smaller)


def quaternions_of(matrices: Array) -> Array:
    """Return the quaternions ``(k, 4)`` of rotation matrices ``(k, 3, 3)``, on the grid."""
    # A copy, since SciPy 1.14 takes no array that is only to be read.
    return on_grid(np.asarray(Rotation.from_matrix(matrices.copy()).as_quat()))
