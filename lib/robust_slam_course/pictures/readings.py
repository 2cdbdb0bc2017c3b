"""Pictures of readings that the reader moves: a line, a location, and its cost."""

from __future__ import annotations

import numpy as np
from matplotlib import pyplot as plt
from matplotlib.figure import Figure
from robust_slam.estimators import irls
from robust_slam.estimators.kernels import KERNELS, squared
from robust_slam.problems import LinearProblem, LocationProblem

from robust_slam_course.canvas.picture import Picture
from robust_slam_course.plots.kernels import draw_costs, draw_drift, draw_influences
from robust_slam_course.plots.location import draw_landscape
from robust_slam_course.plots.pulls import draw_line_fit, draw_pulls

_WALL = (1.0, 0.25)  # the wall of chapter 1 is 1 m + 0.25 m a place away
_WALL_NOISE = [0.1, -0.2, 0.15, 0.05, -0.15, 0.2, -0.1, 0.1, 0.0, -0.1]
_WALL_SIGMA = 0.2
_DOOR = 8


def leverage() -> Picture:
    """Return the wall of chapter 1: ten readings to move, a line, and the pull of each."""
    p = np.arange(10.0)
    y = _WALL[0] + _WALL[1] * p + _WALL_NOISE + 3.0 * (p == _DOOR)
    scales = {"squared": 1.0, "huber": 1.345, "cauchy": 2.385, "tls": 2.576}
    return Picture(
        name="leverage",
        title="Ten readings pull on a line",
        tries=[
            "the reading at place 8 is 3 m too high, and the fit is tilted. Under Cauchy’s kernel"
            " far readings pull less. Does this one pull hardest where it is, or nearer to the"
            " wall?",
            "choose Cauchy and lower the reading until its bar is longest. Then choose TLS and"
            " find the height at which it rejects the reading.",
            "leverage: choose Huber and move the reading to place 16, at a height of 6 m. Does"
            " any kernel reject it there?",
        ],
        caption="Least squares: reading 8 is 11.3σ above the fit and pulls up with 11.3 (no"
        " limit). At place 8 the fit is 0.73 m too high. The reading’s leverage is 0.25.",
        state={"kernel": "squared", "held": _DOOR, "p": p.tolist(), "y": y.round(3).tolist()},
        data={
            "p": p.tolist(), "y": y.round(3).tolist(), "truth": _WALL, "sigma": _WALL_SIGMA,
            "kernels": scales,
        },
        still=_wall_still(p, y),
    )  # fmt: skip


def _wall_still(p: np.ndarray, y: np.ndarray) -> Figure:
    """Return the readings with the line by least squares, and the pulls beneath them."""
    problem = LinearProblem(np.column_stack([np.ones(p.size), p]), y, sigma=_WALL_SIGMA)
    line = irls(problem, squared()).x
    figure, (upper, lower) = plt.subplots(2, 1, figsize=(5.6, 4.6), sharex=True)
    draw_line_fit(upper, p, y, (line[0], line[1]), _WALL, p == _DOOR)
    upper.set(ylabel="distance y (m)")
    upper.legend(loc="upper left")
    draw_pulls(lower, p, -problem.residuals(line), p == _DOOR).set(xlabel="place p")
    plt.close(figure)
    return figure


def kernels() -> Picture:
    """Return the location of chapter 2: a reading that moves away, as four kernels see it."""
    inliers = [-1.4, -0.9, -0.5, -0.2, 0.2, 0.5, 0.9, 1.4]
    return Picture(
        name="kernels",
        title="One reading and four kernels",
        tries=[
            "the threshold c is 2.5 and doubles. Which of the four estimates moves most, and which"
            " stay where they are?",
            "begin with the reading at 0 and move it outwards. Where does Cauchy pull hardest, and"
            " where does TLS reject it? Compare both with c.",
            "bring the reading to 4 and change c: with a larger one TLS keeps the reading again."
            " How small can c be before TLS rejects inliers?",
        ],
        caption="The reading at 8.0 pulls with 7.11 (squared), 2.50 (Huber) and 0.72 (Cauchy, at"
        " most 1.25); TLS rejects it. Estimates: 0.89, 0.31, 0.12, 0.00.",
        state={"z": 8.0, "c": 2.5},
        data={"inliers": inliers},
        still=_kernels_still(inliers, 8.0, 2.5),
    )


def _kernels_still(inliers: list[float], reading: float, c: float) -> Figure:
    """Return cost, influence and, beneath them, the estimates as the reading moves."""
    four = [KERNELS[name](c) for name in ("squared", "huber", "cauchy", "tls")]
    figure, axes = plt.subplot_mosaic(
        [["cost", "pull"], ["drift", "drift"]], figsize=(5.6, 5.2), layout="constrained"
    )
    draw_costs(axes["cost"], four, u_max=15.0, mark=reading).set(ylim=(0, 15))
    draw_influences(axes["pull"], four, u_max=15.0, mark=reading).set(ylim=(0, 4))
    places = np.linspace(0.0, 15.0, 61)
    drift = {
        kernel.name: [irls(LocationProblem([*inliers, z]), kernel, x0=0.0).x for z in places]
        for kernel in four
    }
    draw_drift(axes["drift"], places, drift).legend()
    plt.close(figure)
    return figure


def majoriser() -> Picture:
    """Return the five readings of chapter 3, and the parabola that a step of IRLS minimises."""
    inliers, outlier, sigma, start = [0.1, -0.2, 0.15, -0.1], 5.0, 0.3, 7.0
    return Picture(
        name="majoriser",
        title="Each step goes to the lowest point of a parabola",
        tries=[
            "the dashed parabola touches the cost at the start, 7, and each step goes to its"
            " lowest point. The nearest minimum is at the outlier, near 5. Do the steps end"
            " there?",
            "move the start. Which of the starts between 0 and 7 end at the outlier? Compare 4.0"
            " with 4.2.",
            "go to the last step and raise σ until the cost has one local minimum. Then choose"
            " Huber, and TLS: what does the majoriser of TLS look like at the start?",
        ],
        caption="Cauchy, step 0 of 13, cost 14.52 at 7. The majoriser is lowest at 3.751, where"
        " the cost is 11.58. The outlier has the weight 0.022, an inlier at most 0.002. The cost"
        " has two local minima.",
        state={
            "kernel": "cauchy", "start": start, "outlier": outlier, "sigma": sigma, "step": 0,
        },
        data={"inliers": inliers, "c": 1.0, "kernels": ["cauchy", "huber", "tls"]},
        still=_majoriser_still([*inliers, outlier], sigma, start),
    )  # fmt: skip


def _majoriser_still(z: list[float], sigma: float, start: float) -> Figure:
    """Return the cost of the readings and its majoriser at the start."""
    figure, ax = plt.subplots(figsize=(5.6, 3.6))
    draw_landscape(ax, z, sigma, KERNELS["cauchy"](1.0), np.linspace(-1, 7.5, 171), at=start)
    ax.set(ylim=(0, 18))
    ax.legend(loc="upper center", ncols=2)
    plt.close(figure)
    return figure
