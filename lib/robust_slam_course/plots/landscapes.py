"""Draw the cost of a location problem while its kernel hardens: one curve for each μ."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike
from robust_slam._arrays import Array, Indices, finite
from robust_slam.estimators.kernels import Kernel
from robust_slam.palette import PALETTE

from robust_slam_course.style import LOOKS

Surrogate = Callable[[ArrayLike, float, float], Array]


def draw_graduation(
    ax: Axes,
    z: ArrayLike,
    x: ArrayLike,
    surrogate: Surrogate,
    c: float,
    mus: Iterable[float],
    sigma: float = 1.0,
    kernel: Kernel | None = None,
) -> Axes:
    """Draw Σ ρ_μ((x − z)/σ) over x (n,) for each μ, each curve as a share of its highest point.

    `surrogate` is called with u, c and μ, such as `tls_surrogate`; z (m,) are the readings.
    A marker stands at each minimum on the grid x: where there is one only, the curve has one
    basin. The readings are ticks along the bottom. The cost of `kernel`, which the surrogates
    harden into, is a broad band behind them.

    Raises:
        ValueError: z or x is no list of finite numbers, or there are more μ than looks.
    """
    grid, readings, levels = finite("x", x, (-1,)), finite("z", z, (-1,)), tuple(mus)
    if len(levels) > len(LOOKS):
        raise ValueError(f"mus: there are {len(levels)}; give at most {len(LOOKS)}")
    u = (grid - readings[:, None]) / sigma
    for look, mu in zip(LOOKS, levels, strict=False):
        share = _share(surrogate(u, c, mu))
        ax.plot(grid, share, color=look.color, linestyle=look.linestyle, label=f"μ = {mu:.3g}")
        low = minima(share)
        ax.plot(grid[low], share[low], look.marker, color=look.color, zorder=4)
    if kernel is not None:
        (band,) = ax.plot(grid, _share(kernel.rho(u)), "-", label=kernel.label)
        band.set(color=PALETTE["muted"], linewidth=5.0, zorder=1.5)
    ax.plot(readings, np.zeros_like(readings), "|", color=LOOKS[0].color, markersize=14)
    ax.set(xlabel="x", ylabel="cost, relative to its highest")
    return ax


def minima(values: ArrayLike) -> Indices:
    """Return the places (k,) of the local minima of values (n,), ends left out.

    A flat floor counts once, at its middle, and only if it rises again on both sides.
    """
    heights = np.asarray(values, dtype=np.float64)
    turn = np.flatnonzero(np.abs(np.diff(heights)) > 1e-12)
    falls = np.diff(heights)[turn] < 0.0
    low = np.flatnonzero(falls[:-1] & ~falls[1:])
    middles: Indices = (turn[low] + 1 + turn[low + 1]) // 2
    return middles


def _share(costs: Array) -> Array:
    """Return the sum (n,) of costs (m, n) over the readings, as a share of its highest."""
    total = costs.sum(axis=0)
    return np.asarray(total / total.max())
