"""Positive definite matrices in place of information matrices that are not.

Source: Higham 1988, "Computing a nearest symmetric positive semidefinite matrix", Theorem
2.1; Rosen et al. 2019, the appendix on concentration parameters, for one precision of each kind.
"""

from __future__ import annotations

from typing import Literal, TypeAlias

import numpy as np

from robust_slam._arrays import Array, Mask

Repair: TypeAlias = Literal["nearest", "isotropic"]
_FLOOR = 1e-6
"""The smallest eigenvalue relative to the largest one of the position or the rotation."""


def definite(information: Array, repair: Repair) -> tuple[Array, Mask]:
    """Return positive definite matrices ``(k, D, D)``, and which could not be repaired.

    ``information`` ``(k, D, D)`` is symmetric; D is 3 in the plane and 6 in space. "nearest"
    replaces eigenvalues below a floor by it: in the Frobenius norm no matrix with such
    eigenvalues is nearer. Position and rotation have different units, so each is scaled by
    its largest diagonal entry first. "isotropic" takes one precision for the position and one
    for the rotation, the harmonic mean of the positive eigenvalues of each block. A matrix
    cannot be repaired if its block of positions or of rotations has no positive eigenvalue.

    >>> matrix = np.diag([4.0, -1.0, 9.0])[None]
    >>> definite(matrix, "isotropic")[0][0].diagonal().tolist()
    [4.0, 4.0, 9.0]
    """
    d = 2 if information.shape[-1] == 3 else 3
    blocks = information[:, :d, :d], information[:, d:, d:]
    spectra = [np.linalg.eigvalsh(block) for block in blocks]
    empty = np.any([spectrum[:, -1] <= 0.0 for spectrum in spectra], axis=0)
    repaired = np.broadcast_to(np.eye(information.shape[-1]), information.shape).copy()
    good = ~empty
    nearest, sizes = repair == "nearest", [d, information.shape[-1] - d]
    scales = [s[good, -1] if nearest else _harmonic_means(s[good]) for s in spectra]
    scale = np.repeat(np.stack(scales, axis=1), sizes, axis=1)
    if nearest:
        repaired[good] = _nearest(information[good], np.sqrt(scale))
    else:
        repaired[good] = scale[:, :, None] * np.eye(information.shape[-1])
    return repaired, np.asarray(empty, dtype=np.bool_)


def _nearest(information: Array, unit: Array) -> Array:
    """Return the nearest matrices after a scaling by ``unit`` ``(k, D)``."""
    scaled = information / (unit[:, :, None] * unit[:, None, :])
    values, vectors = np.linalg.eigh(scaled)
    floor = _FLOOR * values[:, -1:]
    near = (vectors * np.maximum(values, floor)[:, None, :]) @ np.swapaxes(vectors, 1, 2)
    back = near * (unit[:, :, None] * unit[:, None, :])
    return np.asarray(0.5 * (back + np.swapaxes(back, 1, 2)))


def _harmonic_means(spectrum: Array) -> Array:
    """Return the harmonic mean ``(k,)`` of the positive eigenvalues ``(k, b)``."""
    used = spectrum > _FLOOR * spectrum[:, -1:]
    inverse = np.where(used, 1.0 / np.where(used, spectrum, 1.0), 0.0)
    return np.asarray(used.sum(axis=1) / inverse.sum(axis=1))
