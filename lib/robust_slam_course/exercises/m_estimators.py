"""Pictures for assignment 01: influence, weight, where the pulls balance, how a pull ends."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import ArrayLike
from robust_slam._arrays import Array
from robust_slam.estimators.kernels import (
    Function,
    Kernel,
    cauchy,
    geman_mcclure,
    huber,
    squared,
    tls,
    welsch,
)
from robust_slam.estimators.reweighting import irls
from robust_slam.palette import PALETTE
from robust_slam.problems import LocationProblem

from robust_slam_course.exercises import draw_beside, once_it_works

THREE = (squared(), huber(1.0), cauchy(1.0))
SIX = (squared(), huber(50.0), cauchy(1.0), geman_mcclure(1.0), welsch(1.0), tls(1.0))
GOOD = np.array([-0.2, -0.1, 0.1, 0.15])
"""Readings that agree; a fifth one moves away from them."""


@once_it_works
def influence(student: Callable[[Function, Array], ArrayLike]) -> Figure:
    """Draw the slopes that the student measured over the true influences."""
    u = np.linspace(-6.0, 6.0, 121)
    figure = _three(u, [kernel.psi(u) for kernel in THREE], [student(k.rho, u) for k in THREE])
    figure.supxlabel("whitened residual u", fontsize=11)
    figure.supylabel("influence ψ(u)", fontsize=11)
    figure.suptitle("Unbounded, bounded and redescending influence", fontsize=11)
    return figure


@once_it_works
def weight(student: Callable[[Function, Array], ArrayLike]) -> Figure:
    """Draw the student's weights over the true ones; the middle of the grid is u = 0 itself."""
    u = np.linspace(-6.0, 6.0, 121)
    figure = _three(u, [kernel.weight(u) for kernel in THREE], [student(k.psi, u) for k in THREE])
    figure.axes[0].set(ylim=(-0.05, 1.25))
    figure.supxlabel("whitened residual u", fontsize=11)
    figure.supylabel("weight w(u)", fontsize=11)
    figure.suptitle("Every weight is 1 at u = 0, and no curve has a gap there", fontsize=11)
    return figure


@once_it_works
def location(student: Callable[..., float]) -> Figure:
    """Draw the estimate over the place of one reading that moves away from four others."""
    places = np.linspace(0.0, 10.0, 41)

    def yours(kernel: Kernel) -> list[float]:
        rows = (np.append(GOOD, place) for place in places)
        return [float(student(z, 0.5, kernel.weight, np.mean(z), 1e-9)) for z in rows]

    truth = [[_estimate(kernel, place) for place in places] for kernel in THREE]
    figure = _three(places, truth, [yours(kernel) for kernel in THREE])
    figure.supxlabel("position of the fifth measurement", fontsize=11)
    figure.supylabel("estimate x", fontsize=11)
    figure.suptitle("One measurement moves away from four: does x follow?", fontsize=11)
    return figure


@once_it_works
def classify(student: Callable[[Function], str]) -> Figure:
    """Draw six influences far out, each with the student's word and whether it is right."""
    u = np.logspace(-2.0, 8.0, 401)
    figure = Figure(figsize=(5.6, 4.4))
    axes = figure.subplots(2, 3, sharex=True)
    for ax, kernel in zip(axes.flat, SIX, strict=True):
        word = student(kernel.psi)
        is_right = word == kernel.influence
        ax.loglog(u, np.maximum(kernel.psi(u), 1e-9), "-", color=PALETTE["estimate"])
        verdict = f"✓ {word}" if is_right else f"✗ not {word}"
        colour = PALETTE["truth"] if is_right else PALETTE["outlier"]
        ax.set_title(f"{kernel.label}\n{verdict}", color=colour)
        ax.set(ylim=(1e-9, 1e9), xticks=[1e0, 1e4, 1e8], yticks=[1e-8, 1e0, 1e8])
        ax.minorticks_off()
    figure.supxlabel("whitened residual u", fontsize=11)
    figure.supylabel("influence ψ(u)", fontsize=11)
    figure.suptitle("Look at the right edge: up, level or down?", fontsize=11)
    return figure


def _three(x: Array, truth: Sequence[ArrayLike], yours: Sequence[ArrayLike]) -> Figure:
    """Draw the square's, Huber's and Cauchy's curves, each in a panel of its own."""
    figure = Figure(figsize=(5.6, 3.2))
    axes = figure.subplots(1, 3, sharey=True)
    for ax, kernel, true, own in zip(axes, THREE, truth, yours, strict=True):
        draw_beside(ax, x, true, np.asarray(own, dtype=float))
        ax.set_title(kernel.label)
    axes[0].legend(handlelength=1.5)
    return figure


def _estimate(kernel: Kernel, place: float) -> float:
    return irls(LocationProblem(np.append(GOOD, place), 0.5), kernel, tol=1e-9).x
