"""Information matrices from the numbers of a file: whole, and fit to be used.

Source: Higham 1988, Theorem 2.1, and Rosen et al. 2019, the appendix on concentration parameters,
for what replaces a matrix; the tests of it are derived here.
"""

from collections.abc import Callable
from typing import Literal, TypeAlias

import numpy as np

from robust_slam._arrays import Array, Indices, Mask
from robust_slam.files.graph_file import Names
from robust_slam.files.lines import LARGEST, Rows
from robust_slam.graphs.pose_graph import out_of_range

Repair: TypeAlias = Literal["nearest", "isotropic"]
Indefinite: TypeAlias = Literal["raise"] | Repair
_FLOOR = 1e-6
"""The smallest eigenvalue of a repaired matrix, relative to the largest of its kind."""
_SINGULAR = 1e-14
"""The smallest eigenvalue of a matrix with a diagonal of 1 that rounding does not make."""
_UNEVEN = 1e12
"""Information that differs by this factor, a million in deviations, is hardly meant."""


def row_by_row(numbers: Array, dof: int) -> tuple[Array, tuple[str, ...]]:
    """Return matrices ``(k, D, D)`` from their upper triangles, each row by row."""
    return symmetric(numbers, *np.triu_indices(dof)), ()


def symmetric(numbers: Array, rows: Indices, columns: Indices) -> Array:
    """Return symmetric matrices ``(k, D, D)`` with ``numbers`` ``(k, t)`` at these places."""
    dof = int(rows.max()) + 1
    matrices = np.empty((len(numbers), dof, dof))
    matrices[:, rows, columns] = numbers
    matrices[:, columns, rows] = numbers
    return matrices


def information_of(
    rows: Rows, given: Array, covariance: bool, indefinite: Indefinite
) -> tuple[Array, Indices]:
    """Return the information ``(k, D, D)`` of edges, and those whose matrix was replaced.

    ``given`` ``(k, D, D)`` is the information of ``rows`` or, with ``covariance``, its inverse;
    ``indefinite`` is that of ``read``. A Fault names a line whose matrix cannot be used.
    """
    kind = "covariance" if covariance else "information"
    spectrum: Array = np.asarray(np.linalg.eigvalsh(given))
    words = "matrix has an eigenvalue outside 1e-30 to 1e30; give metres and radians"
    rows.refuse(out_of_range(spectrum, LARGEST), f"the {kind} {words}")
    weak = _weak(given, spectrum, covariance)
    if indefinite == "raise":
        rows.refuse(
            weak,
            f"the {kind} matrix is not positive definite ({int(weak.sum())} of {weak.size} are "
            f"not); give the upper triangle of {'a' if covariance else 'an inverse'} covariance, "
            'or read with indefinite="nearest" or "isotropic"',
        )
    else:
        given[weak], empty = definite(given[weak], indefinite)
        spectrum = np.asarray(np.linalg.eigvalsh(given))
        hopeless = _weak(given, spectrum, covariance) | out_of_range(spectrum, LARGEST)
        hopeless[weak] |= empty
        rows.refuse(
            hopeless,
            f"the {kind} matrix has no positive eigenvalue in position or in rotation, or "
            "entries that differ too much; drop the edge",
        )
    return _inverse(given) if covariance else given, np.flatnonzero(weak)


def uneven(rows: Rows, information: Array, names: Callable[[Indices], Names]) -> tuple[str, ...]:
    """Return a sentence about an edge whose information is far from that of the others.

    ``information`` is ``(k, D, D)``, and ``names`` returns the names of ids. There is none where
    all are alike.
    """
    d = 2 if information.shape[-1] == 3 else 3
    diagonal = np.diagonal(information, axis1=1, axis2=2)
    kinds = np.stack([diagonal[:, :d].sum(axis=1), diagonal[:, d:].sum(axis=1)])
    ratio = kinds / np.median(kinds, axis=1, keepdims=True)
    far = np.max(np.maximum(ratio, 1.0 / ratio), axis=0)
    worst = int(np.argmax(far))
    if far[worst] < _UNEVEN:
        return ()
    i, j = names(rows.ids[worst])
    return (
        f"line {rows.line[worst]}: the deviations of edge {i}-{j} are a factor of "
        f"{np.sqrt(far[worst]):.1g} from those of other edges; give what its sensor can do",
    )


