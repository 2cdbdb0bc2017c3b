"""Pictures of readings that the reader moves: a line, a location, and its cost."""

from __future__ import annotations

import numpy as np
from matplotlib import pyplot as plt
from matplotlib.figure import Figure
from robust_slam.estimators import irls
from robust_slam.estimators.kernels import KERNELS, squared
from robust_slam.problems import LinearProblem, LocationProblem

from robust_slam_course.canvas.picture import Picture
from robust_slam_course.pictures.graphs import Array
from robust_slam_course.plots.location import draw_landscape
from robust_slam_course.plots.pulls import draw_line_fit, draw_pulls
from robust_slam_course.quiz import ask
from robust_slam_course.style import figure_style

_WALL = (1.0, 0.25)  # the wall of chapter 1 is 1 m + 0.25 m a place away
_WALL_NOISE = [0.1, -0.2, 0.15, 0.05, -0.15, 0.2, -0.1, 0.1, 0.0, -0.1]
_WALL_SIGMA = 0.2
_DOOR = 8


def leverage() -> Picture:
    """Return the wall of chapter 1: ten readings to move, a line, and the pull of each."""
    p = np.arange(10.0)
    y = _WALL[0] + _WALL[1] * p + _WALL_NOISE + 3.0 * (p == _DOOR)
    problem = LinearProblem(np.column_stack([np.ones(p.size), p]), y, sigma=_WALL_SIGMA)
    line = irls(problem, squared()).x
    pull = -problem.residuals(line)[_DOOR]
    high = np.dot(line - _WALL, [1, _DOOR])
    leverage = 1 / p.size + (_DOOR - p.mean()) ** 2 / np.sum((p - p.mean()) ** 2)
    scales = {"squared": 1.0, "huber": 1.345, "cauchy": 2.385, "tls": 2.576}
    return Picture(
        name="leverage",
        title="Ten readings pull on a line",
        question=ask(
            "Under Cauchy’s kernel, how far above the line does a reading pull hardest?",
            {
                "about ½ m": "The pull u/(1+u²/c²) is largest at u = c, which is 0.48 m above the"
                " fit.",
                "3 m": "Beyond u = c, 0.48 m above the fit, the pull falls again; at 3 m it is"
                " less than a third.",
                "any from ½ m on": "Huber’s pull stays constant from there on; Cauchy’s falls"
                " beyond u = c.",
            },
            right="about ½ m",
        ),
        tries=[
            "Move the reading to place 16, at a height of 6 m, where its leverage is large. Does"
            " any kernel reject it there?",
        ],
        caption=f"Least squares lets this reading pull with {pull:.1f}, {pull:.1f}σ above the"
        f" line. The line is {high:.2f} m too high at place {_DOOR}. Leverage: {leverage:.2f}.",
        state={
            "kernel": "squared", "held": _DOOR, "p": p.tolist(), "y": y.round(3).tolist(),
        },
        # There its residual is c.
        answer={"kernel": "cauchy", "y": np.where(p == _DOOR, 3.57, y).round(3).tolist()},
        data={
            "p": p.tolist(), "y": y.round(3).tolist(), "truth": _WALL, "sigma": _WALL_SIGMA,
            "kernels": scales,
        },
        still=_wall_still(p, y, line, -problem.residuals(line)),
    )  # fmt: skip


@figure_style()
def _wall_still(p: Array, y: Array, line: Array, pulls: Array) -> Figure:
    """Return the readings with the line by least squares, and the pulls beneath them."""
    figure, (upper, lower) = plt.subplots(2, 1, figsize=(5.6, 4.6), sharex=True)
    draw_line_fit(upper, p, y, (line[0], line[1]), _WALL, p == _DOOR)
    upper.set(ylabel="distance y (m)")
    upper.legend(loc="upper left")
    draw_pulls(lower, p, pulls, p == _DOOR).set(xlabel="place p")
    return figure


def majoriser() -> Picture:
    """Return the five readings of chapter 3, and the parabola that a step of IRLS minimises."""
    inliers, outlier, sigma, start = [0.1, -0.2, 0.15, -0.1], 5.0, 0.3, 7.0
    problem = LocationProblem([*inliers, outlier], sigma)
    first, second, *_ = path = irls(problem, KERNELS["cauchy"](1.0), start, tol=1e-4).history
    return Picture(
        name="majoriser",
        title="Each step goes to the lowest point of a parabola",
        question=ask(
            "The steps begin at 7, next to the outlier at 5. Where do they end?",
            {
                "near 5": "A step does not search nearby: the first goes past 5 to 3.75, where the"
                " parabola is lowest.",
                "near 0": "The four inliers draw the first step past 5, to 3.75, and from there"
                " the cost falls towards 0.",
                "near 1, the mean": "The outlier has lost nearly all its weight by then, whereas"
                " the mean counts it fully.",
            },
            right="near 0",
        ),
        tries=[
            "move the start. Which of the starts between 0 and 7 end at the outlier? Compare 4.0"
            " with 4.2.",
            "go to the last step and raise σ until the cost has one local minimum. Then choose"
            " Huber, and TLS: what does the majoriser of TLS look like at the start?",
        ],
        caption=f"Cauchy, step 0 of {len(path) - 1}, cost {first.cost:.2f} at {start:g}. The"
        f" majoriser is lowest at {second.x:.3f}, where the cost is {second.cost:.2f}. The outlier"
        f" has weight {second.weights[-1]:.3f}, an inlier at most"
        f" {second.weights[:-1].max():.3f}. The cost has two local minima.",
        state={
            "kernel": "cauchy", "start": start, "outlier": outlier, "sigma": sigma, "step": 0,
        },
        answer={"step": 13},
        data={"inliers": inliers, "c": 1.0, "kernels": ["cauchy", "huber", "tls"]},
        still=_majoriser_still([*inliers, outlier], sigma, start),
    )  # fmt: skip


@figure_style()
def _majoriser_still(z: list[float], sigma: float, start: float) -> Figure:
    """Return the cost of the readings and its majoriser at the start."""
    figure, ax = plt.subplots(figsize=(5.6, 3.6))
    draw_landscape(ax, z, sigma, KERNELS["cauchy"](1.0), np.linspace(-1, 7.5, 171), at=start)
    ax.set(ylim=(0, 18))
    ax.legend(loc="upper center", ncols=2)
    return figure
