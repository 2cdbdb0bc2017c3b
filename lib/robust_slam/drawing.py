"""Draw a pose graph as a map, in the plane or in space seen from above.

The path is a thick line, a closure a thin one, a wrong closure dashed, the truth dotted, and a
wrong decision has a marker at its middle: so colour is never the only sign.
"""

from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from robust_slam._arrays import Array, Indices, mask
from robust_slam.graphs.pose_graph import PoseGraph, check_graph, check_poses
from robust_slam.palette import LINESTYLES, PALETTE, LineStyle

try:
    import matplotlib.pyplot as plt
    from matplotlib.axes import Axes
    from matplotlib.legend import Legend
    from matplotlib.lines import Line2D
except ImportError as error:
    raise ImportError("maps are drawn by Matplotlib: pip install matplotlib") from error

_FAINTEST = 0.15  # opacity of an edge of weight 0: rejected, and still to be seen
_SHADES = 255  # screens tell no more apart, and each shade is one line to draw


@dataclass(frozen=True)
class Look:
    """How an edge is drawn; ``middle`` is a marker at its middle."""

    label: str
    color: str
    linestyle: LineStyle
    linewidth: float
    zorder: float
    middle: str = ""

    def style(self) -> dict[str, Any]:
        """Return the settings of matplotlib's line."""
        parts = asdict(self)
        return {key: parts[key] for key in ("color", "linestyle", "linewidth", "zorder")}


_TRUTH = Look("true path", PALETTE["muted"], LINESTYLES["truth"], 1.6, 1.0)
PATH = Look("estimated path", PALETTE["estimate"], LINESTYLES["estimate"], 2.2, 4.0)
CLOSURE = Look("loop closure", PALETTE["inlier"], LINESTYLES["inlier"], 1.0, 2.0)
WRONG = Look("wrong closure", PALETTE["outlier"], LINESTYLES["outlier"], 1.8, 3.0)
_ODOMETRY = replace(PATH, label="odometry")
_KEPT = replace(CLOSURE, label="kept")
_REJECTED = Look("rejected", PALETTE["muted"], (0.0, (7.0, 6.0)), 0.9, 1.5)
_TRUE_KEPT = replace(CLOSURE, label="inlier, kept")
_TRUE_REJECTED = Look(
    "inlier, rejected", PALETTE["accent"], (0.0, (4.0, 1.5, 1.0, 1.5)), 1.6, 3.1, "s"
)
_WRONG_KEPT = replace(WRONG, label="outlier, kept", zorder=3.2, middle="X")
_WRONG_REJECTED = replace(_REJECTED, label="outlier, rejected")
_LOOKS = (PATH, CLOSURE, WRONG, _ODOMETRY, _KEPT, _REJECTED)
_JUDGED = (_TRUE_KEPT, _TRUE_REJECTED, _WRONG_KEPT, _WRONG_REJECTED)


def draw_map(
    graph: PoseGraph,
    poses: ArrayLike,
    ax: Axes | None = None,
    *,
    is_outlier: ArrayLike | None = None,
    kept: ArrayLike | None = None,
    weights: ArrayLike | None = None,
    truth: ArrayLike | None = None,
) -> Axes:
    """Draw a map: the path, its closures, and dotted where the robot really was.

    ``poses`` and ``truth`` are ``(n, 3)`` or ``(n, 3, 4)``, seen from above. The mask
    ``is_outlier`` ``(m,)`` marks the wrong edges; ``weights`` ``(m,)`` in [0, 1] fade the edges.
    With the mask ``kept`` ``(m,)`` the map shows decisions, right and wrong ones, and
    ``legend_below(ax)`` names and counts them. Both axes share one scale, and the map
    has neither frame nor ticks. Without ``ax`` a new figure is made.

    Raises:
        TypeError: ``graph`` is not a pose graph.
        ValueError: an argument does not fit the graph.
    """
    # All is checked first: a figure that was made in vain would stay open.
    xy = _from_above("poses", poses, graph)
    true_xy = None if truth is None else _from_above("truth", truth, graph)
    m = len(graph.edges)
    looks = edge_looks(m, graph.is_odometry, is_outlier, kept)
    opacity = _FAINTEST + (1.0 - _FAINTEST) * _rows("weights", weights, m, 1.0)
    ax = plt.subplots()[1] if ax is None else ax
    if true_xy is not None:
        ax.plot(*true_xy.T, **_TRUTH.style(), label=None if kept is None else _TRUTH.label)
    for look in (look for look in _LOOKS + _JUDGED if look in looks):
        chosen = np.array([own is look for own in looks], dtype=bool)
        label = None if kept is None else f"{look.label} ({np.count_nonzero(chosen)})"
        _draw_edges(ax, xy, graph.edges[chosen], look, opacity[chosen], label)
    ax.plot(*xy[0], "o", color=PATH.color, zorder=5)
    ax.set_aspect("equal", adjustable="box")
    ax.set_axis_off()
    return ax


def legend_below(ax: Axes) -> Legend:
    """Put the legend of a map with decisions below it, where it hides no edge."""
    return ax.legend(loc="upper center", bbox_to_anchor=(0.5, 0.0), ncols=2)


def map_legend() -> list[Line2D]:
    """Return the handles of a legend: path, closure, wrong closure, true path."""
    looks = (PATH, CLOSURE, WRONG, _TRUTH)
    return [Line2D([], [], **look.style(), label=look.label) for look in looks]


def decision_legend() -> list[Line2D]:
    """Return the handles of a legend for maps with decisions, in which the path has no count."""
    looks = (PATH, *_JUDGED, _TRUTH)
    return [Line2D([], [], **look.style(), marker=look.middle, label=look.label) for look in looks]


def _rows(name: str, value: ArrayLike | None, count: int, default: float = 0.0) -> Array:
    array = np.asarray(np.full(count, default) if value is None else value, dtype=np.float64)
    if array.ndim == 0 or len(array) != count:
        raise ValueError(f"{name}: the shape is {array.shape}; give {count} rows")
    return array


def _from_above(name: str, poses: ArrayLike, graph: PoseGraph) -> Array:
    """Return the first two coordinates ``(n, 2)`` of the positions, in m."""
    return check_graph(graph).group.translation(check_poses(name, poses, graph))[:, :2]


def edge_looks(
    m: int,
    is_odometry: ArrayLike,
    is_outlier: ArrayLike | None = None,
    kept: ArrayLike | None = None,
) -> list[Look]:
    """Return the look of each of ``m`` edges: of its kind or, with ``kept``, of the decision.

    The masks are ``(m,)``.

    Raises:
        ValueError: a mask does not have one row for each edge.
    """
    wrong = _rows("is_outlier", is_outlier, m) > 0.0
    steps = _rows("is_odometry", is_odometry, m) > 0.0
    if kept is None:
        return [
            WRONG if bad else PATH if own else CLOSURE
            for bad, own in zip(wrong, steps, strict=True)
        ]
    decided = {(False, True): _TRUE_KEPT, (False, False): _TRUE_REJECTED}
    decided |= {(True, True): _WRONG_KEPT, (True, False): _WRONG_REJECTED}
    if is_outlier is None:
        decided = {(False, True): _KEPT, (False, False): _REJECTED}
    stays = mask("kept", kept, m)
    return [
        _ODOMETRY if own and stay and not bad else decided[bool(bad), bool(stay)]
        for own, stay, bad in zip(steps, stays, wrong, strict=True)
    ]


def _draw_edges(
    ax: Axes, xy: Array, edges: Indices, look: Look, opacity: Array, label: str | None
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
