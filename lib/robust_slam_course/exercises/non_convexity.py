"""Pictures of 04-non-convexity: landscapes, their minima, and where descents from them end.

Every function takes a student's own, of the same name, and draws it dashed or as markers
over the library's, which is broad and grey. x and the measurements share one unit, σ is 1.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike
from robust_slam._arrays import Array
from robust_slam.estimators.kernels import Kernel, cauchy, squared, tls
from robust_slam.estimators.reweighting import irls
from robust_slam.palette import MARKERS, PALETTE
from robust_slam.problems import LocationProblem

from robust_slam_course.exercises import draw_beside, names_truth, once_it_works, panel
from robust_slam_course.style import LOOKS

Rho = Callable[[ArrayLike], Array]

PAIR = np.array([0.0, 10.0])
CROWD = np.append(np.zeros(20), 10.0)
TWO_GROUPS = np.array([0.0, 0.0, 10.0, 10.0, 10.0])


@once_it_works
def cost(landscape: Callable[[ArrayLike, ArrayLike, Rho], ArrayLike]) -> Figure:
    """Draw the pair's landscape under three kernels."""
    figure, ax = panel("One bowl for the square, two wells for TLS")
    x = np.linspace(-4.0, 14.0, 361)
    kernels = (squared(), cauchy(2.0), tls(3.0))
    for kernel, scale, look in zip(kernels, (0.1, 1.0, 1.0), LOOKS[1:], strict=False):
        yours = scale * np.asarray(landscape(x, PAIR.copy(), kernel.rho), dtype=float)
        draw_beside(ax, x, scale * _height(x, PAIR, kernel), yours)
        name = f"yours, {kernel.label}" + (" / 10" if scale < 1.0 else "")
        ax.lines[-1].set(color=look.color, linestyle=look.linestyle, label=name)
    ax.set(xlabel="x; the measurements are at 0 and 10", ylabel="cost", ylim=(0.0, 18.0))
    ax.legend(loc="upper center", ncols=2)
    return figure


@once_it_works
def local_minima(find: Callable[[ArrayLike, Rho, float, float], ArrayLike]) -> Figure:
    """Draw the pair's Cauchy landscapes, a ring at each true minimum and a mark at each found."""
    figure, ax = panel("The two wells draw together; from c = 5 on they are one")
    x = np.linspace(-2.0, 12.0, 281)
    for c, look in zip((1.0, 3.0, 4.5, 6.0), LOOKS[1:], strict=False):
        kernel = cauchy(c)
        highest = float(np.max(_height(x, PAIR, kernel)))
        half = np.sqrt(max(25.0 - c**2, 0.0))
        truth = np.unique([5.0 - half, 5.0 + half])
        yours = np.asarray(find(PAIR.copy(), kernel.rho, -2.0, 12.0), dtype=float).reshape(-1)
        ax.plot(x, _height(x, PAIR, kernel) / highest, "-", color=look.color, linewidth=1.2)
        _rings(ax, truth, _height(truth, PAIR, kernel) / highest)
        found = _height(yours, PAIR, kernel) / highest
        ax.plot(yours, found, look.marker, color=look.color, label=f"yours, c = {c:g}")
    ax.set(xlabel="x; the measurements are at 0 and 10", ylabel="cost, relative to its highest")
    ax.legend(loc="lower center", ncols=2)
    ax.set_ylim(bottom=-0.15)
    return figure


@once_it_works
def tls_descent(descend: Callable[[ArrayLike, float, float], float]) -> Figure:
    """Draw the end of the descent against its start, for twenty at 0 and one at 10."""
    figure, ax = panel("Twenty at 0, one at 10: the start decides, and so does c")
    starts = np.linspace(-3.95, 13.95, 180)
    for c, look in zip((3.0, 9.0), LOOKS[1:], strict=False):
        truth = [irls(LocationProblem(CROWD), tls(c), float(x0)).x for x0 in starts]
        yours = [float(descend(CROWD.copy(), c, float(x0))) for x0 in starts]
        draw_beside(ax, starts, truth, yours)
        ax.lines[-1].set(color=look.color, linestyle=look.linestyle, label=f"yours, c = {c:g}")
    ax.set(xlabel="start x₀", ylabel="end x")
    ax.legend(loc="upper left")
    return figure


@once_it_works
def best_of(best: Callable[[ArrayLike, float, ArrayLike], float]) -> Figure:
    """Draw descents from seven starts in one landscape, and the end that is chosen."""
    figure, ax = panel("Seven starts, and the lowest of their ends")
    kernel, x = tls(2.0), np.linspace(-4.0, 14.0, 361)
    starts = np.array([-3.0, -1.0, 1.5, 5.0, 6.5, 8.5, 11.0])
    ends = np.array([irls(LocationProblem(TWO_GROUPS), kernel, float(x0)).x for x0 in starts])
    yours = np.array([float(best(TWO_GROUPS.copy(), 2.0, starts.copy()))])
    costs = _height(ends, TWO_GROUPS, kernel)
    ax.plot(x, _height(x, TWO_GROUPS, kernel), "-", color=PALETTE["odometry"], linewidth=1.2)
    _rings(ax, ends[[np.argmin(costs)]], costs[[np.argmin(costs)]])
    high = _height(starts, TWO_GROUPS, kernel)
    ax.plot(starts, high, "o", color=PALETTE["estimate"], markerfacecolor="white", label="starts")
    ax.plot(ends, costs, "D", color=PALETTE["estimate"], markersize=4.0, label="ends")
    chosen = _height(yours, TWO_GROUPS, kernel)
    ax.plot(yours, chosen, MARKERS["outlier"], color=PALETTE["outlier"], label="yours")
    ax.set(xlabel="x; two measurements at 0, three at 10", ylabel="TLS cost, c = 2")
    ax.set_ylim(bottom=3.0)
    ax.legend(loc="lower center", ncols=2)
    return figure


def _height(x: ArrayLike, z: Array, kernel: Kernel) -> Array:
    """Return the cost Σρ(x − z) at each x (n,)."""
    return np.asarray(kernel.rho(np.subtract.outer(np.asarray(x, dtype=float), z)).sum(axis=-1))


def _rings(ax: Axes, x: ArrayLike, y: ArrayLike) -> None:
    """Draw broad grey rings at the true places, named once only."""
    label = "_" if names_truth(ax) else "the truth"
    look = {"markersize": 15.0, "markeredgewidth": 4.0, "alpha": 0.5}
    (rings,) = ax.plot(x, y, "o", color=PALETTE["muted"], markerfacecolor="none", label=label)
    rings.set(**look)
