"""Pictures for assignment 01: influence, weight, where the pulls balance, how a pull ends."""

from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike
from robust_slam._arrays import Array
from robust_slam.estimators import kernels
from robust_slam.estimators.kernels import Function
from robust_slam.estimators.reweighting import irls
from robust_slam.palette import PALETTE
from robust_slam.problems import LocationProblem

from robust_slam_course.exercises import READINGS, Panels, Settings, draw_beside, picture

THREE = (kernels.squared(), kernels.huber(1.0), kernels.cauchy(1.0))
SIX = (
    kernels.squared(),
    kernels.huber(50.0),
    kernels.cauchy(1.0),
    kernels.geman_mcclure(1.0),
    kernels.welsch(1.0),
    kernels.tls(1.0),
)
U = np.linspace(-6.0, 6.0, 121)
"""Residuals; the middle of the grid is 0 itself."""
_BESIDE: Settings = {"height": 3.2, "ncols": 3, "sharey": True}


@picture(
    "Unbounded, bounded and redescending influence",
    "whitened residual u",
    "influence ψ(u)",
    **_BESIDE,
)
def influence(axes: Sequence[Axes], student: Callable[[Function, Array], ArrayLike]) -> None:
    """Draw the slopes that the student measured over the true influences."""
    _draw_three(axes, U, [k.psi(U) for k in THREE], [student(k.rho, U) for k in THREE])


@picture(
    "Every weight is 1 at u = 0, and no curve has a gap there",
    "whitened residual u",
    "weight w(u)",
    **_BESIDE,
)
def weight(axes: Sequence[Axes], student: Callable[[Function, Array], ArrayLike]) -> None:
    """Draw the student's weights over the true ones."""
    _draw_three(axes, U, [k.weight(U) for k in THREE], [student(k.psi, U) for k in THREE])
    axes[0].set(ylim=(-0.05, 1.25))


@picture(
    "One measurement moves away from four: does x follow?",
    "position of the fifth measurement",
    "estimate x",
    **_BESIDE,
)
def location(axes: Sequence[Axes], student: Callable[..., float]) -> None:
    """Draw the estimate over the place of one reading that moves away from four others."""
    places = np.linspace(0.0, 10.0, 41)
    data = [np.append(READINGS[:4], place) for place in places]
    truth = [[irls(LocationProblem(z, 0.5), k, tol=1e-9).x for z in data] for k in THREE]
    yours = [[float(student(z, 0.5, k.weight, np.mean(z), 1e-9)) for z in data] for k in THREE]
    _draw_three(axes, places, truth, yours)


@picture(
    "Settings at the right edge: up, level or down?",
    "whitened residual u",
    "influence ψ(u)",
    height=4.4,
    nrows=2,
    ncols=3,
    sharex=True,
)
def classify(axes: Panels, student: Callable[[Function], str]) -> None:
    """Draw six influences far out, each with the student's word and whether it is right."""
    u = np.logspace(-2.0, 8.0, 401)
    for ax, kernel in zip(axes.flat, SIX, strict=True):
        word = student(kernel.psi)
        is_right = word == kernel.influence
        ax.loglog(u, np.maximum(kernel.psi(u), 1e-9), "-", color=PALETTE["estimate"])
        verdict = f"✓ {word}" if is_right else f"✗ not {word}"
        colour = PALETTE["truth"] if is_right else PALETTE["outlier"]
        ax.set_title(f"{kernel.label}\n{verdict}", color=colour)
        ax.set(ylim=(1e-9, 1e9), xticks=[1e0, 1e4, 1e8], yticks=[1e-8, 1e0, 1e8])
        ax.minorticks_off()


def _draw_three(
    axes: Sequence[Axes], x: Array, truth: Sequence[ArrayLike], yours: Sequence[ArrayLike]
) -> None:
    """Draw the square's, Huber's and Cauchy's curves, each in a panel of its own."""
    for ax, kernel, true, own in zip(axes, THREE, truth, yours, strict=True):
        draw_beside(ax, x, true, own)
        ax.set_title(kernel.label)
    axes[0].legend(handlelength=1.5)
