"""Pictures for assignment 03: one step, two descents, where no fit exists, a claimed variance.

Every function takes a student's own, of the same name, and draws it dashed or as markers
over the library's, which is broad and grey. x and z share one unit.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import ArrayLike
from robust_slam._arrays import Array
from robust_slam.estimators import kernels
from robust_slam.estimators import reweighting as library
from robust_slam.estimators.result import StopReason
from robust_slam.palette import PALETTE
from robust_slam.problems import LocationProblem

from robust_slam_course.exercises import draw_beside, once_it_works, shaped
from robust_slam_course.plots.location import draw_landscape, draw_weights, label_weights

Step = Callable[[Array, float, float, float], tuple[float, ArrayLike]]
Weight = Callable[[ArrayLike], ArrayLike]
Loop = Callable[[Array, float, Weight, float, float], tuple[float, ArrayLike]]

Z = np.array([0.1, -0.2, 0.15, -0.1, 5.0])  # the lesson's measurements, the last one an outlier
SIGMA = 0.3
_IS_LIE = Z > 1.0
_CAUCHY = kernels.cauchy(1.0)


@once_it_works
def irls_step(student: Step) -> Figure:
    """Draw the readings with their weights and the estimate, from the mean, truth above yours."""
    mean = float(np.mean(Z))
    weights = _CAUCHY.weight((Z - mean) / SIGMA)
    truth: tuple[float, ArrayLike] = (float(weights @ Z / np.sum(weights)), weights)
    yours = student(Z.copy(), SIGMA, mean, 1.0)
    figure = Figure(figsize=(5.6, 3.8))
    axes = figure.subplots(2, 1, sharex=True)
    for ax, step, name in zip(axes, (truth, yours), ("the truth", "yours"), strict=True):
        x, w = float(step[0]), shaped(step[1], Z.shape)
        draw_weights(ax, Z, w, x, _IS_LIE)
        label_weights(ax, w)
        ax.axvline(mean, color=PALETTE["muted"], linestyle=":")
        ax.set_yticks([])
        ax.set_title(f"{name}: x goes from {mean:.2f} to {_told(x)}", loc="left")
    axes[1].set(xlabel="x; a disc fills its ring as far as its weight goes")
    figure.suptitle("The outlier loses most of its weight, and x moves away from it", fontsize=11)
    return figure


@once_it_works
def irls(student: Loop) -> Figure:
    """Draw the robust cost with two descents on it, from the mean and from beside the outlier."""
    problem, x = LocationProblem(Z, SIGMA), np.linspace(-0.7, 5.7, 321)
    figure = Figure(figsize=(5.6, 3.8))
    ax = draw_landscape(figure.subplots(), Z, SIGMA, _CAUCHY, x)
    ax.lines[-1].set(color=PALETTE["muted"], linewidth=6, alpha=0.4)
    for start, name in ((float(np.mean(Z)), "estimate"), (4.6, "outlier")):
        _, history = student(Z.copy(), SIGMA, _CAUCHY.weight, start, 1e-12)
        visited = np.asarray(history, dtype=float)
        heights = np.sum(_CAUCHY.rho((visited - Z[:, None]) / SIGMA), axis=0)
        ax.plot(
            visited, heights, "--.", color=PALETTE[name], label=f"yours, from {visited[0]:.2f}"
        )
        end = library.irls(problem, _CAUCHY, start).x
        ax.axvline(end, color=PALETTE["muted"], linestyle=":", label=f"true end {_told(end)}")
    ax.set_title("Each start goes downhill to the end of its own valley")
    ax.legend(loc="lower center", fontsize=9.0)
    return figure


@once_it_works
def irls_tls(
    student: Callable[[Array, float, float, float, float], tuple[float, ArrayLike]],
) -> Figure:
    """Draw where TLS ends from each start, and shade the starts from which no fit exists."""
    starts = np.linspace(-1.5, 6.5, 161)
    truth = [_end(LocationProblem(Z, SIGMA), kernels.tls(3.0), x0) for x0 in starts]
    yours = [_student_fixed_point(student, float(x0)) for x0 in starts]
    figure = Figure()
    ax = draw_beside(figure.subplots(), starts, truth, yours)
    ax.plot(Z, Z, "o", color=PALETTE["inlier"], label="readings")
    empty = np.isnan(truth)
    ax.fill_between(
        starts, -1.0, 6.0, where=empty, step="mid", color=PALETTE["outlier"], alpha=0.15,
        linewidth=0.0, label="no fit exists",
    )  # fmt: skip
    ax.set(xlabel="start x₀, with c = 3", ylabel="where it ends", ylim=(-1.0, 6.0))
    ax.set_title("Where no reading is near, your line has a gap")
    ax.legend(loc="upper left")
    return figure


@once_it_works
def weighted_variance(student: Callable[[Array, float], float]) -> Figure:
    """Draw the claimed variance of 1 to 64 measurements of weight 1 and of weight 1/2."""
    counts = 2 ** np.arange(7)
    figure = Figure()
    ax = figure.subplots()
    for weight, name in ((1.0, "estimate"), (0.5, "outlier")):
        yours = [float(student(np.full(m, weight), SIGMA)) for m in counts]
        draw_beside(ax, counts, SIGMA**2 / (weight * counts), yours)
        ax.lines[-1].set(color=PALETTE[name], marker="o", label=f"yours, weight {weight:g}")
    ax.lines[2].set(label="_again")
    ax.set(xscale="log", yscale="log", xlabel="measurements", ylabel="variance of x")
    ax.set_xticks(counts, [str(count) for count in counts])
    ax.minorticks_off()
    ax.set_title("Half the weight costs as much as half the measurements")
    ax.legend()
    return figure


def _told(x: float) -> str:
    return f"{x:.4f}".replace("-", "−")


def _end(problem: LocationProblem, kernel: kernels.Kernel, start: float) -> float:
    """Return where the library's loop ends, NaN where every weight is 0."""
    result = library.irls(problem, kernel, start)
    return float("nan") if result.stop is StopReason.ALL_REJECTED else result.x


def _student_fixed_point(
    student: Callable[[Array, float, float, float, float], tuple[float, ArrayLike]], start: float
) -> float:
    """Return where the student's loop ends, NaN where it reports that no fit exists."""
    try:
        answer = student(Z.copy(), SIGMA, 3.0, start, 1e-12)
    except ValueError:
        return float("nan")
    return float(answer[0])
