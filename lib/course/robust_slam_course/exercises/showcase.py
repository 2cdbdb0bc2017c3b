"""Pictures for assignment 08: poses, residuals, gradients, maps and their errors.

A graph goes to a student's functions as a dict of arrays.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike
from robust_slam import descent as solver
from robust_slam._arrays import Array, Mask, finite
from robust_slam.drawing import draw_map, legend_below
from robust_slam.graphs import metrics, pose_graph
from robust_slam.graphs.odometry import spanning_tree
from robust_slam.graphs.pose_graph import PoseGraph
from robust_slam.groups import se2
from robust_slam.palette import PALETTE
from robust_slam.problems import PoseGraphProblem

from robust_slam_course.exercises import Settings, as_dict, draw_beside, draw_truth, picture, town

Graph = Mapping[str, Any]
Solve = Callable[..., tuple[Array, Array]]

_MARKED: Settings = {"marker": "o", "linestyle": "", "color": PALETTE["estimate"]}
_C = 5.0


@picture("Seen from the robot, a level ellipse leans", "ahead (m)", "left (m)")
def between(ax: Axes, student: Callable[[Array, Array], ArrayLike]) -> None:
    """Draw a round of poses as a robot sees it that stands among them."""
    turn = np.linspace(0.0, 2.0 * np.pi, 9)
    around = np.stack([4.0 * np.cos(turn), 2.0 * np.sin(turn), turn], axis=1)
    here = np.broadcast_to([2.0, 1.0, 0.8], around.shape)
    truth, yours = se2.between(here, around), finite("poses", student(here.copy(), around), (9, 3))
    draw_truth(ax, *truth[:, :2].T)
    ax.plot(*yours[:, :2].T, **_MARKED, label="yours")
    ax.quiver(*yours[:, :2].T, np.cos(yours[:, 2]), np.sin(yours[:, 2]), width=0.008)
    ax.plot(0.0, 0.0, ">", color=PALETTE["outlier"], label="the robot")
    ax.set_aspect("equal")
    ax.legend(loc="center")


@picture(
    "One outlier bends many edges beside it",
    "edge: odometry first, closures last",
    "norm u, whitened",
)
def residuals(ax: Axes, student: Callable[[Array, Graph], ArrayLike]) -> None:
    """Draw the whitened norm of every edge of the least-squares map with one outlier."""
    graph, is_outlier, _ = town(1)
    poses = PoseGraphProblem(graph).initial()
    yours = finite("residuals", student(poses, as_dict(graph)), (len(graph.edges), 3))
    norms = np.sqrt(np.einsum("ka,kab,kb->k", yours, graph.information, yours))
    place, truth = np.arange(len(norms)), pose_graph.residual_norms(graph, poses)
    ax.bar(place, truth, color=PALETTE["muted"], alpha=0.5, label="the truth")
    ax.plot(place, norms, **_MARKED, label="yours")
    wrong = place[is_outlier], norms[is_outlier]
    ax.plot(*wrong, "X", color=PALETTE["outlier"], label="the outlier")
    ax.legend(loc="upper left")


@picture("A slope touches its curve where nothing has moved yet", ncols=2, sharey=True)
def jacobians(
    axes: Sequence[Axes], student: Callable[[Array, Array, Array], tuple[ArrayLike, ArrayLike]]
) -> None:
    """Draw how a residual changes as each pose turns, and the straight line of the slope."""
    i, j, z = np.array([0.0, 0.0, 0.0]), np.array([2.0, 1.0, 1.2]), np.array([1.0, 0.0, 0.0])
    slopes = [finite("jacobian", matrix, (3, 3))[:, 2] for matrix in student(i, j, z)]
    step = np.linspace(-1.5, 1.5, 41)
    turns = np.stack([0.0 * step, 0.0 * step, step], axis=1)
    moved = (
        se2.between(se2.compose(i, se2.exp(turns)), j),
        se2.between(i, se2.compose(j, se2.exp(turns))),
    )
    for ax, seen, slope, name in zip(axes, moved, slopes, "ij", strict=True):
        error = se2.log(se2.between(z, seen))
        for part, label in enumerate(("ρx", "ρy", "θ")):
            draw_beside(ax, step, error[:, part], error[20, part] + slope[part] * step)
            ax.text(1.6, error[-1, part], label, va="center")
        ax.set(xlabel=f"pose {name} turns by (rad)", title=f"turning pose {name}")
        ax.set(xlim=(-1.6, 2.1))
    axes[0].set(ylabel="residual")
    axes[0].legend(axes[0].lines[:2], ["the truth", "your slope"], loc="upper right")


@picture("The closures pull the way back", "x (m)", "y (m)", height=4.4)
def gauss_newton(
    ax: Axes,
    student: Callable[[Graph, Array, Array, float], ArrayLike],
    graph: PoseGraph | None = None,
) -> None:
    """Draw dead reckoning, in a town if no graph is given, and the map of least cost."""
    graph = town(0)[0] if graph is None else graph
    first, ones = spanning_tree(graph), np.ones(len(graph.edges))
    truth = solver.gauss_newton(graph, first)
    yours = finite("poses", student(as_dict(graph), first.copy(), ones, 1e-9), (graph.n, 3))
    ax.plot(*first[:, :2].T, ":", color=PALETTE["truth"], label="dead reckoning")
    draw_truth(ax, *truth[:, :2].T)
    ax.plot(*yours[:, :2].T, "--", color=PALETTE["estimate"], label="yours")
    ax.set_aspect("equal")
    ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))


@picture("No outlier should be kept", height=5.2)
def robust_solve(
    ax: Axes,
    student: Callable[[Graph, float, Solve], tuple[Any, ArrayLike]],
    made: tuple[PoseGraph, Mask, Array] | None = None,
) -> None:
    """Draw the map with outliers, ten if none are given, with the closures that were kept."""
    graph, is_outlier, truth = made or town(10)
    poses, weights = student(as_dict(graph), _C, _solve)
    kept: Mask = finite("weights", weights, (len(graph.edges),)) > 0.5
    draw_map(graph, poses, ax, truth=truth, kept=kept, is_outlier=is_outlier)
    legend_below(ax)


@picture(nrows=2, sharex=True)
def precision_recall(
    axes: Sequence[Axes], student: Callable[[Mask, Mask], tuple[float, float]]
) -> None:
    """Draw precision and recall of closures that are kept up to a threshold on their norm."""
    graph, is_outlier, truth = town(10)
    loops = ~graph.is_odometry
    u, true = pose_graph.residual_norms(graph, truth)[loops], ~is_outlier[loops]
    u[~true] = np.random.default_rng(3).uniform(1.5, 12.0, int(np.sum(~true)))
    at = np.linspace(0.0, 12.0, 61)
    right = np.array([metrics.precision_recall(u <= c, true) for c in at])
    yours = finite("shares", [student(u <= c, true) for c in at], (len(at), 2))
    for ax, row, name in zip(axes, (0, 1), ("precision", "recall"), strict=True):
        draw_beside(ax, at, right[:, row], yours[:, row])
        ax.set(ylabel=name, ylim=(-0.05, 1.1))
    axes[1].set(xlabel="closures are kept up to this norm")
    axes[0].set_title("Keep more: recall rises, precision falls")
    axes[1].legend(loc="lower right")


@picture("No drift, no error, wherever the map is", "turned too far at each step (rad)", "ATE (m)")
def ate(ax: Axes, student: Callable[[Array, Array], float]) -> None:
    """Draw the error of a square way whose odometry turns a little too far at each step."""
    drift = np.linspace(0.0, 0.05, 26)
    square = _drive(0.0)
    drives = [se2.compose([3.0, 1.0, 2.0], _drive(each)) for each in drift]
    yours = [float(student(one, square.copy())) for one in drives]
    draw_beside(ax, drift, [metrics.ate(one, square) for one in drives], yours)
    ax.legend()


def _solve(graph: Graph, weights: ArrayLike, poses: ArrayLike | None) -> tuple[Array, Array]:
    """Solve with the library: the poses, and the whitened norm of every edge."""
    known = PoseGraph(**graph)
    first = spanning_tree(known) if poses is None else poses
    found = solver.gauss_newton(known, first, weights)
    return found, pose_graph.residual_norms(known, found)


def _drive(drift: float) -> Array:
    """Return poses round a square of 24 steps, each turned by ``drift`` (rad) too far."""
    corner = np.where(np.arange(24) % 6 == 5, np.pi / 2, 0.0)
    steps = np.stack([np.ones(24), np.zeros(24), corner + drift], axis=1)
    poses = [se2.identity()]
    for step in steps:
        poses.append(se2.compose(poses[-1], step))
    return np.array(poses)
