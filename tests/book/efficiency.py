"""How efficient a kernel is when every measurement is an inlier."""

from __future__ import annotations

from robust_slam.estimators import kernels
from scipy.integrate import quad
from scipy.stats import chi


def efficiency(kernel: kernels.Kernel, d: int = 1) -> float:
    """Return the share for Gaussian residuals of ``d`` numbers, judged by their norm.

    The formula is another than the chapter's: by Stein's lemma the mean slope is E uψ.
    """
    density = chi(d).pdf
    slope, _ = quad(lambda u: u * float(kernel.psi(u)) * density(u), 0, 14, points=[kernel.scale])
    square, _ = quad(
        lambda u: float(kernel.psi(u)) ** 2 * density(u), 0, 14, points=[kernel.scale]
    )
    return slope**2 / (d * square)
