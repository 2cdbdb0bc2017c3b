"""Draw how hard measurements pull, ψ(u): on a line, and as residuals grow without end."""

from collections.abc import Iterable

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator
from numpy.typing import ArrayLike
from robust_slam._arrays import Array, Mask, finite, mask
from robust_slam.estimators.kernels import Kernel
from robust_slam.palette import MARKERS, PALETTE

from robust_slam_course.plots.kernels import kernel_look

_HATCHES = {"inlier": "", "outlier": "///"}


def draw_line_fit(
    ax: Axes,
    p: ArrayLike,
    y: ArrayLike,
    line: tuple[float, float],
    truth: tuple[float, float],
    is_outlier: ArrayLike,
) -> Axes:
    """Draw readings y (m,) at places p (m,), their residuals, the fitted line and the true one.

    A line is (a, b) for a + b p. Outliers, where the mask (m,) is true, are crosses; a thin
    line leads from each reading to the fit.
    """
    places = finite("p", p, (-1,))
    readings = finite("y", y, places.shape)
    fit = line[0] + line[1] * places
    ends = np.array([places.min(), places.max()])
    ax.plot(ends, truth[0] + truth[1] * ends, ":", color=PALETTE["truth"], label="truth")
    ax.plot(ends, line[0] + line[1] * ends, "-", color=PALETTE["estimate"], label="fit")
    for name, chosen in _kinds(is_outlier, places.size):
        ax.vlines(places[chosen], fit[chosen], readings[chosen], colors=PALETTE[name], lw=1.0)
        at, colour = (places[chosen], readings[chosen]), PALETTE[name]
        ax.plot(*at, MARKERS[name], color=colour, label=name)
    return ax


def draw_pulls(ax: Axes, p: ArrayLike, pulls: ArrayLike, is_outlier: ArrayLike) -> Axes:
    """Draw each pull (m,) as a bar at its place p (m,), up or down; outliers are hatched.

    The pull of an outlier is printed above its bar.
    """
    places, heights = finite("p", p, (-1,)), finite("pulls", pulls, np.shape(p))
    for name, chosen in _kinds(is_outlier, places.size):
        at, height, hatch = places[chosen], heights[chosen], _HATCHES[name]
        ax.bar(at, height, width=0.7, color=PALETTE[name], edgecolor="white", hatch=hatch)
        if name == "outlier":
            for place, value in zip(at, height, strict=True):
                number = f"{value:.3f}".replace("-", "−")
                ax.text(place, max(value, 0.0), number, ha="center", va="bottom")
    ax.axhline(0.0, color=PALETTE["truth"], linewidth=0.8)
    ax.xaxis.set_major_locator(MaxNLocator(integer=True))
    ax.set(ylabel="pull ψ(u)")
    return ax


def draw_pull_ends(ax: Axes, kernels: Iterable[Kernel], decades: tuple[int, int]) -> Axes:
    """Draw ψ(u) of each kernel for u from one power of ten to another, both axes logarithmic.

    A power of u is a straight line here. A pull that is exactly 0 is left out.
    """
    u = np.logspace(*decades, 40 * (decades[1] - decades[0]) + 1)
    for kernel in kernels:
        pull: Array = kernel.psi(u)
        look, shown = kernel_look(kernel.name), pull > 0.0
        (line,) = ax.plot(u[shown], pull[shown], **look.line, label=kernel.label)
        line.set(marker=look.marker, markevery=(20, 80))  # a marker every two decades
    ax.set(xscale="log", yscale="log", xlabel="whitened residual u", ylabel="pull ψ(u)")
    return ax


def _kinds(is_outlier: ArrayLike, m: int) -> tuple[tuple[str, Mask], tuple[str, Mask]]:
    outlying = mask("is_outlier", is_outlier, m)
    return ("inlier", ~outlying), ("outlier", outlying)
