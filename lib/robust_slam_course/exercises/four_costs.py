"""Pictures for assignment 02: three costs, the table for any threshold, convexity, thresholds.

Every function takes a student's own, of the same name, and draws it dashed or as markers
over the library's, which is broad and grey. u is a whitened residual, without unit.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import ArrayLike
from robust_slam._arrays import Array
from robust_slam.estimators import kernels
from robust_slam.palette import PALETTE

from robust_slam_course.exercises import draw_beside, once_it_works, shaped
from robust_slam_course.plots.kernels import draw_curvatures, draw_norm_densities, kernel_look

Curve = Callable[[Array, float], ArrayLike]
Row = tuple[str, Callable[[Array], Array], Curve]
"""What is drawn, the truth, and the student's."""
Cost = Callable[[ArrayLike], ArrayLike]

_NAMES = ("squared", "huber", "cauchy", "tls")
_SMOOTH = (kernels.cauchy(1.0), kernels.geman_mcclure(1.0), kernels.welsch(1.0))


@once_it_works
def rho_huber(rho: Curve, psi: Curve, weight: Curve) -> Figure:
    """Draw Huber's cost, influence and weight at k = 1.345."""
    return _three(
        kernels.huber(1.345), rho, psi, weight, "Past k = 1.345 the pull no longer grows"
    )


@once_it_works
def rho_cauchy(rho: Curve, psi: Curve, weight: Curve) -> Figure:
    """Draw Cauchy's cost, influence and weight at c = 1."""
    title = "Past c = 1 the pull fades, but never to nothing"
    return _three(kernels.cauchy(1.0), rho, psi, weight, title)


@once_it_works
def rho_tls(rho: Curve, weight: Curve) -> Figure:
    """Draw the cost and weight of truncated least squares at c = 2, with or without the ½."""
    kernel = kernels.tls(2.0)
    has_no_half = np.allclose(rho(np.array([1.0, 9.0]), 2.0), [1.0, 4.0])

    def cost(u: Array) -> Array:
        return kernel.rho(u) * (2.0 if has_no_half else 1.0)

    rows: list[Row] = [("cost ρ", cost, rho), ("weight w", kernel.weight, weight)]
    return _curves(rows, kernel.scale, "Past c = 2 there is no pull at all")


@once_it_works
def table(student: Callable[[float], ArrayLike]) -> Figure:
    """Draw the table's last two columns for thresholds from 0.3 to 30."""
    thresholds = np.geomspace(0.3, 30.0, 41)
    yours = np.array([np.asarray(student(float(c)), dtype=float) for c in thresholds])
    truth = np.array([_table(c) for c in thresholds])
    figure = Figure(figsize=(5.6, 4.6))
    axes = figure.subplots(2, 1, sharex=True)
    for ax, column, what in zip(axes, (2, 3), ("ρ(10)/ρ(1)", "w(10)"), strict=True):
        for row, name in enumerate(_NAMES):
            draw_beside(ax, thresholds, truth[:, row, column], yours[:, row, column])
            ax.lines[-1].set(color=kernel_look(name).color, label=_label(name))
            ax.lines[-2].set(label="_again" if row else "the truth")
        ax.set(ylabel=what)
    axes[0].set_title("With a large c every cost is the square")
    axes[0].set(xscale="log", yscale="log")
    axes[1].set(xlabel="threshold c")
    axes[1].legend(loc="center left")
    return figure


@once_it_works
def convex_until(student: Callable[[Cost, float, float], float]) -> Figure:
    """Draw three curvatures, and lines where each turns negative according to the student."""
    figure = Figure(figsize=(5.6, 3.8))
    ax = draw_curvatures(figure.subplots(), _SMOOTH, 2.5)
    for kernel in _SMOOTH:
        found = float(student(kernel.rho, 0.1, 2.5))
        colour = kernel_look(kernel.name).color
        if np.isfinite(found):
            ax.axvline(found, color=colour, linestyle="--", linewidth=1.2)
            ax.text(found, 1.02, f"{found:.3f}", color=colour, ha="center", rotation=90)
    ax.set(ylim=(-0.6, 1.0))
    ax.set_title("Your lines cross ρ″ = 0 where each curve does", pad=42)
    ax.legend()
    return figure


@once_it_works
def threshold(student: Callable[[float, int], float]) -> Figure:
    """Draw how long inliers' residuals are, with the true thresholds and the student's at 0.99."""
    figure = Figure()
    ax = draw_norm_densities(figure.subplots(), (1, 3, 6), 0.99)
    found = [float(student(0.99, d)) for d in (1, 3, 6)]
    ax.plot(found, np.zeros(3), "D", color=PALETTE["accent"], clip_on=False, label="yours")
    ax.set(xlim=(0.0, max(5.2, *found) + 0.1))
    for number in ax.texts:  # upright they stay apart, however far out the student's are
        number.set(rotation=90.0, verticalalignment="bottom")
    ax.set_title("One residual in a hundred is right of its line", pad=42)
    ax.legend(loc="center right")
    return figure


def _three(kernel: kernels.Kernel, rho: Curve, psi: Curve, weight: Curve, title: str) -> Figure:
    """Draw a kernel's cost, influence and weight above one another."""
    rows: list[Row] = [
        ("cost ρ", kernel.rho, rho),
        ("influence ψ", kernel.psi, psi),
        ("weight w", kernel.weight, weight),
    ]
    return _curves(rows, kernel.scale, title)


def _curves(rows: Sequence[Row], scale: float, title: str) -> Figure:
    """Draw each row's curve, the truth's and the student's, above one another."""
    figure = Figure(figsize=(5.6, 1.3 + 1.2 * len(rows)))
    # An even number of points: no point is on a jump.
    u = np.linspace(-5.0, 5.0, 400)
    axes = figure.subplots(len(rows), 1, sharex=True)
    for ax, (what, truth, yours) in zip(axes, rows, strict=True):
        draw_beside(ax, u, truth(u), shaped(yours(u, scale), u.shape))
        ax.set(ylabel=what)
        for side in (-scale, scale):
            ax.axvline(side, color=PALETTE["muted"], linestyle=":", linewidth=1.2, zorder=0)
    axes[0].set_title(title)
    axes[0].legend(loc="upper center")
    axes[-1].set(xlabel="whitened residual u")
    return figure


def _table(c: float) -> Array:
    """Return the library's own table (4, 4) at one threshold."""
    rows = []
    for name in _NAMES:
        kernel = kernels.KERNELS[name](c)
        near, far = kernel.rho(np.array([1.0, 10.0]))
        rows.append([near, far, far / near, float(kernel.weight(10.0))])
    return np.array(rows)


def _label(name: str) -> str:
    return f"yours, {kernels.KERNELS[name](1.0).label}"
