"""Pictures for assignment 06: switches, two modes, sets that agree and pairs that do."""

from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike
from robust_slam._arrays import Array, Mask, finite
from robust_slam.consistency import cliques, pairwise
from robust_slam.drawing import draw_map
from robust_slam.estimators import kernels, switches, thresholds
from robust_slam.graphs import generate, outliers
from robust_slam.palette import PALETTE

from robust_slam_course.exercises import Settings, draw_beside, draw_truth, picture
from robust_slam_course.plots import ring, with_gaps

Curve = Callable[[Array, float], ArrayLike]

_SOLID: Settings = {"color": PALETTE["muted"], "linestyle": "-"}
_CHI2 = np.geomspace(0.01, 100.0, 121)
_LAM = 2.0
_Z = np.array([-0.4, -0.1, 0.2, 0.3, 0.1, 0.9, 5.0, 6.0])
_IS_LOOP = np.arange(8) > 3
_VOTES = ("05", "01", "02", "03", "04", "67", "68", "69", "78", "79", "89", "16", "27")
"""Pairs that agree: 0 has the most partners, and 6, 7, 8 and 9 are the largest set."""


@picture(height=5.0, nrows=2, sharex=True)
def switch(axes: Sequence[Axes], student: Curve, student_cost: Curve) -> None:
    """Draw the best switch over χ², and below it what the edge costs."""
    top, bottom = axes
    draw_beside(top, _CHI2, switches.switch(_CHI2, _LAM), student(_CHI2.copy(), _LAM))
    truth = switches.switched_cost(_CHI2, _LAM)
    draw_beside(bottom, _CHI2, truth, student_cost(_CHI2.copy(), _LAM))
    bottom.axhline(_LAM, color=PALETTE["odometry"], linestyle=":", label="λ")
    top.set(ylabel="switch s", title=f"λ = {_LAM:g}: the switch is ½ at χ² = λ, and never 0")
    bottom.set(xlabel="χ²", ylabel="cost", title="The cost stays below λ", xscale="log")
    top.legend()
    bottom.legend()


@picture(f"λ = {_LAM:g}: the weight falls off faster than the switch", "χ²", "weight")
def switch_weight(ax: Axes, student: Curve) -> None:
    """Draw the weight over χ², with the switch it comes from."""
    truth = kernels.geman_mcclure(np.sqrt(_LAM)).weight(np.sqrt(_CHI2))
    _draw_over_chi2(ax, "switch", truth, student)


@picture(f"Φ = {_LAM:g}: up to χ² = Φ the switch is 1", "χ²", "switch s")
def dcs_switch(ax: Axes, student: Curve) -> None:
    """Draw the switch of dynamic covariance scaling over χ², with the best switch."""
    _draw_over_chi2(ax, "λ = Φ", switches.dcs_switch(_CHI2, _LAM), student)


def _draw_over_chi2(ax: Axes, other: str, truth: Array, student: Curve) -> None:
    """Draw a curve over χ², with the best switch, which the legend calls ``other``."""
    ax.plot(_CHI2, switches.switch(_CHI2, _LAM), ":", color=PALETTE["odometry"], label=other)
    draw_beside(ax, _CHI2, truth, student(_CHI2.copy(), _LAM))
    ax.set(xscale="log")
    ax.legend()


@picture(
    "The higher of the two counts: they cross at |r| = 3.015",
    "r",
    "log of π N(r), up to a constant",
)
def max_mixture_mode(ax: Axes, student: Callable[[Array, float, float, float], ArrayLike]) -> None:
    """Draw the logarithms of both modes over r, and the mode that the student chooses."""
    r = np.linspace(-6.0, 6.0, 49)
    inner, outer, pi_in = 1.0, 10.0, 0.9
    inlier = np.log(pi_in / inner) - (r / inner) ** 2 / 2.0
    outlier = np.log((1.0 - pi_in) / outer) - (r / outer) ** 2 / 2.0
    mode = finite("mode", student(r.copy(), inner, outer, pi_in), r.shape)
    draw_truth(ax, r, np.maximum(inlier, outlier))
    ax.plot(r, inlier, color=PALETTE["inlier"], linestyle="-.", label="inlier mode")
    ax.plot(r, outlier, color=PALETTE["outlier"], linestyle=":", label="outlier mode")
    yours = np.where(mode == 0.0, inlier, outlier)
    ax.plot(r, yours, "o", color=PALETTE["estimate"], markersize=4.0, label="yours")
    ax.set(ylim=(-8.5, 0.5))
    ax.legend(loc="lower center")


