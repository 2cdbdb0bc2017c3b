"""Pictures for assignment 04: landscapes, their minima, and where descents from them end.

The spread σ of a measurement is 1.
"""

from collections.abc import Callable

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike
from robust_slam._arrays import Array
from robust_slam.estimators.kernels import Kernel, cauchy, squared, tls
from robust_slam.estimators.reweighting import irls
from robust_slam.palette import MARKERS, PALETTE
from robust_slam.problems import LocationProblem

from robust_slam_course.exercises import Settings, draw_beside, draw_truth, picture
from robust_slam_course.style import LOOKS

Rho = Callable[[ArrayLike], Array]

PAIR = np.array([0.0, 10.0])
CROWD = np.append(np.zeros(20), 10.0)
TWO_GROUPS = np.array([0.0, 0.0, 10.0, 10.0, 10.0])
_PLACE = "x; the measurements are at 0 and 10"


@picture("One bowl for the square, two wells for TLS", _PLACE, "cost")
def cost(ax: Axes, landscape: Callable[[ArrayLike, ArrayLike, Rho], ArrayLike]) -> None:
    """Draw the pair's landscape under three kernels."""
    x = np.linspace(-4.0, 14.0, 361)
    kernels = (squared(), cauchy(2.0), tls(3.0))
    for kernel, scale, look in zip(kernels, (0.1, 1.0, 1.0), LOOKS[1:], strict=False):
        yours = scale * np.asarray(landscape(x, PAIR.copy(), kernel.rho), dtype=float)
        name = f"yours, {kernel.label}" + (" / 10" if scale < 1.0 else "")
        draw_beside(ax, x, scale * _height(x, PAIR, kernel), yours, **look.line, label=name)
    ax.set(ylim=(0.0, 18.0))
    ax.legend(loc="upper center", ncols=2)


@picture(
    "The two wells draw together; from c = 5 on they are one",
    _PLACE,
    "cost, relative to its highest",
)
def local_minima(ax: Axes, find: Callable[[ArrayLike, Rho, float, float], ArrayLike]) -> None:
    """Draw the pair's Cauchy landscapes, a ring at each true minimum and a mark at each found."""
    x = np.linspace(-2.0, 12.0, 281)
    for c, look in zip((1.0, 3.0, 4.5, 6.0), LOOKS[1:], strict=False):
        kernel = cauchy(c)
        highest = float(np.max(_height(x, PAIR, kernel)))
        half = np.sqrt(max(25.0 - c**2, 0.0))
        truth = np.unique([5.0 - half, 5.0 + half])
        yours = np.asarray(find(PAIR.copy(), kernel.rho, -2.0, 12.0), dtype=float).reshape(-1)
        ax.plot(x, _height(x, PAIR, kernel) / highest, "-", color=look.color, linewidth=1.2)
        _draw_rings(ax, truth, _height(truth, PAIR, kernel) / highest)
        found = _height(yours, PAIR, kernel) / highest
        ax.plot(yours, found, look.marker, color=look.color, label=f"yours, c = {c:g}")
    ax.legend(loc="lower center", ncols=2)
    ax.set_ylim(bottom=-0.15)


@picture("Twenty at 0, one at 10: the start decides, and so does c", "start x₀", "end x")
def tls_descent(ax: Axes, descend: Callable[[ArrayLike, float, float], float]) -> None:
    """Draw the end of the descent against its start, for twenty at 0 and one at 10."""
    starts = np.linspace(-3.95, 13.95, 180)
    for c, look in zip((3.0, 9.0), LOOKS[1:], strict=False):
        truth = [irls(LocationProblem(CROWD), tls(c), float(x0)).x for x0 in starts]
        yours = [float(descend(CROWD.copy(), c, float(x0))) for x0 in starts]
        draw_beside(ax, starts, truth, yours, **look.line, label=f"yours, c = {c:g}")
    ax.legend(loc="upper left")


@picture(
    "Seven starts, and the lowest of their ends",
    "x; two measurements at 0, three at 10",
    "TLS cost, c = 2",
)
def best_of(ax: Axes, best: Callable[[ArrayLike, float, ArrayLike], float]) -> None:
    """Draw descents from seven starts in one landscape, and the end that is chosen."""
    kernel, x = tls(2.0), np.linspace(-4.0, 14.0, 361)
    starts = np.array([-3.0, -1.0, 1.5, 5.0, 6.5, 8.5, 11.0])
    ends = np.array([irls(LocationProblem(TWO_GROUPS), kernel, float(x0)).x for x0 in starts])
    yours = np.array([float(best(TWO_GROUPS.copy(), 2.0, starts.copy()))])
    high, costs, chosen = (_height(at, TWO_GROUPS, kernel) for at in (starts, ends, yours))
    ax.plot(x, _height(x, TWO_GROUPS, kernel), "-", color=PALETTE["odometry"], linewidth=1.2)
    _draw_rings(ax, ends[[np.argmin(costs)]], costs[[np.argmin(costs)]])
    ax.plot(starts, high, "o", color=PALETTE["estimate"], markerfacecolor="white", label="starts")
    ax.plot(ends, costs, "D", color=PALETTE["estimate"], markersize=4.0, label="ends")
    ax.plot(yours, chosen, MARKERS["outlier"], color=PALETTE["outlier"], label="yours")
    ax.set_ylim(bottom=3.0)
    ax.legend(loc="lower center", ncols=2)


def _height(x: ArrayLike, z: Array, kernel: Kernel) -> Array:
    """Return the cost Σρ(x − z) at each x (n,)."""
    return np.asarray(kernel.rho(np.subtract.outer(np.asarray(x, dtype=float), z)).sum(axis=-1))


def _draw_rings(ax: Axes, x: ArrayLike, y: ArrayLike) -> None:
    """Draw broad grey rings at the true places."""
    rings: Settings = {"linestyle": "", "linewidth": 2.0, "marker": "o", "markerfacecolor": "none"}
    draw_truth(ax, x, y, **rings, markersize=15.0, markeredgewidth=4.0, alpha=0.5)
