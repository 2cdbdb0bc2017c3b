"""Pictures for assignment 03: one step, two descents, where no fit exists, a claimed variance."""

from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike
from robust_slam._arrays import Array
from robust_slam.estimators import kernels
from robust_slam.estimators import reweighting as library
from robust_slam.estimators.result import StopReason
from robust_slam.palette import PALETTE
from robust_slam.problems import LocationProblem

from robust_slam_course.exercises import READINGS as Z
from robust_slam_course.exercises import draw_beside, picture, shaped
from robust_slam_course.plots.location import draw_landscape, draw_weights, label_weights

Step = Callable[[Array, float, float, float], tuple[float, ArrayLike]]
Weight = Callable[[ArrayLike], ArrayLike]
Loop = Callable[[Array, float, Weight, float, float], tuple[float, ArrayLike]]
TlsLoop = Callable[[Array, float, float, float, float], tuple[float, ArrayLike]]

SIGMA = 0.3
_CAUCHY = kernels.cauchy(1.0)


@picture(
    "The outlier loses most of its weight, and x moves away from it",
    height=3.8, nrows=2, sharex=True,
)  # fmt: skip
def irls_step(axes: Sequence[Axes], student: Step) -> None:
    """Draw the readings with their weights and the estimate, from the mean, truth above yours."""
    mean = float(np.mean(Z))
    weights = _CAUCHY.weight((Z - mean) / SIGMA)
    truth: tuple[float, ArrayLike] = (float(weights @ Z / np.sum(weights)), weights)
    yours = student(Z.copy(), SIGMA, mean, 1.0)
    for ax, step, name in zip(axes, (truth, yours), ("the truth", "yours"), strict=True):
        x, w = float(step[0]), shaped(step[1], Z.shape)
        draw_weights(ax, Z, w, x, Z > 1.0)
        label_weights(ax, w)
        ax.axvline(mean, color=PALETTE["muted"], linestyle=":")
        ax.set_yticks([])
        ax.set_title(f"{name}: x goes from {mean:.2f} to {_told(x)}", loc="left")
    axes[1].set(xlabel="x; a disc fills its ring as far as its weight goes")


@picture("Each start goes downhill to the end of its own valley", height=3.8)
def irls(ax: Axes, student: Loop) -> None:
    """Draw the robust cost with two descents on it, from the mean and from beside the outlier."""
    problem, x = LocationProblem(Z, SIGMA), np.linspace(-0.7, 5.7, 321)
    draw_landscape(ax, Z, SIGMA, _CAUCHY, x)
    ax.lines[-1].set(color=PALETTE["muted"], linewidth=6, alpha=0.4)
    for start, name in ((float(np.mean(Z)), "estimate"), (4.6, "outlier")):
        _, history = student(Z.copy(), SIGMA, _CAUCHY.weight, start, 1e-12)
        visited = np.asarray(history, dtype=float)
        heights = np.sum(_CAUCHY.rho((visited - Z[:, None]) / SIGMA), axis=0)
        label = f"yours, from {visited[0]:.2f}"
        ax.plot(visited, heights, "--.", color=PALETTE[name], label=label)
        end = library.irls(problem, _CAUCHY, start).x
        ax.axvline(end, color=PALETTE["muted"], linestyle=":", label=f"true end {_told(end)}")
    ax.legend(loc="lower center", fontsize=9.0)


@picture("Where no reading is near, your line has a gap", "start x₀, with c = 3", "where it ends")
def irls_tls(ax: Axes, student: TlsLoop) -> None:
    """Draw where TLS ends from each start, and shade the starts from which no fit exists."""
    starts = np.linspace(-1.5, 6.5, 161)
    truth = np.array([_true_end(float(x0)) for x0 in starts])
    draw_beside(ax, starts, truth, [_student_end(student, float(x0)) for x0 in starts])
    ax.plot(Z, Z, "o", color=PALETTE["inlier"], label="readings")
    empty = ax.fill_between(starts, -1.0, 6.0, where=np.isnan(truth), step="mid", alpha=0.15)
    empty.set(color=PALETTE["outlier"], linewidth=0.0, label="no fit exists")
    ax.set(ylim=(-1.0, 6.0))
    ax.legend(loc="upper left")


@picture("Half the weight costs as much as half the measurements", "measurements", "variance of x")
def weighted_variance(ax: Axes, student: Callable[[Array, float], float]) -> None:
    """Draw the claimed variance of 1 to 64 measurements of weight 1 and of weight 1/2."""
    counts = 2 ** np.arange(7)
    for weight, name in ((1.0, "estimate"), (0.5, "outlier")):
        yours = [float(student(np.full(m, weight), SIGMA)) for m in counts]
        look = {"color": PALETTE[name], "marker": "o", "label": f"yours, weight {weight:g}"}
        draw_beside(ax, counts, SIGMA**2 / (weight * counts), yours, **look)
    ax.set(xscale="log", yscale="log")
    ax.set_xticks(counts, [str(count) for count in counts])
    ax.minorticks_off()
    ax.legend()


def _told(x: float) -> str:
    return f"{x:.4f}".replace("-", "−")


def _true_end(start: float) -> float:
    """Return where the library's TLS with c = 3 ends, NaN where every weight is 0."""
    result = library.irls(LocationProblem(Z, SIGMA), kernels.tls(3.0), start)
    return float("nan") if result.stop is StopReason.ALL_REJECTED else result.x


def _student_end(student: TlsLoop, start: float) -> float:
    """Return where the student's loop ends, NaN where it reports that no fit exists."""
    try:
        answer = student(Z.copy(), SIGMA, 3.0, start, 1e-12)
    except ValueError:
        return float("nan")
    return float(answer[0])
