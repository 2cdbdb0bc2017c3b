"""Pictures of readings that the reader moves: a line, a location, and its cost."""

import numpy as np
from matplotlib import pyplot as plt
from matplotlib.figure import Figure
from robust_slam.estimators import irls
from robust_slam.estimators.kernels import KERNELS
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
    scales = {"squared": 1.0, "huber": 1.345, "cauchy": 2.385, "tls": 2.576}
    cauchy = KERNELS["cauchy"](scales["cauchy"])
    line = irls(problem, cauchy, irls(problem, KERNELS["huber"](scales["huber"])).x).x
    residuals = -problem.residuals(line)
    far, high = residuals[_DOOR], np.dot(line - _WALL, [1, _DOOR])
    leverage = 1 / p.size + (_DOOR - p.mean()) ** 2 / np.sum((p - p.mean()) ** 2)
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
        caption=f"Cauchy lets this reading pull with {cauchy.psi(far):.1f},"
        f" {far * _WALL_SIGMA:.2f} m above the line. The line is {high:.2f} m too high at place"
        f" {_DOOR}. Leverage: {leverage:.2f}.",
        state={
            "kernel": "cauchy", "held": _DOOR, "p": p.tolist(), "y": y.round(3).tolist(),
            "tried": {},
        },
        # There its residual is c.
        answer={
            "y": np.where(p == _DOOR, 3.57, y).round(3).tolist(),
            "tried": {f"cauchy {_DOOR}": [0.0, round(float(far), 2)]},
        },
        data={
            "p": p.tolist(), "y": y.round(3).tolist(), "truth": _WALL, "sigma": _WALL_SIGMA,
            "kernels": scales,
        },
        still=_wall_still(p, y, line, cauchy.psi(residuals)),
    )  # fmt: skip


@figure_style()
def _wall_still(p: Array, y: Array, line: Array, pulls: Array) -> Figure:
    """Return the readings with the line by Cauchy's kernel, and the pulls beneath them."""
    figure, (upper, lower) = plt.subplots(2, 1, figsize=(5.6, 4.6), sharex=True)
    draw_line_fit(upper, p, y, (line[0], line[1]), _WALL, p == _DOOR)
    upper.set(ylabel="distance y (m)")
    upper.legend(loc="upper left")
    draw_pulls(lower, p, pulls, p == _DOOR).set(xlabel="place p")
    return figure


def majoriser() -> Picture:
    """Return the five readings of chapter 3, and the steps of IRLS from a start to drag."""
    readings, sigma, start = [0.1, -0.2, 0.15, -0.1, 5.0], 0.3, 5.0
    problem, kernel = LocationProblem(readings, sigma), KERNELS["cauchy"](1.0)
    first, second, *_, last = irls(problem, kernel, start, tol=1e-4).history
    return Picture(
        name="majoriser",
        title="Each step goes to the lowest point of a parabola",
        question=ask(
            "The outlier is at 5. Where do the steps end if they begin beyond it, at 7?",
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
            "Raise σ until the ribbon stays green. Then choose Huber, and TLS: what does the"
            " majoriser of TLS look like at 3?",
        ],
        caption=f"Cauchy: from {start:g} the first step goes to {second.x:.2f}, and IRLS ends at"
        f" {last.x:.2f}; the cost falls from {first.cost:.2f} to {last.cost:.2f}. The dashed"
        " parabola is the majoriser of the first step.",
        state={"kernel": "cauchy", "start": start, "sigma": sigma, "tried": {}},
        answer={"start": 7},
        data={"readings": readings, "c": 1.0, "kernels": ["cauchy", "huber", "tls"]},
        still=_majoriser_still(readings, sigma, start),
    )


@figure_style()
def _majoriser_still(z: list[float], sigma: float, start: float) -> Figure:
    """Return the cost of the readings and its majoriser at the start."""
    figure, ax = plt.subplots(figsize=(5.6, 3.6))
    draw_landscape(ax, z, sigma, KERNELS["cauchy"](1.0), np.linspace(-1, 7.5, 171), at=start)
    ax.set(ylim=(0, 18))
    ax.legend(loc="upper center", ncols=2)
    return figure
