"""Pictures for assignment 02: three costs, the table for any threshold, convexity, thresholds."""

from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike
from robust_slam._arrays import Array
from robust_slam.estimators import kernels
from robust_slam.palette import PALETTE

from robust_slam_course.exercises import draw_beside, picture, shaped
from robust_slam_course.plots.kernels import draw_curvatures, draw_norm_densities, kernel_look

Curve = Callable[[Array, float], ArrayLike]
Row = tuple[str, Callable[[Array], Array], Curve]
"""What is drawn, the truth, and the student's."""
Cost = Callable[[ArrayLike], ArrayLike]

_NAMES = ("squared", "huber", "cauchy", "tls")
_SMOOTH = (kernels.cauchy(1.0), kernels.geman_mcclure(1.0), kernels.welsch(1.0))


@picture(height=4.9, nrows=3, sharex=True)
def rho_huber(axes: Sequence[Axes], rho: Curve, psi: Curve, weight: Curve) -> None:
    """Draw Huber's cost, influence and weight at k = 1.345."""
    axes[0].set_title("Past k = 1.345 the pull no longer grows")
    _draw_kernel(axes, kernels.huber(1.345), rho, psi, weight)


@picture(height=4.9, nrows=3, sharex=True)
def rho_cauchy(axes: Sequence[Axes], rho: Curve, psi: Curve, weight: Curve) -> None:
    """Draw Cauchy's cost, influence and weight at c = 1."""
    axes[0].set_title("Past c = 1 the pull fades, but never to nothing")
    _draw_kernel(axes, kernels.cauchy(1.0), rho, psi, weight)


@picture(height=3.7, nrows=2, sharex=True)
def rho_tls(axes: Sequence[Axes], rho: Curve, weight: Curve) -> None:
    """Draw the cost and weight of truncated least squares at c = 2, with or without the ½."""
    kernel = kernels.tls(2.0)
    has_no_half = np.allclose(rho(np.array([1.0, 9.0]), 2.0), [1.0, 4.0])

    def cost(u: Array) -> Array:
        return kernel.rho(u) * (2.0 if has_no_half else 1.0)

    axes[0].set_title("Past c = 2 there is no pull at all")
    _draw_rows(axes, [("cost ρ", cost, rho), ("weight w", kernel.weight, weight)], kernel.scale)


@picture(height=4.6, nrows=2, sharex=True)
def table(axes: Sequence[Axes], student: Callable[[float], ArrayLike]) -> None:
    """Draw the table's last two columns for thresholds from 0.3 to 30."""
    thresholds = np.geomspace(0.3, 30.0, 41)
    yours = np.array([np.asarray(student(float(c)), dtype=float) for c in thresholds])
    for row, name in enumerate(_NAMES):
        known = [kernels.KERNELS[name](c) for c in thresholds]
        ratio = [float(kernel.rho(10.0) / kernel.rho(1.0)) for kernel in known]
        far = [float(kernel.weight(10.0)) for kernel in known]
        look = {"color": kernel_look(name).color, "label": f"yours, {known[0].label}"}
        for ax, column, truth in zip(axes, (2, 3), (ratio, far), strict=True):
            draw_beside(ax, thresholds, truth, yours[:, row, column], **look)
    axes[0].set(title="With a large c every cost is the square", ylabel="ρ(10)/ρ(1)")
    axes[0].set(xscale="log", yscale="log")
    axes[1].set(xlabel="threshold c", ylabel="w(10)")
    axes[1].legend(loc="center left")


@picture(height=3.8)
def convex_until(ax: Axes, student: Callable[[Cost, float, float], float]) -> None:
    """Draw three curvatures, and lines where each turns negative according to the student."""
    draw_curvatures(ax, _SMOOTH, 2.5)
    for kernel in _SMOOTH:
        found = float(student(kernel.rho, 0.1, 2.5))
        colour = kernel_look(kernel.name).color
        if np.isfinite(found):
            ax.axvline(found, color=colour, linestyle="--", linewidth=1.2)
            ax.text(found, 1.02, f"{found:.3f}", color=colour, ha="center", rotation=90)
    ax.set(ylim=(-0.6, 1.0))
    ax.set_title("Your lines cross ρ″ = 0 where each curve does", pad=42)
    ax.legend()


@picture()
def threshold(ax: Axes, student: Callable[[float, int], float]) -> None:
    """Draw how long inliers' residuals are, with the true thresholds and the student's at 0.99."""
    draw_norm_densities(ax, (1, 3, 6), 0.99)
    found = [float(student(0.99, d)) for d in (1, 3, 6)]
    ax.plot(found, np.zeros(3), "D", color=PALETTE["accent"], clip_on=False, label="yours")
    ax.set(xlim=(0.0, max(5.2, *found) + 0.1))
    for number in ax.texts:  # upright they stay apart, however far out the student's are
        number.set(rotation=90.0, verticalalignment="bottom")
    ax.set_title("One residual in a hundred is right of its line", pad=42)
    ax.legend(loc="center right")


def _draw_kernel(
    axes: Sequence[Axes], kernel: kernels.Kernel, rho: Curve, psi: Curve, weight: Curve
) -> None:
    """Draw a kernel's cost, influence and weight above one another."""
    rows = [("cost ρ", kernel.rho, rho), ("influence ψ", kernel.psi, psi)]
    _draw_rows(axes, [*rows, ("weight w", kernel.weight, weight)], kernel.scale)


def _draw_rows(axes: Sequence[Axes], rows: Sequence[Row], scale: float) -> None:
    """Draw each row's curve, the truth's and the student's, above one another."""
    # An even number of points: no point is on a jump.
    u = np.linspace(-5.0, 5.0, 400)
    for ax, (what, truth, yours) in zip(axes, rows, strict=True):
        draw_beside(ax, u, truth(u), shaped(yours(u, scale), u.shape))
        ax.set(ylabel=what)
        for side in (-scale, scale):
            ax.axvline(side, color=PALETTE["muted"], linestyle=":", linewidth=1.2, zorder=0)
    axes[0].legend(loc="upper center")
    axes[-1].set(xlabel="whitened residual u")
