"""How efficient a kernel is when every measurement is an inlier."""

from __future__ import annotations

import math
from collections.abc import Callable

from robust_slam.estimators import kernels
from scipy.integrate import quad


def efficiency(kernel: kernels.Kernel, d: int = 1) -> float:
    """Return the share for Gaussian residuals of ``d`` numbers, judged by their norm.

    The formula is another than the chapter's: by Stein's lemma the mean slope is E uψ.
    """
    scale = 2 ** (1 - d / 2) / math.gamma(d / 2)

    def mean(values: Callable[[float, float], float]) -> float:
        """The mean over the chi distribution, of ``d`` degrees of freedom, of the norm."""
        return quad(
            lambda u: (
                values(u, float(kernel.psi(u))) * scale * u ** (d - 1) * math.exp(-(u**2) / 2)
            ),
            0,
            14,
            points=[kernel.scale],
        )[0]

    return mean(lambda u, psi: u * psi) ** 2 / (d * mean(lambda u, psi: psi**2))
