"""Draw the parts of a certificate: eigenvalues, headings on a ring, gaps, and the staircase."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator
from numpy.typing import ArrayLike
from robust_slam._arrays import Array, finite
from robust_slam.groups import se2
from robust_slam.palette import PALETTE

from robust_slam_course.style import LOOKS

_NOUGHT = 1e-5
"""The share of the largest |eigenvalue| up to which one counts as 0."""
_ARROW = 0.42  # of the ring's radius: short enough to leave the words beside it free


def draw_spectrum(ax: Axes, eigenvalues: ArrayLike) -> Axes:
    """Draw eigenvalues (k,), largest first: dots above 0, rings at 0, crosses below 0.

    A 0 is what is at most 1e-5 of the largest size. The legend counts the three kinds.
    """
    values = np.sort(finite("eigenvalues", eigenvalues, (-1,)))[::-1]
    small = _NOUGHT * np.abs(values).max(initial=0.0)
    place = np.arange(1, values.size + 1)
    for chosen, name, marker, color, style in (
        (values > small, "above 0", "o", PALETTE["estimate"], "full"),
        (np.abs(values) <= small, "at 0", "o", PALETTE["truth"], "none"),
        (values < -small, "below 0", "X", PALETTE["outlier"], "full"),
    ):
        if np.any(chosen):
            label = f"{np.count_nonzero(chosen)} {name}"
            (dots,) = ax.plot(place[chosen], values[chosen], marker, color=color, label=label)
            dots.set(fillstyle=style)
    ax.axhline(0.0, color=PALETTE["muted"], linestyle="-", linewidth=0.8, zorder=1.0)
    ax.xaxis.set_major_locator(MaxNLocator(nbins=5, integer=True))
    ax.set(xlabel="by size")
    return ax


def draw_ring(ax: Axes, angles: ArrayLike) -> Axes:
    """Draw headings (n,) in rad on a ring, and at each edge by how many degrees it is missed.

    Each pose is measured to have the heading of the one before it.
    """
    heading = finite("angles", angles, (-1,))
    n = heading.size
    around = 2.0 * np.pi * np.arange(n) / n
    spot = np.column_stack([np.cos(around), np.sin(around)])
    circle = np.linspace(0.0, 2.0 * np.pi, 121)
    ax.plot(np.cos(circle), np.sin(circle), "-", color=PALETTE["muted"], linewidth=1.0)
    ax.plot(*spot.T, "o", color=PALETTE["estimate"])
    arrow = _ARROW * np.column_stack([np.cos(heading), np.sin(heading)])
    style = {"arrowstyle": "-|>", "color": PALETTE["estimate"], "linewidth": 2.0, "shrinkA": 0}
    for place, tip in zip(spot, spot + arrow, strict=True):
        ax.annotate("", tip, place, arrowprops=style)
    missed = np.degrees(se2.wrap(np.roll(heading, -1) - heading))
    for k, misfit in enumerate(missed):
        middle = around[k] + np.pi / n
        place = (1.32 * np.cos(middle), 1.32 * np.sin(middle))
        text = f"{round(misfit)}°".replace("-", "−")
        ax.text(*place, text, ha="center", va="center", color=PALETTE["truth"])
    ax.set(xlim=(-1.65, 1.65), ylim=(-1.65, 1.65), aspect="equal")
    ax.set_axis_off()
    return ax


def draw_gaps(ax: Axes, noise: ArrayLike, gaps: ArrayLike, names: Sequence[str]) -> Axes:
    """Draw gaps (k, m) over noise (k,), one line for each of m draws."""
    across = finite("noise", noise, (-1,))
    up = finite("gaps", gaps, (across.size, len(names)))
    for look, name, line in zip(LOOKS[1:], names, up.T, strict=False):
        (drawn,) = ax.plot(across, line, **look.line, label=name)
        drawn.set(marker=look.marker, markersize=5.0, linewidth=1.5)
    return ax


def draw_climb(ax: Axes, levels: Sequence[ArrayLike], ranks: Sequence[int]) -> Axes:
    """Draw the costs of a staircase, step by step, one line for each rank.

    A level (k,) begins where the one before it ended. Its rank and its last cost stand at
    its end.
    """
    if len(levels) != len(ranks):
        raise ValueError(f"ranks: there are {len(ranks)} for {len(levels)} levels")
    begin = 0
    for look, level, rank in zip(LOOKS[1:], levels, ranks, strict=False):
        costs: Array = finite("levels", level, (-1,))
        steps = np.arange(begin, begin + costs.size)
        ax.plot(steps, costs, **look.line)
        ax.plot(steps[-1], costs[-1], look.marker, color=look.color)
        side = "left" if costs.size == 1 else "right"
        text, end = f"rank {rank}: {abs(costs[-1]):.2f}", (steps[-1], costs[-1])
        ax.annotate(text, end, (6, 8), textcoords="offset points", ha=side)
        begin = int(steps[-1])
    ax.set(xlabel="step", ylabel="cost")
    return ax
