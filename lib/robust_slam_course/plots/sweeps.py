"""Draw how methods fare as something gets harder: the middle run, and from best to worst."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike
from robust_slam._arrays import finite

from robust_slam_course.style import LOOKS

_APART = 0.1  # of a place's width: methods with equal numbers still stand side by side


def draw_sweep(ax: Axes, levels: Sequence[str], scores: Mapping[str, ArrayLike]) -> Axes:
    """Draw each method's scores (runs, levels): a line of medians, a bar from best to worst.

    Every level has a place of its own, named by its text in `levels`. Scores are above 0, on a
    logarithmic axis. A method keeps its colour, line and marker by its position.

    Raises:
        ValueError: a method's scores do not have one column for each level, or there are more
            methods than looks.
    """
    if len(scores) > len(LOOKS):
        raise ValueError(f"scores: {len(scores)} methods; at most {len(LOOKS)} can be told apart")
    place = np.arange(len(levels))
    for number, (name, value) in enumerate(scores.items()):
        runs = finite(name, value, (-1, len(levels)))
        look, middle = LOOKS[number], np.median(runs, axis=0)
        at = place + _APART * (number - 0.5 * (len(scores) - 1))
        ax.vlines(at, runs.min(axis=0), runs.max(axis=0), color=look.color, linewidth=1.4)
        ax.plot(
            at,
            middle,
            color=look.color,
            linestyle=look.linestyle,
            marker=look.marker,
            linewidth=1.4,
            label=name,
        )
    ax.set_xticks(place, levels)
    ax.set_yscale("log")
    return ax
