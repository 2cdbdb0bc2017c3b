"""Draw pose graphs: maps in the plane or seen from one side, and the 1-D chain with arcs.

Every function takes matplotlib axes and returns them. The path is a thick line, a closure a
thin one, a wrong closure dashed, the truth dotted, and a wrong decision has a marker at its
middle: so colour is never the only sign.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.legend import Legend
from matplotlib.lines import Line2D
from numpy.typing import ArrayLike
from robust_slam._arrays import Array, Indices, mask
from robust_slam.graphs.pose_graph import PoseGraph

from robust_slam_course.style import LINESTYLES, PALETTE, LineStyle

_FAINTEST = 0.15  # opacity of an edge of weight 0: rejected, and still to be seen
_SHADES = 255  # screens tell no more apart, and each shade is one line to draw


@dataclass(frozen=True)
class _Look:
    label: str
    color: str
    linestyle: LineStyle
    linewidth: float
    zorder: float
    middle: str = ""

    def style(self) -> dict[str, Any]:
        return {
            "color": self.color,
            "linestyle": self.linestyle,
            "linewidth": self.linewidth,
            "zorder": self.zorder,
        }


_TRUTH = _Look("true path", PALETTE["muted"], LINESTYLES["truth"], 1.6, 1.0)
_PATH = _Look("estimated path", PALETTE["estimate"], LINESTYLES["estimate"], 2.2, 4.0)
_CLOSURE = _Look("loop closure", PALETTE["inlier"], LINESTYLES["inlier"], 1.0, 2.0)
_LIE = _Look("wrong closure", PALETTE["outlier"], LINESTYLES["outlier"], 1.8, 3.0)
_KEPT = _Look("kept", PALETTE["inlier"], LINESTYLES["inlier"], 1.0, 2.0)
_REJECTED = _Look("rejected", PALETTE["muted"], (0.0, (7.0, 6.0)), 0.9, 1.5)
_TRUE_KEPT = _Look("true, kept", PALETTE["inlier"], LINESTYLES["inlier"], 1.0, 2.0)
_LIE_REJECTED = _Look("wrong, rejected", PALETTE["muted"], (0.0, (7.0, 6.0)), 0.9, 1.5)
_LIE_KEPT = _Look("wrong, kept", PALETTE["outlier"], LINESTYLES["outlier"], 1.8, 3.2, "X")
_TRUE_REJECTED = _Look(
    "true, rejected", PALETTE["accent"], (0.0, (4.0, 1.5, 1.0, 1.5)), 1.6, 3.1, "s"
)
_ODOMETRY = _Look("odometry", PALETTE["estimate"], LINESTYLES["estimate"], 2.2, 4.0)
_KINDS = (_PATH, _CLOSURE, _LIE)
_DECISIONS = (_ODOMETRY, _KEPT, _REJECTED, _TRUE_KEPT, _TRUE_REJECTED, _LIE_KEPT, _LIE_REJECTED)


def draw_map(
    ax: Axes,
    graph: PoseGraph,
    poses: ArrayLike,
    *,
    is_outlier: ArrayLike | None = None,
    weights: ArrayLike | None = None,
    truth: ArrayLike | None = None,
    kept: ArrayLike | None = None,
    view: tuple[int, int] = (0, 1),
) -> Axes:
    """Draw a map: the path, its closures, and dotted where the robot really was.

    `poses` and `truth` are (n, 3), or (n, 3, 4) in SE(3), drawn by the two coordinates of
    `view`: (0, 1) looks from above, (0, 2) from the side. The mask `is_outlier` (m,) marks the
    wrong edges; `weights` (m,) in [0, 1] fade the edges. With the mask `kept` (m,) the map shows
    decisions, right and wrong ones, and `legend_below(ax)` names and counts them. Both
    directions have one scale, and the frame and the ticks go.

    Raises:
        ValueError: an array does not have one row for each pose or edge, or the poses do not
            have the two coordinates of `view`.
    """
    m = len(graph.edges)
    xy = _positions("poses", poses, graph, view)
    looks = _looks(graph.is_odometry, is_outlier, m, kept)
    opacity = _FAINTEST + (1.0 - _FAINTEST) * _rows("weights", _or(weights, 1.0, m), m)
    if truth is not None:
        style = _TRUTH.style() | ({} if kept is None else {"label": _TRUTH.label})
        ax.plot(*_positions("truth", truth, graph, view).T, **style)
    for look in (look for look in _KINDS + _DECISIONS if look in looks):
        chosen = np.array([own is look for own in looks], dtype=bool)
        label = None if kept is None else f"{look.label} ({np.count_nonzero(chosen)})"
        _draw_edges(ax, xy, graph.edges[chosen], look, opacity[chosen], label)
    ax.plot(*xy[0], "o", color=_PATH.color, zorder=5)
    ax.set_aspect("equal", adjustable="box")
    ax.set_axis_off()
    return ax


def draw_chain(
    ax: Axes,
    x: ArrayLike,
    edges: ArrayLike,
    *,
    is_odometry: ArrayLike,
    is_outlier: ArrayLike | None = None,
    labels: Sequence[str] | None = None,
    named: bool = True,
    height: float = 0.0,
) -> Axes:
    """Draw poses x (n,) on a line at `height`: odometry along it, closures as arcs above it.

    `edges` is (m, 2), poses from 0; the wrong closures of the mask `is_outlier` (m,) are arcs
    below the line; `labels` (m,) are written at the middle of the edges. Poses are named x₁,
    x₂ …, unless `named` is False.

    Raises:
        ValueError: an array does not have one row for each edge.
    """
    at, ends = np.asarray(x, dtype=np.float64), np.asarray(edges)
    m = len(ends)
    looks = _looks(_rows("is_odometry", is_odometry, m), is_outlier, m)
    texts = [""] * m if labels is None else labels
    for look, (i, j), text in zip(looks, ends, texts, strict=True):
        _draw_arc(ax, at[i], at[j], height, look, text)
    ax.plot(at, np.full_like(at, height), "o", color=PALETTE["truth"], zorder=6)
    for k, position in enumerate(at if named else []):
        _name_pose(ax, f"$x_{k + 1}$", (position, height), at)
    ax.margins(x=0.1, y=0.3)
    ax.spines["left"].set_visible(False)
    ax.set(yticks=[])
    return ax


def legend_below(ax: Axes) -> Legend:
    """Put the legend of a map with decisions below it, where it hides no edge."""
    return ax.legend(loc="upper center", bbox_to_anchor=(0.5, 0.0), ncols=2)


def map_legend() -> list[Line2D]:
    """Return the handles of a legend: path, closure, wrong closure, true path."""
    looks = (_PATH, _CLOSURE, _LIE, _TRUTH)
    return [Line2D([], [], **look.style(), label=look.label) for look in looks]


def decision_legend() -> list[Line2D]:
    """Return the handles of a legend for maps with decisions about inliers and outliers."""
    looks = (_ODOMETRY, _TRUE_KEPT, _TRUE_REJECTED, _LIE_KEPT, _LIE_REJECTED, _TRUTH)
    return [Line2D([], [], **look.style(), marker=look.middle, label=look.label) for look in looks]


def _or(value: ArrayLike | None, default: float, m: int) -> ArrayLike:
    return np.full(m, default) if value is None else value


def _rows(name: str, value: ArrayLike, count: int) -> Array:
    array = np.asarray(value, dtype=np.float64)
    if array.ndim == 0 or len(array) != count:
        raise ValueError(f"{name}: the shape is {array.shape}; give {count} rows")
    return array


def _positions(name: str, poses: ArrayLike, graph: PoseGraph, view: tuple[int, int]) -> Array:
    """Return the two coordinates (n, 2) of `view`, in m."""
    dimension = graph.group.DIMENSION
    if len(view) != 2 or not all(axis in range(dimension) for axis in view):
        raise ValueError(f"view: it is {view}; give two axes, each from 0 to {dimension - 1}")
    return graph.group.translation(_rows(name, poses, graph.n))[:, list(view)]


def _looks(
    is_odometry: ArrayLike, is_outlier: ArrayLike | None, m: int, kept: ArrayLike | None = None
) -> list[_Look]:
    """Return the look of each edge: of its kind or, if `kept` is given, of what was decided."""
    wrong = _rows("is_outlier", _or(is_outlier, 0.0, m), m) > 0.0
    steps = _rows("is_odometry", is_odometry, m) > 0.0
    if kept is None:
        return [
            _LIE if bad else _PATH if own else _CLOSURE
            for bad, own in zip(wrong, steps, strict=True)
        ]
    decided = {(False, True): _TRUE_KEPT, (False, False): _TRUE_REJECTED}
    decided |= {(True, True): _LIE_KEPT, (True, False): _LIE_REJECTED}
    if is_outlier is None:
        decided = {(False, True): _KEPT, (False, False): _REJECTED}
    stays = mask("kept", kept, m)
    return [
        _ODOMETRY if own and stay and not bad else decided[bool(bad), bool(stay)]
        for own, stay, bad in zip(steps, stays, wrong, strict=True)
    ]


def _draw_edges(
    ax: Axes,
    xy: Array,
    edges: Indices,
    look: _Look,
    opacity: Array,
    label: str | None,
) -> None:
    """Draw edges of one kind, those of one shade as a single line with gaps."""
    shade = np.round(opacity * _SHADES) / _SHADES
    for alpha in np.unique(shade):
        ends = xy[edges[shade == alpha]]
        gaps = np.full((len(ends), 1, 2), np.nan)
        x, y = np.concatenate([ends, gaps], axis=1).reshape(-1, 2).T
        style = look.style() | ({"label": label} if label else {})
        if look.middle:
            # The marker of a wrong decision stands at the middle of its edge.
            x, y = np.insert(ends, 1, ends.mean(axis=1), axis=1).reshape(-1, 2).T
            x, y = (np.insert(v, range(3, v.size + 1, 3), np.nan) for v in (x, y))
            style |= {"marker": look.middle, "markevery": slice(1, None, 4)}
        ax.plot(x, y, **style, alpha=float(alpha), solid_capstyle="round")
        label = None


def _draw_arc(ax: Axes, start: float, end: float, height: float, look: _Look, text: str) -> None:
    """Draw half an ellipse from start to end: flat for odometry, below for the outlier."""
    rise = 0.0 if look is _PATH else -0.5 if look is _LIE else 0.5
    turn = np.linspace(0.0, np.pi, 41)
    across = 0.5 * (start + end) - 0.5 * (end - start) * np.cos(turn)
    ax.plot(across, height + rise * np.sin(turn), **look.style())
    if text:
        anchor = (0.5 * (start + end), height + rise)
        offset = (0, -5 if look is _LIE or look is _PATH else 5)
        align = "top" if offset[1] < 0 else "bottom"
        ax.annotate(text, anchor, offset, textcoords="offset points", ha="center", va=align)


def _name_pose(ax: Axes, name: str, where: tuple[float, float], everyone: Array) -> None:
    """Write the name above the pose, or outside the chain at its two ends, clear of the arcs."""
    offset, align, base = (0, 6), "center", "bottom"
    if where[0] == everyone.min():
        offset, align, base = (-8, 0), "right", "center"
    elif where[0] == everyone.max():
        offset, align, base = (8, 0), "left", "center"
    ax.annotate(name, where, offset, textcoords="offset points", ha=align, va=base)
