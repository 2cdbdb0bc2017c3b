"""Draw how the weights of a robust solve went, step by step."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike
from robust_slam._arrays import Array, Mask, mask
from robust_slam.estimators.result import Step
from robust_slam.palette import LINESTYLES, MARKERS, PALETTE

_MOST_TICKS = 8
_FEW = 12  # so many lines still stand apart, and get markers


def draw_weight_history(
    ax: Axes,
    history: Sequence[Step[Any]],
    is_outlier: ArrayLike | None = None,
    shown: ArrayLike | None = None,
) -> Axes:
    """Draw each weight over the steps of a `Result.history`: outliers dashed, the others solid.

    The masks `is_outlier` and `shown` (m,) mark the outliers, and the measurements to draw (all by
    default). Step 0 is the start, with weights 1. Under each step stands its μ, if it has one.

    Raises:
        ValueError: a mask does not have one entry for each weight.
    """
    weights = np.array([step.weights for step in history])
    m = weights.shape[1]
    drawn = np.ones(m, dtype=bool) if shown is None else mask("shown", shown, m)
    wrong = mask("is_outlier", is_outlier, m)
    for name, label, chosen in (
        ("inlier", "inliers", drawn & ~wrong),
        ("outlier", "outliers", drawn & wrong),
    ):
        _draw_lines(ax, weights, chosen, name, f"{label} ({np.count_nonzero(chosen)})")
    ax.set(xlabel="step", ylabel="weight", ylim=(-0.04, 1.04))
    ax.set_xticks(*_ticks(history))
    return ax


def _draw_lines(ax: Axes, weights: Array, chosen: Mask, name: str, label: str) -> None:
    """Draw the chosen columns as one line with gaps, so that thousands are quick."""
    count = int(np.count_nonzero(chosen))
    if count == 0:
        return
    gap = np.full((1, count), np.nan)
    height = np.concatenate([weights[:, chosen], gap]).T.ravel()
    step = np.tile(np.append(np.arange(len(weights), dtype=float), np.nan), count)
    ax.plot(
        step,
        height,
        color=PALETTE[name],
        linestyle=LINESTYLES[name],
        marker=MARKERS[name] if count <= _FEW else "",
        linewidth=2.0 if count <= _FEW else 0.8,
        label=label,
    )


def _ticks(history: Sequence[Step[Any]]) -> tuple[list[int], list[str]]:
    every = max(1, -(-len(history) // _MOST_TICKS))
    places = list(range(0, len(history), every))
    values = [history[k].mu for k in places]
    names = [
        f"{k}" if mu is None else f"{k}\n{mu:.2g}" for k, mu in zip(places, values, strict=True)
    ]
    if any(mu is not None for mu in values):
        names[0] += "\nμ"
    return places, names