@picture(height=5.0, nrows=2, sharex=True)
def solve_switchable(
    axes: Sequence[Axes], student: Callable[[Array, float, Mask, float], tuple[float, ArrayLike]]
) -> None:
    """Draw the cost that is left over x, and each measurement at the height of its switch."""
    top, bottom = axes
    x, s = student(_Z.copy(), 1.0, _IS_LOOP.copy(), _LAM)
    yours, s = float(x), finite("s", s, _Z.shape)
    grid = np.linspace(-1.0, 6.5, 301)
    truth = _left_cost(grid)
    draw_truth(top, grid, truth)
    top.plot(yours, _left_cost(np.array([yours])), "o", color=PALETTE["estimate"], label="yours")
    mean = float(np.mean(_Z))
    top.axvline(mean, color=PALETTE["odometry"], linestyle=":", label="least squares")
    top.set(ylabel="cost", ylim=(0.0, 45.0))
    top.set_title("x at the minimum: two loops have small switches")
    draw_truth(bottom, grid, switches.switch((grid - grid[np.argmin(truth)]) ** 2, _LAM), "")
    for chosen, name, marker, label in (
        (~_IS_LOOP, "odometry", "s", "trusted"),
        (_IS_LOOP, "estimate", "o", "loop"),
    ):
        at = _Z[chosen], s[chosen]
        bottom.plot(*at, marker, color=PALETTE[name], markersize=7.0, label=label)
    bottom.set(xlabel="x and z", ylabel="switch s", ylim=(-0.05, 1.1))
    top.legend(loc="lower right")
    bottom.legend(loc="center right")


def _left_cost(x: Array) -> Array:
    """Return the cost ``(k,)`` at each x, with optimal switches."""
    chi2 = (_Z - x[:, None]) ** 2
    cost = np.where(_IS_LOOP, switches.switched_cost(chi2, _LAM), chi2)
    return np.asarray(np.sum(cost, axis=1))


@picture("0 has the most partners; four others all agree", height=5.0)
def largest_consistent_set(ax: Axes, student: Callable[[Mask], ArrayLike]) -> None:
    """Draw the consistency graph as a ring, and the student's largest set."""
    joined = np.eye(10, dtype=np.bool_)
    for p, q in ((int(pair[0]), int(pair[1])) for pair in _VOTES):
        joined[p, q] = joined[q, p] = True
    truth = cliques.max_clique(joined).members
    yours = np.asarray(student(joined.copy()))
    if yours.ndim != 1 or not np.issubdtype(yours.dtype, np.integer):
        raise ValueError("members: give their indices (k,)")
    place = ring(10)
    for members, look in (
        (np.arange(10), _SOLID | {"linewidth": 0.9}),
        (truth, _SOLID | {"linewidth": 7.0, "alpha": 0.4}),
        (yours, {"color": PALETTE["estimate"], "linestyle": "--"}),
    ):
        among = np.isin(np.arange(10), members)
        pairs = np.argwhere(np.triu(joined & among & among[:, None], 1))
        ax.plot(*with_gaps(place[pairs]), **look)
    ax.plot(*place[yours].T, "o", color=PALETTE["estimate"], markersize=13.0, label="yours")
    for number, (x, y) in enumerate(1.17 * place):
        ax.text(x, y, f"{number}", ha="center", va="center")
    ax.set(xlim=(-1.35, 1.35), ylim=(-1.3, 1.3), aspect="equal")
    ax.set_axis_off()
    ax.legend(loc="lower left")


@picture(height=6.6, nrows=2, height_ratios=(2.0, 3.0))
def pairwise_consistent(axes: Sequence[Axes], student: Callable[..., ArrayLike]) -> None:
    """Draw a drive with four outliers, and which pairs of closures are consistent."""
    rng = np.random.default_rng(53)
    noise = generate.Noise(closure=(0.3, 0.1))  # so that what is carried along decides
    clean, poses = generate.manhattan(40, rng, block=2.0, side=3, closures=8, noise=noise)
    graph, is_outlier = outliers.add_random_closures(clean, 4, rng, poses=poses)
    gamma = thresholds.chi_square_threshold(0.99, 3)
    own, loop = graph.is_odometry, ~graph.is_odometry
    cov = np.linalg.inv(graph.information)
    z = graph.measurement
    yours = student(z[own], cov[own], graph.edges[loop], z[loop], cov[loop], gamma)
    m = int(np.count_nonzero(loop))
    draw_map(graph, poses, axes[0], is_outlier=is_outlier)
    axes[0].set_title("A walk through a town; closures 8 to 11 are outliers")
    truth = pairwise.pairwise_consistent(graph, gamma)
    _draw_agreement(axes[1], truth, finite("A", yours, (m, m)))


def _draw_agreement(ax: Axes, truth: Mask, yours: Array) -> None:
    """Draw grey squares where a pair is consistent, and a ring where the student says so."""
    said = yours != 0.0
    ax.imshow(np.where(truth, 0.35, 0.0), cmap="Greys", vmin=0.0, vmax=1.0)
    rings: Settings = {"markersize": 9.0, "fillstyle": "none", "label": "yours"}
    ax.plot(*np.argwhere(said).T[::-1], "o", color=PALETTE["estimate"], **rings)
    wrong = np.argwhere(said != truth)
    if len(wrong):
        ax.plot(*wrong.T[::-1], "X", color=PALETTE["outlier"], label="not so")
    ax.set(xlabel="closure q", ylabel="closure p")
    ax.set_title("A ring on every grey square, and no other")
    ax.grid(visible=False)
    ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
