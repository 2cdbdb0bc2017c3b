"""Draw kernels: cost, influence, curvature, their majorisers, and the density of the norm."""

from collections.abc import Callable, Iterable, Mapping
from itertools import cycle

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike
from robust_slam._arrays import Array
from robust_slam.estimators.kernels import KERNELS, Kernel
from robust_slam.estimators.thresholds import chi_square_threshold
from robust_slam.palette import PALETTE
from scipy.special import gamma

from robust_slam_course.style import LOOKS, Look

_DIFFERENCE = 1e-6  # step of the one-sided difference behind a curvature


def kernel_look(name: str) -> Look:
    """Return the look of the kernel called `name`: the one at its place in `KERNELS`.

    Raises:
        ValueError: there is no kernel of that name.
    """
    if name not in KERNELS:
        raise ValueError(f"name: there is no kernel {name!r}; give one of {', '.join(KERNELS)}")
    return LOOKS[list(KERNELS).index(name) % len(LOOKS)]


def draw_costs(ax: Axes, kernels: Iterable[Kernel], u_max: float, mark: float) -> Axes:
    """Draw ρ(u) of each kernel for 0 ≤ u ≤ `u_max`, with a marker at u = `mark`."""
    for kernel in kernels:
        _draw_curve(ax, kernel, kernel.rho, u_max, mark)
    ax.set(xlabel="whitened residual u", ylabel="cost ρ(u)")
    return ax


def draw_influences(ax: Axes, kernels: Iterable[Kernel], u_max: float, mark: float) -> Axes:
    """Draw ψ(u) of each kernel for 0 ≤ u ≤ `u_max`, with a marker at u = `mark`."""
    for kernel in kernels:
        _draw_curve(ax, kernel, kernel.psi, u_max, mark)
    ax.set(xlabel="whitened residual u", ylabel="influence ψ(u)")
    return ax


def draw_curvatures(ax: Axes, kernels: Iterable[Kernel], u_max: float) -> Axes:
    """Draw ρ″(u) of each kernel for 0 ≤ u ≤ `u_max`, with a marker where convexity ends."""
    for kernel in kernels:
        _draw_curve(ax, kernel, _curvature(kernel), u_max, kernel.convex_until)
    ax.axhline(0.0, color=PALETTE["muted"], linewidth=0.8)
    ax.set(xlabel="whitened residual u", ylabel="curvature ρ″(u)")
    return ax


def draw_majoriser(ax: Axes, kernel: Kernel, touch: float, u_max: float) -> Axes:
    """Draw ρ for |u| ≤ `u_max` and the parabola that touches it at ±`touch` from above.

    The parabola is ρ(v) + w(v)(u² − v²)/2 with v = `touch`: a tangent of ρ over u².
    """
    u = np.linspace(-u_max, u_max, 401)
    parabola = kernel.rho(touch) + 0.5 * kernel.weight(touch) * (u**2 - touch**2)
    colour = kernel_look(kernel.name).color
    ax.plot(u, kernel.rho(u), "-", color=colour, label=f"{kernel.label} cost")
    ax.plot(u, parabola, "--", color=PALETTE["accent"], label="parabola above")
    height = np.full(2, kernel.rho(touch))
    ax.plot([-touch, touch], height, "o", color=PALETTE["accent"], label="they touch")
    ax.set(xlabel="whitened residual u", ylabel="cost")
    return ax


def draw_norm_densities(ax: Axes, dimensions: Iterable[int], probability: float) -> Axes:
    """Draw the density of the norm of a d-vector of unit Gaussians, one curve a dimension.

    A vertical line stands at each norm threshold that keeps the fraction `probability`.
    """
    u = np.linspace(0.0, 5.2, 209)
    for d, look in zip(dimensions, cycle(LOOKS), strict=False):
        threshold = chi_square_threshold(probability, d)
        density = 2 ** (1 - d / 2) / gamma(d / 2) * u ** (d - 1) * np.exp(-(u**2) / 2)
        ax.plot(u, density, **look.line, label=f"d = {d}")
        ax.axvline(threshold, 0.0, 0.93, **look.line, linewidth=1.2)
        text, across = f"{threshold:.2f}", ax.get_xaxis_transform()
        ax.text(threshold, 0.95, text, transform=across, ha="center")
    ax.set(xlabel="norm u of an inlier's whitened residual", ylabel="density")
    return ax


def draw_drift(ax: Axes, outlier: ArrayLike, estimates: Mapping[str, ArrayLike]) -> Axes:
    """Draw estimates (kernel name -> (m,)) against the value of the one wrong reading (m,)."""
    for name, estimate in estimates.items():
        label = KERNELS[name](1.0).label
        ax.plot(outlier, estimate, **kernel_look(name).line, label=label)
    ax.set(xlabel="place of the wrong reading", ylabel="estimate")
    return ax


def _draw_curve(
    ax: Axes, kernel: Kernel, curve: Callable[[Array], Array], u_max: float, mark: float
) -> None:
    """Draw a curve of a kernel, broken at jumps, and a marker on it if that is on the grid."""
    u = _grid(kernel.scale, u_max)
    look, values = kernel_look(kernel.name), curve(u)
    jump = np.abs(np.diff(values, prepend=values[0])) > 1e-3 + 1e3 * np.diff(u, prepend=u[0])
    ax.plot(u, np.where(jump, np.nan, values), **look.line, label=kernel.label)
    if mark <= u_max:
        ax.plot([mark], curve(np.array([mark])), look.marker, color=look.color, zorder=4)


def _grid(scale: float, u_max: float) -> Array:
    """Return 0 … u_max, dense near 0, with both sides of a possible kink at the scale."""
    u = u_max * np.linspace(0.0, 1.0, 65) ** 1.5
    if not 0.0 < scale < u_max:
        return u
    return np.unique(np.concatenate([u, [scale, scale * (1.0 + 1e-9)]]))


def _curvature(kernel: Kernel) -> Callable[[Array], Array]:
    """Return ρ″ as a one-sided difference of ψ that never crosses the scale."""

    def curve(u: Array) -> Array:
        side = np.where(np.abs(u) <= kernel.scale, -_DIFFERENCE, _DIFFERENCE)
        return (kernel.psi(u + side) - kernel.psi(u)) / side

    return curve