def _weak(matrices: Array, spectrum: Array, covariance: bool) -> Mask:
    """Return which matrices, or inverses of a covariance, are not positive definite.

    ``spectrum`` ``(k, D)`` holds their eigenvalues.
    """
    diagonal = np.diagonal(matrices, axis1=1, axis2=2)
    weak: Mask = ~(spectrum[:, 0] > 0.0) | np.any(diagonal <= 0.0, axis=1)
    # With a diagonal of 1 the smallest eigenvalue is no smaller than this quotient.
    doubtful = ~weak & (spectrum[:, 0] < _SINGULAR * spectrum[:, -1])
    scaled, _ = _scaled(matrices[doubtful])
    weak[doubtful] = np.linalg.eigvalsh(scaled)[:, 0] < _SINGULAR
    if covariance:
        weak[~weak] = ~(np.linalg.eigvalsh(_inverse(matrices[~weak]))[:, 0] > 0.0)
    return weak


def _scaled(matrices: Array) -> tuple[Array, Array]:
    """Return matrices with a diagonal of 1, and what divided them, ``(k, D, D)`` each."""
    root = np.sqrt(np.diagonal(matrices, axis1=1, axis2=2))
    unit = root[:, :, None] * root[:, None, :]
    return matrices / unit, unit


def _inverse(matrices: Array) -> Array:
    """Return the inverses of positive definite matrices, symmetric to the last bit."""
    scaled, unit = _scaled(matrices)
    values, vectors = np.linalg.eigh(scaled)
    root = vectors / np.sqrt(values)[:, None, :]
    return np.asarray(root @ np.swapaxes(root, 1, 2) / unit)


def definite(information: Array, repair: Repair) -> tuple[Array, Mask]:
    """Return positive definite matrices ``(k, D, D)``, and which could not be repaired.

    ``information`` ``(k, D, D)`` is symmetric. "nearest" replaces eigenvalues below a floor by it:
    in the Frobenius norm no such matrix is nearer, after position and rotation are scaled by their
    largest diagonal entries. "isotropic" takes one precision for each of both, the harmonic mean
    of the positive eigenvalues of its block. A block without one cannot be repaired.
    """
    size = information.shape[-1]
    d = 2 if size == 3 else 3
    blocks = information[:, :d, :d], information[:, d:, d:]
    spectra: list[Array] = [np.asarray(np.linalg.eigvalsh(block)) for block in blocks]
    good = np.all([spectrum[:, -1] > 0.0 for spectrum in spectra], axis=0)
    repaired, nearest = np.tile(np.eye(size), (len(good), 1, 1)), repair == "nearest"
    scales = [s[good, -1] if nearest else _harmonic_means(s[good]) for s in spectra]
    scale = np.repeat(np.stack(scales, axis=1), [d, size - d], axis=1)
    if nearest:
        repaired[good] = _nearest(information[good], np.sqrt(scale))
    else:
        repaired[good] = scale[:, :, None] * np.eye(size)
    return repaired, ~good


def _nearest(information: Array, unit: Array) -> Array:
    """Return the nearest matrices after a scaling by ``unit`` ``(k, D)``."""
    units = unit[:, :, None] * unit[:, None, :]
    values, vectors = np.linalg.eigh(information / units)
    raised = np.maximum(values, _FLOOR * values[:, -1:])
    near = (vectors * raised[:, None, :]) @ np.swapaxes(vectors, 1, 2) * units
    return np.asarray(0.5 * (near + np.swapaxes(near, 1, 2)))


def _harmonic_means(spectrum: Array) -> Array:
    """Return the harmonic mean ``(k,)`` of the positive eigenvalues ``(k, b)``."""
    used = spectrum > _FLOOR * spectrum[:, -1:]
    inverse = np.where(used, 1.0 / np.where(used, spectrum, 1.0), 0.0)
    return np.asarray(used.sum(axis=1) / inverse.sum(axis=1))
