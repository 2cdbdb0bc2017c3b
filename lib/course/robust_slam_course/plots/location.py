"""Draw a scalar estimate: its readings and their weights, its cost, and how it converges."""

from collections.abc import Iterable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator
from numpy.typing import ArrayLike
from robust_slam._arrays import Array
from robust_slam.estimators.kernels import Kernel
from robust_slam.estimators.result import Step
from robust_slam.palette import MARKERS, PALETTE

from robust_slam_course.plots.kernels import kernel_look

_FULL_AREA = 100.0  # points², the area of a marker whose weight is 1
_SPREAD = 0.7  # between the first and the last reading of a row, so that close ones stay apart


def draw_weights(
    ax: Axes,
    z: ArrayLike,
    weights: ArrayLike,
    x: float,
    is_outlier: ArrayLike,
    height: float = 0.0,
) -> Axes:
    """Draw readings z (m,) as rings, each filled by its weight (m,), and a bar at x.

    The ring is the area of weight 1 and the disc inside it the weight; outliers, where the
    mask (m,) is true, are crosses. Each reading has a level of its own around `height`.
    """
    z, weights = np.asarray(z, dtype=float), np.asarray(weights, dtype=float)
    outlier = np.asarray(is_outlier, dtype=bool)
    levels = _levels(z.size, height)
    for mask, name in ((~outlier, "inlier"), (outlier, "outlier")):
        at, colour, marker = (z[mask], levels[mask]), PALETTE[name], MARKERS[name]
        ax.scatter(*at, s=_FULL_AREA, marker=marker, facecolors="none", edgecolors=colour)
        ax.scatter(*at, s=_FULL_AREA * weights[mask], marker=marker, color=colour, linewidths=0)
    bar = [height - 0.62 * _SPREAD, height + 0.62 * _SPREAD]
    ax.plot([x, x], bar, "-", color=PALETTE["estimate"], linewidth=2.5, zorder=0.9)
    return ax


def label_weights(ax: Axes, weights: ArrayLike) -> Axes:
    """Print each weight (m,) in the right margin, on the level that `draw_weights` gave it."""
    weights = np.asarray(weights, dtype=float)
    ax.text(1.02, 1.0, "weight", transform=ax.transAxes, va="bottom")
    for weight, level in zip(weights, _levels(weights.size, 0.0), strict=True):
        ax.text(1.02, level, f"{weight:.4f}", transform=ax.get_yaxis_transform(), va="center")
    return ax


def draw_reweighting(
    ax: Axes,
    z: ArrayLike,
    history: Sequence[Step[float]],
    steps: Iterable[int],
    is_outlier: ArrayLike,
) -> Axes:
    """Draw one row of readings, weights and estimate for each of the chosen steps of a history.

    A row shows the weights that its step solved with and the estimate that came out, which
    also stands in the right margin.
    """
    steps = tuple(steps)
    for row, t in enumerate(steps):
        draw_weights(ax, z, history[t].weights, history[t].x, is_outlier, height=-float(row))
        estimate = f"x = {history[t].x:.4f}".replace("-", "−")
        ax.text(1.02, -row, estimate, transform=ax.get_yaxis_transform(), va="center")
    ax.set_yticks([-row for row in range(len(steps))], [f"step {t}" for t in steps])
    ax.grid(visible=False, axis="y")
    ax.set(xlabel="x", ylim=(0.45 - len(steps), 0.55))
    return ax


def draw_landscape(
    ax: Axes, z: ArrayLike, sigma: float, kernel: Kernel, x: ArrayLike, at: float | None = None
) -> Axes:
    """Draw the robust cost Σρ((x − z)/σ) over x (n,) and its majoriser at `at`, if given.

    The majoriser is the parabola that one IRLS step minimises; a diamond marks its minimum.
    """
    cost = kernel.rho(_residuals(z, sigma, x)).sum(axis=0)
    ax.plot(x, cost, "-", color=kernel_look(kernel.name).color, label="robust cost")
    if at is not None:
        _draw_parabola(ax, np.asarray(z, dtype=float), sigma, kernel, np.asarray(x), at)
    ax.set(xlabel="x", ylabel="cost")
    return ax


def draw_descent(ax: Axes, history: Sequence[Step[float]]) -> Axes:
    """Draw the cost at every x of a history: a ring at the start, a diamond at the end."""
    x, cost = [step.x for step in history], [step.cost for step in history]
    colour = PALETTE["estimate"]
    ax.plot(x, cost, ".", color=colour, markersize=5.0)
    ax.plot(x[0], cost[0], "o", color=colour, markerfacecolor="white", label="start")
    ax.plot(x[-1], cost[-1], "D", color=colour, label="end")
    return ax


def draw_convergence(ax: Axes, errors: ArrayLike, rate: float) -> Axes:
    """Draw the errors (n,) of the iterates on a log axis beside a line that shrinks by `rate`."""
    errors = np.asarray(errors, dtype=float)
    steps = np.arange(errors.size)
    line = errors[-1] * rate ** (steps - steps[-1]).astype(float)
    ax.semilogy(steps, errors, "o", color=PALETTE["estimate"], label="distance to the fixed point")
    ax.semilogy(steps, line, "--", color=PALETTE["muted"], label=f"× {rate:.3f} a step")
    ax.xaxis.set_major_locator(MaxNLocator(integer=True))
    ax.set(xlabel="step", ylabel="distance")
    return ax


def _levels(m: int, height: float) -> Array:
    """Return m levels around the height, from the top down."""
    return height + np.linspace(0.5, -0.5, m) * _SPREAD


def _residuals(z: ArrayLike, sigma: float, x: ArrayLike) -> Array:
    """Return the whitened residuals (m, n) of readings z (m,) at points x (n,)."""
    return np.asarray((np.atleast_1d(x) - np.asarray(z, dtype=float)[:, None]) / sigma)


def _draw_parabola(ax: Axes, z: Array, sigma: float, kernel: Kernel, x: Array, at: float) -> None:
    u = _residuals(z, sigma, at)
    weights = kernel.weight(u)
    offset = (kernel.rho(u) - 0.5 * weights * u**2).sum()

    def parabola(x: ArrayLike) -> Array:
        return np.asarray(offset + (0.5 * weights * _residuals(z, sigma, x) ** 2).sum(axis=0))

    ax.plot(x, parabola(x), "--", color=PALETTE["accent"], label="parabola above")
    ax.plot([at], parabola(at), "o", color=PALETTE["accent"], label="they touch here")
    if weights.sum() > 0.0:
        lowest = float((weights[:, 0] * z).sum() / weights.sum())
        ax.plot([lowest], parabola(lowest), "D", color=PALETTE["estimate"], label="next estimate")
        cost = kernel.rho(_residuals(z, sigma, lowest)).sum()
        ax.plot([lowest], [cost], ".", color=PALETTE["estimate"], label="its cost")
