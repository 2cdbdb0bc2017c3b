"""Draw the whole machine: from the camera to the map and back to the wheels, in stages.

A stage is a box, and an arrow says what one hands to the next. Rows go down the page; a stage
stands left, right or in the middle, or goes across both branches.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from matplotlib.axes import Axes
from matplotlib.patches import FancyBboxPatch
from robust_slam.palette import PALETTE

_X = {"left": 2.4, "right": 7.6, "middle": 5.0, "across": 5.0}
_WIDTH = {"left": 4.4, "right": 4.4, "middle": 4.4, "across": 9.6}
_HEIGHT = 0.52
_GROUND = "Under every box: poses L1 L2 · steps L10 · least squares L9"


@dataclass(frozen=True)
class Stage:
    """A box: its name, the lessons that teach it, its row from above and its place there."""

    name: str
    lessons: str
    row: int
    place: str


STAGES: dict[str, Stage] = {
    "sensors": Stage("Camera, IMU", "L5 L11", 0, "middle"),
    "features": Stage("Features, tracks", "L6", 1, "middle"),
    "views": Stage("Two views", "L7", 2, "left"),
    "places": Stage("Place recognition", "L12", 2, "right"),
    "ransac": Stage("RANSAC", "L8", 3, "across"),
    "odometry": Stage("Odometry (VIO)", "L11", 4, "left"),
    "pcm": Stage("Consistency (PCM)", "L14", 4, "right"),
    "solve": Stage("Factor graph, robust solve", "L13 L14", 5, "across"),
    "certificate": Stage("Certificate", "L14", 6, "middle"),
    "plan": Stage("Trajectory", "L4", 7, "left"),
    "control": Stage("Control", "L3", 7, "right"),
}
"""Every stage, in the order in which a picture comes through."""

DOWN = (
    ("sensors", "features", 5.0, "images"),
    ("features", "views", 3.8, "tracks"),
    ("features", "places", 6.2, "words"),
    ("views", "ransac", 1.5, "$E = [t]_\\times R$"),
    ("places", "ransac", 6.2, "candidates"),
    ("ransac", "odometry", 1.5, "$R$, direction of $t$"),
    ("ransac", "pcm", 6.2, "closures, some are outliers"),
    ("odometry", "solve", 1.5, "odometry edges"),
    ("pcm", "solve", 6.2, "closures that agree"),
    ("solve", "certificate", 5.0, "map"),
    ("certificate", "plan", 3.8, "map, verdict"),
)
"""From, to, the x (of 10) at which the arrow runs down, and what it carries."""

_ARROW = {"arrowstyle": "-|>", "color": PALETTE["odometry"], "shrinkA": 0, "shrinkB": 0}


def draw_stages(ax: Axes) -> Axes:
    """Draw the machine; each arrow says what it carries."""
    for source, target, x, carried in DOWN:
        start, end = -STAGES[source].row - _HEIGHT / 2, -STAGES[target].row + _HEIGHT / 2
        ax.annotate("", (x, end), (x, start), arrowprops=_ARROW)
        ax.text(x + 0.15, (start + end) / 2, carried, va="center", fontsize=10)
    _draw_ways_round(ax)
    for stage in STAGES.values():
        _draw_box(ax, stage)
    ax.text(5.0, -7.85, _GROUND, ha="center", va="center", fontsize=10, style="italic")
    ax.set(xlim=(-0.4, 10.4), ylim=(-8.15, 0.4))
    ax.set_axis_off()
    return ax


def _draw_box(ax: Axes, stage: Stage) -> None:
    x, y, width = _X[stage.place], -float(stage.row), _WIDTH[stage.place]
    corner, style = (x - width / 2, y - _HEIGHT / 2), "round,pad=0,rounding_size=0.12"
    box = ax.add_patch(FancyBboxPatch(corner, width, _HEIGHT, boxstyle=style, zorder=3))
    box.set(facecolor="white", edgecolor=PALETTE["truth"], linewidth=0.9)
    ax.text(x, y - 0.02, f"{stage.name} · {stage.lessons}", ha="center", va="center", zorder=4)


def _draw_ways_round(ax: Axes) -> None:
    """Draw what skips stages: the IMU's way to the odometry, and the robot that moves on."""
    left, right = -0.15, 10.15
    line: dict[str, Any] = {"color": PALETTE["odometry"], "linewidth": 1.0, "linestyle": "-"}
    ax.plot([2.8, left, left], [0.0, 0.0, -4.0], **line)
    ax.annotate("", (0.2, -4.0), (left, -4.0), arrowprops=_ARROW)
    ax.annotate("", (5.4, -7.0), (4.6, -7.0), arrowprops=_ARROW)
    ax.plot([9.8, right, right], [-7.0, -7.0, 0.0], **line)
    ax.annotate("", (7.2, 0.0), (right, 0.0), arrowprops=_ARROW)
    ax.text(-0.1, 0.1, "IMU", va="bottom", fontsize=10)
    ax.text(10.1, 0.1, "the robot moves", va="bottom", ha="right", fontsize=10)
    ax.text(5.0, -7.12, "path", va="top", ha="center", fontsize=10)
