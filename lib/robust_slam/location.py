"""The smallest problem of the course: one number x, measured m times.

Source: Gauss 1809, the weighted mean.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from robust_slam._arrays import Array, deviations, finite, mask
from robust_slam.errors import Underdetermined


class LocationProblem:
    """Measurements z ``(m,)`` of one number x, with standard deviations sigma.

    ``sigma`` is a scalar or ``(m,)``, in the unit of z; ``trusted`` is a mask ``(m,)``,
    by default nothing. The whitened residual is u = |z − x|/sigma.

    Raises:
        ValueError: ``z`` is empty or not finite, or the shapes do not agree.
    """

    def __init__(
        self, z: ArrayLike, sigma: ArrayLike = 1.0, trusted: ArrayLike | None = None
    ) -> None:
        self.z = finite("z", z, (-1,))
        if self.z.size == 0:
            raise ValueError("z is empty; give at least one measurement")
        self.sigma = deviations(sigma, self.z.size)
        self.trusted = mask("trusted", trusted, self.z.size)

    def initial(self) -> float:
        """Return the mean of z, each weighted by 1/sigma²."""
        return self.solve(np.ones_like(self.z), 0.0)

    def residual_norms(self, x: float) -> Array:
        """Return |z − x|/sigma, ``(m,)``."""
        return np.abs(self.z - x) / self.sigma

    def solve(self, weights: Array, x: float) -> float:
        """Return the weighted mean Σ w z/sigma² / Σ w/sigma²; ``x`` is not needed.

        Raises:
            Underdetermined: every weight is 0.
        """
        information = weights / self.sigma**2
        total = float(np.sum(information))
        if total == 0.0:
            raise Underdetermined("weights: all are 0, so x is not determined; keep at least one")
        return float(information @ self.z / total)
