"""Pictures of costs over one number: descents on them, and how GNC sharpens them."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib import pyplot as plt
from matplotlib.figure import Figure
from robust_slam.estimators import gnc, irls, kernels
from robust_slam.estimators.graduation import gm_surrogate, tls_surrogate
from robust_slam.estimators.kernels import Kernel
from robust_slam.estimators.result import Step
from robust_slam.problems import LocationProblem

from robust_slam_course.canvas.picture import Picture
from robust_slam_course.pictures.graphs import Array
from robust_slam_course.plots.annealing import draw_paths, draw_stage
from robust_slam_course.plots.location import draw_descent, draw_landscape
from robust_slam_course.quiz import ask
from robust_slam_course.style import figure_style

_FOUR = [-0.2, 0.1, 0.4, 10.0]
_SEVEN = [0.0, 0.0, 0.0, 0.0, 6.0, 6.0, 24.0]
_C, _FACTOR = 2.0, 1.4
_ANNEALED = {"kind": "tls", "c": _C, "span": [-4, 38], "view": "cost", "main": "step"}
"""The data of the script `annealing`, where its picture has no other."""


def annealing() -> Picture:
    """Return GNC on seven readings whose cost, weights and path follow the reader's hand."""
    step = 3  # the one that the still picture shows
    run = gnc(LocationProblem(_SEVEN), _C, factor=_FACTOR).history
    return Picture(
        name="annealing",
        title="GNC sharpens the cost",
        question=ask(
            "Where must the reading at 24 go for GNC to end at 6 and not at 0?",
            {
                "6": "Three at 6 are fewer than four at 0. A reading at 30 draws the mean, where"
                " the run begins, to 6.",
                "12": "At 12 the mean, where the run begins, is 3.43; at 30 it is 6, and two"
                " readings hold it there.",
                "30": "The run then begins at a mean of 6, and the two readings there hold it.",
            },
            right="30",
        ),
        tries=[
            "Increase the factor of μ, play, and drag the same reading again. How much easier is"
            " it to make GNC fail?",
        ],
        caption="Seven readings, 0 four times, 6 twice, and 24. The run begins at the mean,"
        f" {run[0].x:.2f}. The cost shown is that of solve {step}, still a mild one.",
        state={"z": _SEVEN, "factor": _FACTOR, "step": 0},
        answer={"z": [*_SEVEN[:-1], 30.0]},
        data=_ANNEALED | {"z": _SEVEN},
        still=_annealing_still(run[step - 1 : step + 1]),
    )


def hardening() -> Picture:
    """Return the picture of ``annealing`` with four readings and Geman–McClure's cost."""
    run = gnc(LocationProblem(_FOUR), _C, "gm", factor=_FACTOR).history
    return Picture(
        name="hardening",
        script="annealing",
        title="A second minimum appears at the outlier",
        question=ask(
            "When the cost gets a second minimum near 10, where is the estimate?",
            {
                "near 10": "By solve 7, when the minimum appears, the outlier has hardly any"
                " weight.",
                "near 2.6, the mean": "There the run begins; then each solve gives the outlier"
                " less weight.",
                "near 0.2": "At solve 7, where the minimum appears, it moves from 0.21 to 0.16.",
            },
            right="near 0.2",
        ),
        tries=[
            "Increase the factor of μ. Where is the estimate then, when the second minimum"
            " appears?",
        ],
        caption=f"Four readings, three of the {len(run) - 1} solves. The run begins at the mean,"
        f" {run[0].x:.2f}.",
        state={"z": _FOUR, "factor": _FACTOR, "step": 0},
        answer={"step": 7},
        data=_ANNEALED | {"z": _FOUR, "kind": "gm", "span": [-4, 14]},
        still=_hardening_still(run),
    )


def factors() -> Picture:
    """Return the picture of ``annealing`` with the factor of μ, on seven readings up to 30."""
    readings = [*_SEVEN[:-1], 30.0]
    runs = {each: gnc(LocationProblem(readings), _C, factor=each) for each in (1.1, 1.2, 1.4, 2.0)}
    end = runs[_FACTOR]
    return Picture(
        name="factors",
        script="annealing",
        title="The factor of μ decides where GNC ends",
        question=ask(
            "With a factor of 1.4 the run ends at 6. Where does it end with 1.1 and 2?",
            {
                "both at 6": "With 1.1 the estimate has time to reach 0.",
                "1.1 at 0, 2 at 6": "With 1.1 it has time to reach 0; with 2 it never gets below"
                " 5.63.",
                "1.1 at 6, 2 at 0": "A larger factor makes the cost robust sooner and leaves less"
                " time.",
            },
            right="1.1 at 0, 2 at 6",
        ),
        tries=[
            "With a factor of 1.1, go to the solve at which the estimate turns back. How many"
            " minima has the cost there?",
        ],
        caption="The paths of the estimate with four factors of μ. With the usual one it ends at"
        f" {end.x:.0f} after {len(end.history) - 1} solves, and 2 of 7 readings are kept.",
        state={"z": readings, "factor": _FACTOR, "step": 10**6},
        answer={"factor": 1.1},
        data=_ANNEALED | {"z": readings, "view": "path", "main": "factor"},
        still=_factors_still({f"factor {each:g}": run.history for each, run in runs.items()}),
    )


