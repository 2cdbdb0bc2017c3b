"""The picture of chapter 9 that compares starts and methods: the start, or graduation?"""

from typing import Any

import numpy as np
from matplotlib import pyplot as plt
from matplotlib.figure import Figure

from robust_slam_course.canvas.picture import Picture
from robust_slam_course.pictures.graphs import stored
from robust_slam_course.quiz import ask
from robust_slam_course.style import figure_style

_NOISES = [0.01, 0.02, 0.03, 0.05, 0.07, 0.1]
_ASKED = 3  # the place of 0.05 among them


def graduation() -> Picture:
    """Return the maps of two starts and two ways to solve, each by two costs, over noise.

    `tools/data/graduation.py` computes them.
    """
    data = stored("graduation.json") | {"noises": _NOISES}
    good = _good(data)
    starts, ways = _margins(good)[:, _ASKED], _margins(good.swapaxes(0, 1))[:, _ASKED]
    return Picture(
        name="graduation",
        title="Eighty small maps",
        question=ask(
            "What saves more maps from 50 % consistent outliers, at 0.05 rad a step?",
            {
                "the start": f"From odometry {starts[0]} maps are good, from least squares"
                f" {starts[1]}; by GNC {ways[1]}, by IRLS {ways[0]}.",
                "graduation": f"GNC finds {ways[1]} maps and IRLS {ways[0]}, but from odometry"
                f" the two find {starts[0]}, from least squares {starts[1]}.",
                "both alike": f"The start makes a difference of {starts[0] - starts[1]} maps"
                f" ({starts[0]} against {starts[1]}), graduation one of {ways[1] - ways[0]}"
                f" ({ways[1]} against {ways[0]}).",
            },
            right="the start",
        ),
        tries=["Up to which noise does graduation save more maps than the start?"],
        caption=f"Ten towns with {_NOISES[0]:g} rad of noise a step, and the good maps of 40"
        " by start and method.",
        state={"noise": 0, "tried": 0},
        answer={"noise": _ASKED, "tried": _ASKED},
        data=data,
        still=_margins_still(good),
    )


def _good(data: dict[str, Any]) -> np.ndarray:
    """Return the number of good maps ``(2, 2, 2, 6)`` by start, IRLS or GNC, cost and noise."""
    counts = [[each.count("") for each in noises] for noises in data["lost"]]
    # A column is a start and a method, and the methods are IRLS and GNC for each cost.
    return np.reshape(counts, (2, 2, 2, len(_NOISES))).swapaxes(1, 2)


def _margins(good: np.ndarray) -> np.ndarray:
    """Return the good maps ``(2, 6)`` of each part of the first axis."""
    return np.asarray(np.sum(good, axis=(1, 2)))


@figure_style()
def _margins_still(good: np.ndarray) -> Figure:
    """Return the good maps of each start and each way to solve, over the noise."""
    figure, ax = plt.subplots(figsize=(5.6, 3.2))
    for names, counts, dash in (
        (("from odometry", "from least squares"), good, "-"),
        (("IRLS", "GNC"), good.swapaxes(0, 1), "--"),
    ):
        for name, line, mark in zip(names, _margins(counts), "os", strict=True):
            ax.plot(_NOISES, line, dash + mark, label=name)
    ax.set(xlabel="odometry noise (rad a step)", ylabel="good maps of 40", ylim=(0, 41))
    ax.legend(ncols=2)
    return figure
