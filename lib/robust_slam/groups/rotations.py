"""Rotation matrices: their check, and projections onto them and onto the Stiefel manifold.

Source: Umeyama 1991, the lemma on the nearest rotation; Absil, Mahony and Sepulchre 2008, the
polar factor.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from robust_slam._arrays import Array, refuse

_ORTHOGONALITY = 1e-6
"""The largest accepted entry of |R Rᵀ − I|; rounding stays far below."""


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
    refuse(
        invalid,
        lambda k: (
            f"{told} {k} is not a rotation matrix; its columns must be orthonormal and its "
            "determinant 1"
        ),
    )


def nearest_stiefel(matrices: ArrayLike) -> Array:
    """Return the matrices ``(…, r, d)`` of orthonormal columns nearest to ``matrices``."""
    left, _, right = np.linalg.svd(np.asarray(matrices, dtype=np.float64), full_matrices=False)
    return np.asarray(left @ right)
