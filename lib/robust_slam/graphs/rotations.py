"""Projections of matrices onto rotations and onto the Stiefel manifold."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from robust_slam._arrays import Array


def nearest_rotations(matrices: ArrayLike) -> Array:
    """Return the rotations ``(…, d, d)`` nearest to ``matrices`` in Frobenius norm.

    Source: Umeyama 1991, the lemma on the nearest rotation.
    """
    left, _, right = np.linalg.svd(np.asarray(matrices, dtype=np.float64))
    left[..., -1] *= np.sign(np.linalg.det(left) * np.linalg.det(right))[..., None]
    return np.asarray(left @ right)


def nearest_stiefel(matrices: ArrayLike) -> Array:
    """Return the matrices ``(…, r, d)`` of orthonormal columns nearest to ``matrices``.

    Source: Absil, Mahony and Sepulchre 2008, the polar factor.
    """
    left, _, right = np.linalg.svd(np.asarray(matrices, dtype=np.float64), full_matrices=False)
    return np.asarray(left @ right)
