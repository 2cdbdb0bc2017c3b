"""Draw graduated non-convexity: its families of curves, the price of a weight, and its runs.

Every function takes matplotlib axes and returns them. `curve` and `surrogate` are called with
u, c and μ, such as `tls_weight` and `tls_surrogate`; u is a whitened residual.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike
from robust_slam._arrays import Array, finite
from robust_slam.estimators.kernels import Kernel
from robust_slam.estimators.result import Step
from robust_slam.palette import PALETTE

from robust_slam_course.plots.landscapes import Surrogate, draw_graduation
from robust_slam_course.style import LOOKS

_BAND = 5.0  # points, the width of a curve that others are drawn over


def draw_family(
    ax: Axes,
    curve: Surrogate,
    c: float,
    mus: Iterable[float],
    u: ArrayLike,
    target: Callable[[ArrayLike], Array] | None = None,
) -> Axes:
    """Draw curve(u, c, μ) over u (n,) for each μ, over the broad band of what they end at."""
    grid = np.asarray(u, dtype=np.float64)
    if target is not None:
        ax.plot(grid, target(grid), "-", color=PALETTE["muted"], linewidth=_BAND, alpha=0.6)
    for look, mu in zip(LOOKS[1:], mus, strict=False):
        values = curve(grid, c, mu)
        ax.plot(grid, values, color=look.color, linestyle=look.linestyle, label=f"μ = {mu:g}")
    ax.set(xlabel="whitened residual u")
    return ax


def draw_prices(
    ax: Axes, process: Surrogate, weight: Surrogate, c: float, mu: float, us: Iterable[float]
) -> Axes:
    """Draw w u²/2 + Φ(w) over the weight w for each u, with a marker at the weight of u.

    `process` gives Φ and `weight` the minimiser, such as `tls_process`, `tls_weight`.
    """
    w = np.linspace(0.0, 1.0, 201)
    for look, u in zip(LOOKS[1:], us, strict=False):
        bill = 0.5 * w * u**2 + process(w, c, mu)
        ax.plot(w, bill, color=look.color, linestyle=look.linestyle, label=f"u = {u:g}")
        best = float(weight(u, c, mu))
        least = 0.5 * best * u**2 + float(process(best, c, mu))
        ax.plot(best, least, look.marker, color=look.color, zorder=4)
    ax.set(xlabel="weight w", ylabel="w u²/2 + Φ(w)")
    return ax


def draw_stage(
    ax: Axes,
    z: ArrayLike,
    x: ArrayLike,
    surrogate: Surrogate,
    c: float,
    mu: float,
    move: tuple[float, float],
    sigma: float = 1.0,
    kernel: Kernel | None = None,
) -> Axes:
    """Draw the summed surrogate over x (n,) at one μ, and a `move` on it, from where to where.

    A ring stands on the curve where the estimate came from and a diamond where it went. The
    rest is that of `landscapes.draw_graduation`, the height as a share of the highest too.
    """
    draw_graduation(ax, z, x, surrogate, c, [mu], sigma, kernel)
    readings = finite("z", z, (-1,))

    def cost(at: ArrayLike) -> Array:
        u = (np.atleast_1d(np.asarray(at, dtype=np.float64)) - readings[:, None]) / sigma
        return np.asarray(surrogate(u, c, mu).sum(axis=0))

    ring, diamond = cost(move) / cost(x).max()
    colour = PALETTE["estimate"]
    ax.plot(move[0], ring, "o", color=colour, markerfacecolor="white", zorder=5, label="before")
    ax.plot(move[1], diamond, "D", color=colour, zorder=6, label="after the solve")
    ax.set(ylim=(-0.06, 1.06), yticks=[0.0, 0.5, 1.0], ylabel="cost, as a share")
    return ax


def draw_paths(ax: Axes, runs: Mapping[str, Sequence[Step[float]]]) -> Axes:
    """Draw the estimate after each solve against the μ of the solve, one line for each run."""
    for look, (label, history) in zip(LOOKS[1:], runs.items(), strict=False):
        mu = [step.mu for step in history[1:]]
        x = [step.x for step in history[1:]]
        style = {"color": look.color, "linestyle": look.linestyle, "marker": look.marker}
        ax.semilogx(mu, x, **style, markersize=5.0, label=label)
    ax.set(xlabel="μ of the solve", ylabel="estimate x")
    return ax
