"""Linear least squares with whitened residuals, and the 1-D pose graph as its example.

Source: Gauss 1809, weighted least squares.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from robust_slam._arrays import Array, Indices, deviations, finite, mask
from robust_slam.errors import Underdetermined


class LinearProblem:
    """Measurements z = J x + noise with standard deviations sigma.

    ``jacobian`` is J ``(m, n)``, ``measurement`` z ``(m,)``, ``sigma`` a scalar or
    ``(m,)`` in the unit of z, ``trusted`` a mask ``(m,)`` (by default nothing), and
    ``fixed`` a mask ``(n,)`` of unknowns that stay at 0 (by default none).

    Raises:
        ValueError: the shapes do not agree, or an entry is not finite.
    """

    def __init__(
        self,
        jacobian: ArrayLike,
        measurement: ArrayLike,
        sigma: ArrayLike = 1.0,
        trusted: ArrayLike | None = None,
        fixed: ArrayLike | None = None,
    ) -> None:
        self.jacobian = finite("jacobian", jacobian, (-1, -1))
        m, n = self.jacobian.shape
        self.measurement = finite("measurement", measurement, (m,))
        self.sigma = deviations(sigma, m)
        self.trusted = mask("trusted", trusted, m)
        self.fixed = mask("fixed", fixed, n)

    def initial(self) -> Array:
        """Return the least-squares solution x ``(n,)``."""
        m, n = self.jacobian.shape
        return self.solve(np.ones(m), np.zeros(n))

    def residuals(self, x: Array) -> Array:
        """Return the whitened residuals (J x − z)/sigma with their sign, ``(m,)``."""
        return np.asarray((self.jacobian @ x - self.measurement) / self.sigma)

    def residual_norms(self, x: Array) -> Array:
        """Return |J x − z|/sigma, ``(m,)``."""
        return np.abs(self.residuals(x))

    def solve(self, weights: Array, x: Array) -> Array:
        """Return the x ``(n,)`` of least Σ w u²; the start ``x`` is not needed.

        Raises:
            Underdetermined: the rows with positive weight leave a direction of x free.
        """
        # The roots of the weights scale the rows: squaring J would square its condition.
        scale = np.sqrt(weights) / self.sigma
        rows = self.jacobian[:, ~self.fixed] * scale[:, None]
        free, _, rank, _ = np.linalg.lstsq(rows, self.measurement * scale, rcond=None)
        if rank < rows.shape[1]:
            raise Underdetermined(
                f"the measurements with positive weight determine {rank} of {rows.shape[1]} "
                "unknowns; fix an unknown, trust a measurement or add one"
            )
        solution = np.zeros(self.fixed.size)
        solution[~self.fixed] = free
        return solution


def chain(
    n: int,
    i: ArrayLike,
    j: ArrayLike,
    z: ArrayLike,
    sigma: ArrayLike = 1.0,
    anchor: int = 0,
    trusted: ArrayLike | None = None,
) -> LinearProblem:
    """Return the 1-D pose graph of ``n`` poses with z = x[j] − x[i] and x[anchor] = 0.

    ``i``, ``j``, ``z`` are ``(m,)``, poses count from 0, ``sigma`` is a scalar or
    ``(m,)``. Only differences are measured, so one pose must be held: the anchor.

    Raises:
        ValueError: an index is out of range, an edge joins a pose to itself, or the
            shapes do not agree.
    """
    measurement = finite("z", z, (-1,))
    tail, head = (_ends(name, value, measurement.size, n) for name, value in (("i", i), ("j", j)))
    if np.any(tail == head):
        raise ValueError(f"edge {int(np.argmax(tail == head))} joins a pose to itself")
    if not 0 <= anchor < n:
        raise ValueError(f"anchor is {anchor}; give a pose from 0 to {n - 1}")
    rows = np.arange(measurement.size)
    jacobian = np.zeros((measurement.size, n))
    jacobian[rows, head] = 1.0
    jacobian[rows, tail] = -1.0
    return LinearProblem(jacobian, measurement, sigma, trusted, fixed=np.arange(n) == anchor)


def _ends(name: str, value: ArrayLike, m: int, n: int) -> Indices:
    ends = np.asarray(value)
    if ends.shape != (m,) or (m and not np.issubdtype(ends.dtype, np.integer)):
        raise ValueError(f"{name}: give {m} whole numbers, one for each entry of z")
    outside = (ends < 0) | (ends >= n)
    if np.any(outside):
        edge = int(np.argmax(outside))
        raise ValueError(f"{name}: edge {edge} names pose {ends[edge]}; poses are 0 to {n - 1}")
    return ends.astype(np.intp)
