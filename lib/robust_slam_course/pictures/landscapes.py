"""Pictures of costs over one number: descents on them, and how GNC sharpens them."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from robust_slam.estimators import gnc, irls, kernels
from robust_slam.estimators.graduation import tls_surrogate
from robust_slam.problems import LocationProblem

from robust_slam_course.canvas.picture import Picture
from robust_slam_course.plots.annealing import draw_stage
from robust_slam_course.plots.location import draw_descent, draw_landscape
from robust_slam_course.style import figure_style

_FOUR = [-0.2, 0.1, 0.4, 10.0]
_SEVEN = [0.0, 0.0, 0.0, 0.0, 6.0, 6.0, 24.0]


def annealing() -> Picture:
    """Return GNC on seven readings whose cost, weights and path follow the reader's hand."""
    return Picture(
        name="annealing",
        title="GNC sharpens the cost",
        tries=[
            "four of seven readings are 0, and GNC ends there. Where must the reading at 24 go,"
            " so that GNC ends at 6 and rejects the four?",
            "play the run, then increase the factor of μ and drag the same reading again. How"
            " much easier is it to make GNC fail?",
            "choose Geman–McClure. In which direction does μ move, and when does the second"
            " minimum appear?",
        ],
        caption="Seven readings, 0 four times, 6 twice, and 24. In solve 3 the cost is still mild,"
        " and the estimate moves from 4.30 to 3.59. The run ends at 0.",
        state={"start": "seven", "z": _SEVEN, "kind": "tls", "c": 2.0, "factor": 1.4, "step": 3},
        data={"starts": {"four": _FOUR, "seven": _SEVEN}},
        still=_annealing_still(),
    )


def basins() -> Picture:
    """Return a descent on the cost of two groups of readings, and where every start ends."""
    return Picture(
        name="basins",
        title="Where a descent ends",
        tries=[
            "twenty readings are 0 and one is 10. IRLS with TLS starts at 8 and ends at 10. Where"
            " does it end if σ is doubled? And if it is three times as large?",
            "choose Cauchy and one reading against one. At which c do the two minima become one?",
            "choose TLS with c = 1 and drag the start between the readings. Which way does the"
            " descent go?",
        ],
        caption="The TLS cost with c = 3 of twenty readings at 0 and one at 10. From 8 IRLS ends"
        " at 10, where one reading of 21 is kept; the lowest cost is at 0.",
        state={
            "readings": "crowd", "z": [0.0, 10.0], "kernel": "tls", "c": 3.0, "sigma": 1.0,
            "start": 8.0,
        },
        data={"z": [0.0, 10.0], "times": {"crowd": [20, 1], "pair": [1, 1]}},
        still=_basins_still(),
    )  # fmt: skip


def _basins_still() -> Figure:
    """Return the TLS cost of twenty readings and one, with the descent from 8."""
    readings = np.append(np.zeros(20), 10.0)
    kernel = kernels.tls(3.0)
    with figure_style():
        figure = Figure(figsize=(5.6, 3.4), layout="constrained")
        ax = figure.subplots()
        draw_landscape(ax, readings, 1.0, kernel, np.linspace(-4.0, 14.0, 181))
        draw_descent(ax, irls(LocationProblem(readings), kernel, 8.0).history)
        ax.set(ylim=(-4.0, 104.0))
        ax.legend(loc="lower right", fontsize=9)
    return figure


def _annealing_still() -> Figure:
    """Return the cost at the third μ of the run on the seven readings."""
    readings = np.array(_SEVEN)
    run = gnc(LocationProblem(readings), 2.0).history
    move, mu = (run[2].x, run[3].x), float(run[3].mu or 0.0)
    x = np.linspace(-4.0, 38.0, 211)
    with figure_style():
        figure = Figure(figsize=(5.6, 3.4), layout="constrained")
        ax = figure.subplots()
        draw_stage(ax, readings, x, tls_surrogate, 2.0, mu, move, kernel=kernels.tls(2.0))
        ax.legend(loc="lower right", fontsize=9)
    return figure
