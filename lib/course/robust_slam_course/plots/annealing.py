"""Draw graduated non-convexity: its families of curves, the price of a weight, and its runs.

A `Curve` is called with u, c and μ, such as `tls_weight` and `tls_surrogate`.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike
from robust_slam._arrays import Array, Mask, finite, mask
from robust_slam.estimators.kernels import Kernel
from robust_slam.estimators.result import Step
from robust_slam.palette import LINESTYLES, MARKERS, PALETTE

from robust_slam_course.plots import with_gaps
from robust_slam_course.plots.landscapes import minima
from robust_slam_course.style import LOOKS

Curve = Callable[[ArrayLike, float, float], Array]

_BAND = 5.0  # points, the width of a curve that others are drawn over
_MOST_TICKS = 8
_FEW = 12  # so many lines still stand apart, and get markers


def draw_family(
    ax: Axes,
    curve: Curve,
    c: float,
    mus: Iterable[float],
    u: ArrayLike,
    target: Callable[[ArrayLike], Array],
) -> Axes:
    """Draw curve(u, c, μ) over u (n,) for each μ, over the broad band of what they end at."""
    grid = np.asarray(u, dtype=np.float64)
    ax.plot(grid, target(grid), "-", color=PALETTE["muted"], linewidth=_BAND, alpha=0.6)
    for look, mu in zip(LOOKS[1:], mus, strict=False):
        ax.plot(grid, curve(grid, c, mu), **look.line, label=f"μ = {mu:g}")
    ax.set(xlabel="whitened residual u")
    return ax


def draw_prices(
    ax: Axes, process: Curve, weight: Curve, c: float, mu: float, us: Iterable[float]
) -> Axes:
    """Draw w u²/2 + Φ(w) over the weight w for each u, with a marker at the weight of u.

    `process` gives Φ and `weight` the minimiser, such as `tls_process`, `tls_weight`.
    """
    w = np.linspace(0.0, 1.0, 201)
    for look, u in zip(LOOKS[1:], us, strict=False):
        bill = 0.5 * w * u**2 + process(w, c, mu)
        ax.plot(w, bill, **look.line, label=f"u = {u:g}")
        best = float(weight(u, c, mu))
        least = 0.5 * best * u**2 + float(process(best, c, mu))
        ax.plot(best, least, look.marker, color=look.color, zorder=4)
    ax.set(xlabel="weight w", ylabel="w u²/2 + Φ(w)")
    return ax


def draw_stage(
    ax: Axes,
    z: ArrayLike,
    x: ArrayLike,
    surrogate: Curve,
    c: float,
    mu: float,
    move: tuple[float, float],
    kernel: Kernel | None = None,
) -> Axes:
    """Draw Σ ρ_μ(x − z) over x (n,) for readings z (m,), as a share of its highest point.

    A marker stands at each minimum on the grid x: where there is one only, the curve has one
    basin. The readings are ticks along the bottom. The cost of `kernel`, which the surrogates
    harden into, is a broad band behind. The estimate's `move` in this stage is a ring on the
    curve where it came from, and a diamond where it went.
    """
    grid, readings = finite("x", x, (-1,)), finite("z", z, (-1,))

    def cost(at: ArrayLike) -> Array:
        return np.asarray(surrogate(np.asarray(at) - readings[:, None], c, mu).sum(axis=0))

    highest, ink = cost(grid).max(), LOOKS[0].color
    share = cost(grid) / highest
    ax.plot(grid, share, **LOOKS[0].line, label=f"μ = {mu:.3g}")
    low = minima(share)
    ax.plot(grid[low], share[low], LOOKS[0].marker, color=ink, zorder=4)
    if kernel is not None:
        hard = kernel.rho(grid - readings[:, None]).sum(axis=0)
        (band,) = ax.plot(grid, hard / hard.max(), "-", label=kernel.label)
        band.set(color=PALETTE["muted"], linewidth=_BAND, zorder=1.5)
    ax.plot(readings, np.zeros_like(readings), "|", color=ink, markersize=14)
    ring, diamond = cost(move) / highest
    colour = PALETTE["estimate"]
    ax.plot(move[0], ring, "o", color=colour, markerfacecolor="white", zorder=5, label="before")
    ax.plot(move[1], diamond, "D", color=colour, zorder=6, label="after the solve")
    ax.set(xlabel="x", ylim=(-0.06, 1.06), yticks=[0.0, 0.5, 1.0], ylabel="cost, as a share")
    return ax


def draw_paths(ax: Axes, runs: Mapping[str, Sequence[Step[float]]]) -> Axes:
    """Draw the estimate after each solve against the μ of the solve, one line for each run."""
    for look, (label, history) in zip(LOOKS[1:], runs.items(), strict=False):
        mu, x = zip(*((step.mu, step.x) for step in history[1:]), strict=True)
        ax.semilogx(mu, x, **look.line, marker=look.marker, markersize=5.0, label=label)
    ax.set(xlabel="μ of the solve", ylabel="estimate x")
    return ax


def draw_weight_history(
    ax: Axes, history: Sequence[Step[Any]], is_outlier: ArrayLike, shown: ArrayLike
) -> Axes:
    """Draw each weight over the steps of a `Result.history`: outliers dashed, the others solid.

    The masks `is_outlier` and `shown` (m,) mark the outliers, and the measurements to draw.
    Step 0 is the start, with weights 1. Under each step stands its μ, if it has one.
    """
    weights = np.array([step.weights for step in history])
    m = weights.shape[1]
    drawn, wrong = mask("shown", shown, m), mask("is_outlier", is_outlier, m)
    for name, label, chosen in (
        ("inlier", "inliers", drawn & ~wrong),
        ("outlier", "outliers", drawn & wrong),
    ):
        _draw_lines(ax, weights, chosen, name, f"{label} ({np.count_nonzero(chosen)})")
    ax.set(xlabel="step", ylabel="weight", ylim=(-0.04, 1.04))
    ax.set_xticks(*_ticks(history))
    return ax


def _draw_lines(ax: Axes, weights: Array, chosen: Mask, name: str, label: str) -> None:
    """Draw the chosen columns as one line with gaps, so that thousands are quick."""
    count = int(np.count_nonzero(chosen))
    if count == 0:
        return
    heights = weights[:, chosen].T
    steps = np.broadcast_to(np.arange(len(weights)), heights.shape)
    (line,) = ax.plot(*with_gaps(np.stack([steps, heights], axis=2)), label=label)
    line.set(color=PALETTE[name], linestyle=LINESTYLES[name], linewidth=1.6)
    if count <= _FEW:
        line.set(marker=MARKERS[name], linewidth=2.0)


def _ticks(history: Sequence[Step[Any]]) -> tuple[list[int], list[str]]:
    every = max(1, -(-len(history) // _MOST_TICKS))
    places = list(range(0, len(history), every))
    values = [history[k].mu for k in places]
    names = [
        f"{k}" if mu is None else f"{k}\n{mu:.2g}" for k, mu in zip(places, values, strict=True)
    ]
    if any(mu is not None for mu in values):
        names[0] += "\nμ"
    return places, names
