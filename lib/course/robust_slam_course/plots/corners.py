"""Draw a street corner as a camera sees it: one building that two streets may have."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.patches import ConnectionPatch
from robust_slam._arrays import Array
from robust_slam.palette import PALETTE

_DEPTH, _EYE, _HEIGHT = 6.0, 1.6, 7.0  # m: how far the corner is, how high the camera and the roof
_SIDES = np.array([[-1.0, 1.0], [1.0, 1.0]]) / np.sqrt(2.0)
_COLUMNS, _FLOORS = (0.7, 2.1, 3.5), (2.9, 4.9)  # m: windows along a wall, and above the street
_WIDE, _TALL, _LONG = 0.8, 1.2, 5.0  # m: a window, and a wall
_SHOP = (0.5, 0.7, 4.1, 1.6)  # m: a shop window, along the wall, above the street, wide and tall
_LAMP = np.array([[-2.6, 4.5, 0.0], [-2.6, 4.5, 3.6], [-2.2, 4.5, 3.9], [-1.9, 4.5, 3.6]])  # m


@dataclass(frozen=True)
class View:
    """Where a camera stands: ``aside`` (m) of the corner's axis, turned by ``turn`` (rad)."""

    aside: float
    turn: float

    def project(self, points: Array) -> Array:
        """Return where a pinhole camera with focal length 1 sees points ``(k, 3)``, ``(k, 2)``."""
        x, y, z = points.T
        x = x - self.aside
        cos, sin = np.cos(self.turn), np.sin(self.turn)
        ahead, right = cos * y + sin * x, cos * x - sin * y
        return np.stack([right / ahead, (z - _EYE) / ahead], axis=1)


def building() -> tuple[list[Array], Array]:
    """Return the lines ``(k, 3)`` of a house, and the corners of its windows ``(p, 3)``, in m."""
    lines, features = [], []
    for side in _SIDES:
        for height in (0.0, _HEIGHT):
            lines.append(_on_wall(side, np.array([[0.0, height], [_LONG, height]])))
        panes = [(s, t, _WIDE, _TALL) for s in _COLUMNS for t in _FLOORS]
        for s, t, wide, tall in [*panes, _SHOP]:
            ring = np.array([[s, t], [s + wide, t], [s + wide, t + tall], [s, t + tall], [s, t]])
            lines.append(_on_wall(side, ring))
            features.append(lines[-1][:-1])
    lines.append(np.array([[0.0, _DEPTH, 0.0], [0.0, _DEPTH, _HEIGHT]]))
    return lines, np.concatenate(features)


def _on_wall(side: Array, places: Array) -> Array:
    """Return points ``(k, 3)`` at ``places`` (along the wall, above the street), ``(k, 2)``."""
    foot = np.array([0.0, _DEPTH]) + places[:, :1] * side
    return np.concatenate([foot, places[:, 1:]], axis=1)


def draw_look_alikes(axes: Sequence[Axes]) -> None:
    """Draw the house in two streets, in two panels, and join every seventh pair of features."""
    here = draw_corner(axes[0], View(aside=-0.3, turn=0.02), "lamp")
    there = draw_corner(axes[1], View(aside=0.5, turn=-0.06), "tree")
    for one, other in zip(here[::7], there[::7], strict=True):
        match = ConnectionPatch(
            one, other, "data", "data", axesA=axes[0], axesB=axes[1], color=PALETTE["inlier"]
        )
        axes[0].figure.add_artist(match)


def draw_corner(ax: Axes, view: View, beside: Literal["lamp", "tree"]) -> Array:
    """Draw the house as ``view`` sees it, with a lamp or a tree; return its features ``(p, 2)``.

    The features, the corners of its windows, are drawn as circles.
    """
    lines, features = building()
    house = [view.project(line) for line in lines]
    ax.add_collection(LineCollection(house, colors=PALETTE["truth"], linewidths=1.2))
    seen = view.project(features)
    ax.plot(*seen.T, "o", markersize=3.5, markerfacecolor="none", color=PALETTE["inlier"])
    for line in [_LAMP] if beside == "lamp" else _tree():
        ax.plot(*view.project(line).T, color=PALETTE["estimate"], linestyle="-")
    ax.set(xlim=(-0.8, 0.8), ylim=(-0.45, 1.0), aspect="equal")
    ax.set_axis_off()
    return seen


def _tree() -> list[Array]:
    turn = np.linspace(0.0, 2.0 * np.pi, 40)
    crown = np.stack([2.9 + 0.5 * np.cos(turn), np.full(40, 4.5), 2.9 + np.sin(turn)], axis=1)
    return [np.array([[2.9, 4.5, 0.0], [2.9, 4.5, 1.9]]), crown]