def basins() -> Picture:
    """Return a descent on the cost of two groups of readings, and where every start ends."""
    crowd, kernel, start = np.append(np.zeros(20), 10.0), kernels.tls(3.0), 8.0
    run = irls(LocationProblem(crowd), kernel, start)
    return Picture(
        name="basins",
        title="Where a descent ends",
        question=ask(
            "From 8 this run ends at 10. Where does it end when σ is three times as large?",
            {
                "10": "The zeros are now within cσ = 9 of the start, too; with 2σ they are not.",
                "0": "At σ = 3 all 21 readings are within cσ = 9 of 8. From their mean, 0.48, the"
                " one at 10 is not.",
                "0.48, the mean": "The mean is only the first step: from there 10 is 9.52 away,"
                " beyond cσ = 9.",
            },
            right="0",
        ),
        tries=[
            "Choose Cauchy, and drag the start over the whole axis. Which starts end at the"
            " outlier now?",
        ],
        caption=f"The TLS cost with c = {kernel.scale:g} of twenty readings at 0 and one at 10."
        f" From {start:g} IRLS ends at {run.x:g}, where {run.weights.sum():g} of {crowd.size}"
        " readings is kept; the lowest cost is at 0.",
        state={"z": [0.0, 10.0], "kernel": "tls", "sigma": 1.0, "start": start, "tried": {}},
        answer={"sigma": 3.0},
        data={"z": [0.0, 10.0], "times": [20, 1], "c": kernel.scale},
        still=_basins_still(crowd, kernel, run.history),
    )


@figure_style()
def _basins_still(readings: Array, kernel: Kernel, history: Sequence[Step[float]]) -> Figure:
    """Return the cost of twenty readings and one, with a descent."""
    figure, ax = plt.subplots(figsize=(5.6, 3.4))
    draw_landscape(ax, readings, 1.0, kernel, np.linspace(-4.0, 14.0, 181))
    draw_descent(ax, history)
    ax.set(ylim=(-4.0, 104.0))
    ax.legend(loc="lower right", fontsize=9)
    return figure


@figure_style()
def _annealing_still(steps: Sequence[Step[float]]) -> Figure:
    """Return the cost of the seven readings at the μ of the second of two steps of a run."""
    before, after = steps
    readings, move = np.array(_SEVEN), (before.x, after.x)
    x = np.linspace(-4.0, 38.0, 211)
    figure, ax = plt.subplots(figsize=(5.6, 3.4))
    draw_stage(
        ax, readings, x, tls_surrogate, _C, float(after.mu or 0.0), move, kernel=kernels.tls(_C)
    )
    ax.legend(loc="lower right", fontsize=9)
    return figure


@figure_style()
def _hardening_still(run: Sequence[Step[float]]) -> Figure:
    """Return the cost of the four readings at three solves of a run."""
    x = np.linspace(-3.0, 13.0, 321)
    figure, panels = plt.subplots(3, 1, sharex=True, figsize=(5.6, 4.4))
    for ax, solve in zip(panels, (1, 7, len(run) - 1), strict=True):
        mu, move = float(run[solve].mu or 0.0), (run[solve - 1].x, run[solve].x)
        draw_stage(ax, _FOUR, x, gm_surrogate, _C, mu, move)
        ax.set(xlabel="", ylabel="", yticks=[])
        ax.set_title(f"solve {solve}, μ = {mu:.3g}", loc="left")
    panels[-1].set(xlabel="x")
    names = ["cost at this μ", "minimum", "reading", "before the solve", "after it"]
    figure.legend(panels[0].lines, names, loc="outside upper center", ncols=3)
    return figure


@figure_style()
def _factors_still(runs: Mapping[str, Sequence[Step[float]]]) -> Figure:
    """Return the paths of the estimate with several factors of μ."""
    figure, ax = plt.subplots(figsize=(5.6, 3.4))
    draw_paths(ax, runs)
    ax.axhline(0.0, color="0.5", linewidth=0.8)
    ax.set(ylim=(-0.4, 6.6))
    ax.legend(loc=(0.66, 0.22))
    return figure
