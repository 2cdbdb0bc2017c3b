"""Draw in how many runs methods come through: a disc for each kind of trouble and each rate.

A full ring is a method that always comes through, an empty one that never does. Area tells,
and not colour, so that many methods that are equally good hide each other nowhere.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection
from numpy.typing import ArrayLike
from robust_slam._arrays import Array

from robust_slam_course.style import PALETTE

_RING = 0.84  # of the distance between rows
_GAP = 1.0  # columns between two kinds


def draw_shares(
    ax: Axes, kinds: Sequence[str], rates: Sequence[str], shares: Mapping[str, ArrayLike]
) -> Axes:
    """Draw each method's shares (kinds, rates), from 0 to 1: a row of discs in their rings.

    Columns stand in one block for each kind, in it one for each rate. A share of NaN, nothing
    was run, has no ring.

    Raises:
        ValueError: a method's shares do not have one row for each kind and one column for each
            rate, or a share is not from 0 to 1.
    """
    place = _places(len(kinds), len(rates))
    table = np.array([_checked(name, value, place.shape) for name, value in shares.items()])
    for number, row in enumerate(table):
        run = np.isfinite(row)
        at = np.stack([place[run], np.full(run.sum(), number)], axis=1)
        _draw_discs(ax, at, np.full(len(at), _RING), "none", PALETTE["muted"])
        _draw_discs(ax, at, _RING * np.sqrt(row[run]), PALETTE["estimate"], "none")
    ax.set_yticks(range(len(table)), list(shares))
    ax.set_xticks(place.ravel(), list(rates) * len(kinds))
    for block, kind in zip(place, kinds, strict=True):
        ax.text(block.mean(), -0.8, kind, ha="center", va="bottom")
    ax.set(xlim=(-0.7, place.max() + 0.7), ylim=(len(table) - 0.4, -0.7), aspect="equal")
    ax.tick_params(length=0, labelsize=9)
    ax.spines[:].set_visible(False)
    ax.grid(False)
    return ax


def _places(kinds: int, rates: int) -> Array:
    """Return where the columns stand, ``(kinds, rates)``."""
    return np.arange(rates) + (rates + _GAP) * np.arange(kinds)[:, None]


def _checked(name: str, value: ArrayLike, shape: tuple[int, ...]) -> Array:
    row = np.asarray(value, dtype=np.float64)
    if row.shape != shape:
        raise ValueError(f"shares: those of {name} have shape {row.shape}; give {shape}")
    if np.any((row < 0.0) | (row > 1.0)):
        raise ValueError(f"shares: one of {name} is not from 0 to 1")
    return row


def _draw_discs(ax: Axes, at: Array, width: Array, face: str, edge: str) -> None:
    discs = EllipseCollection(
        width,
        width,
        np.zeros(len(at)),
        offsets=at,
        units="xy",
        offset_transform=ax.transData,
        facecolors=face,
        edgecolors=edge,
        linewidths=0.8,
    )
    ax.add_collection(discs)
