"""Pictures for assignment 00: the cost, the normal equations, the map and its strained edges."""

from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle
from numpy.typing import ArrayLike
from robust_slam._arrays import Array, Mask
from robust_slam.palette import MARKERS, PALETTE
from robust_slam.problems import chain

from robust_slam_course.exercises import Settings, draw_beside, picture, shaped
from robust_slam_course.plots.chain import draw_chain

THREE = ([0, 1, 0, 0], [1, 2, 2, 2], [1.0, 1.0, 2.0, 0.0], [0.1, 0.1, 0.05, 0.05])
FIVE = ([0, 1, 2, 3, 1], [1, 2, 3, 4, 3], [1.0, 1.0, 1.0, 1.0, 0.0], [0.1, 0.1, 0.1, 0.1, 0.05])
"""The chapter's graphs as i, j, z, sigma; the last edge of each is the outlier."""
TOLERANCE = 3.0
_CROSS: Settings = {"color": PALETTE["outlier"], "marker": MARKERS["outlier"], "linestyle": ""}


@picture(
    "One outlier in four edges, and half the true length costs less",
    "length of the map, x₂ − x₀",
    "cost",
)
def total_cost(ax: Axes, student: Callable[..., float]) -> None:
    """Draw the cost of the chapter's three poses over the length of the map."""
    problem, lengths = chain(3, *THREE), np.linspace(-0.5, 2.5, 61)
    places = [np.array([0.0, length / 2, length]) for length in lengths]
    truth = [np.sum(problem.residuals(x) ** 2) for x in places]
    draw_beside(ax, lengths, truth, [float(student(x, *THREE)) for x in places])
    ax.plot(18 / 17, 14400 / 17, MARKERS["inlier"], color=PALETTE["inlier"], label="lowest: 847")
    ax.plot(2, 1600, **_CROSS, label="the true map: 1600")
    ax.set(ylim=(0, 6000))
    ax.legend(loc="upper left")


@picture("Each row of H adds up to 0: a shift costs nothing", height=3.2, ncols=2)
def normal_equations(
    axes: Sequence[Axes], student: Callable[..., tuple[ArrayLike, ArrayLike]]
) -> None:
    """Write H and b of the chapter's three poses, with a frame round what differs."""
    problem = chain(3, *THREE)
    whitened = problem.jacobian / problem.sigma[:, None]
    b = whitened.T @ (problem.measurement / problem.sigma)
    truth = np.column_stack([whitened.T @ whitened, b])
    yours = np.column_stack([np.asarray(part, dtype=float) for part in student(3, *THREE)])
    for ax, table, name in zip(axes, (truth, yours), ("truth", "yours"), strict=True):
        _write_table(ax, table, np.isclose(table, truth, rtol=1e-6, atol=1e-9))
        ax.set_title(f"H | b, {name}")


@picture(height=3.8, nrows=2, sharex=True)
def solve_anchored(axes: Sequence[Axes], student: Callable[..., ArrayLike]) -> None:
    """Draw the map of the chapter's five poses, and below it the student's."""
    i, j, *_ = FIVE
    own = np.arange(5) < 4
    truth, yours = chain(5, *FIVE).initial(), shaped(student(5, *FIVE), (5,))
    for ax, x, name in zip(axes, (truth, yours), ("truth", "yours"), strict=True):
        draw_chain(ax, x, np.stack([i, j], axis=1), is_odometry=own, is_outlier=~own, named=False)
        ax.set_title(f"The map of least cost, {name}", loc="left")
    for place in truth:
        axes[1].axvline(place, color=PALETTE["muted"], linewidth=6, alpha=0.4, zorder=0)
    axes[1].set(xlabel="place; the first and the last step keep their length of 1")


@picture("Strained: the edges on the outlier's cycle, and no other")
def strained_edges(ax: Axes, student: Callable[[Array, float], ArrayLike]) -> None:
    """Draw the residuals of a chain with an outlier, and mark the student's strained edges."""
    edges = [(k, k + 1) for k in range(11)] + [(3, 8)]
    i, j = np.transpose(edges)
    problem = chain(12, i, j, np.append(np.ones(11), 0.0), np.append(np.full(11, 0.1), 0.05))
    u, place = problem.residuals(problem.initial()), np.arange(12)
    marked = shaped(student(u.copy(), TOLERANCE), (12,)) > 0
    ax.bar(place, u, color=PALETTE["muted"], alpha=0.5, label="residual u")
    ax.axhspan(-TOLERANCE, TOLERANCE, color=PALETTE["inlier"], alpha=0.15, label="within tol")
    ax.plot(place[marked], u[marked], **_CROSS, label="strained, you say")
    names = [f"{a}–{b}" for a, b in edges[:-1]]
    ax.set_xticks(place, [*names, "outlier 3–8"], rotation=60)
    ax.set(ylabel="whitened residual u", ylim=(-11, 11))
    ax.legend(loc="upper left")


def _write_table(ax: Axes, table: Array, is_right: Mask) -> None:
    """Write the numbers on fields shaded by their size, with a frame round those not right."""
    ax.imshow(table, cmap="PuOr", vmin=-1200.0, vmax=1200.0, alpha=0.6, aspect="auto")
    for (row, column), value in np.ndenumerate(table):
        ax.text(column, row, f"{value:.0f}".replace("-", "−"), ha="center", va="center")
        if not is_right[row, column]:
            corner, colour = (column - 0.45, row - 0.45), PALETTE["outlier"]
            ax.add_patch(Rectangle(corner, 0.9, 0.9, fill=False, linewidth=3, color=colour))
    ax.axvline(len(table) - 0.5, color="white", linewidth=4)
    ax.grid(visible=False)
    ax.set(xticks=[], yticks=[])
