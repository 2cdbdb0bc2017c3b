"""The picture of chapter 2: one reading that moves away, as four kernels see it."""

import numpy as np
from matplotlib import pyplot as plt
from matplotlib.figure import Figure
from robust_slam.estimators import irls
from robust_slam.estimators.kernels import KERNELS, Kernel
from robust_slam.problems import LocationProblem

from robust_slam_course.canvas.picture import Picture
from robust_slam_course.plots.kernels import draw_costs, draw_drift, draw_influences
from robust_slam_course.quiz import ask
from robust_slam_course.style import figure_style


def kernels() -> Picture:
    """Return the location of chapter 2: a reading to move away, as four kernels see it."""
    inliers = [-1.4, -0.9, -0.5, -0.2, 0.2, 0.5, 0.9, 1.4]
    farthest, c = 15.0, 2.5
    four = [KERNELS[name](c) for name in ("squared", "huber", "cauchy", "tls")]
    ends = [_location([*inliers, farthest], kernel) for kernel in four]
    return Picture(
        name="kernels",
        title="One reading and four kernels",
        question=ask(
            f"With c = {c:g} a ninth reading moves away to 15. How many of four estimates return?",
            {
                "none": f"That of TLS jumps back to {ends[3]:.0f}, and Cauchy’s returns to"
                f" {ends[2]:.2f}.",
                "one": "Not only that of TLS, which jumps back: Cauchy’s returns slowly, to"
                f" {ends[2]:.2f}.",
                "two": f"Cauchy’s returns to {ends[2]:.2f} and that of TLS to {ends[3]:.0f};"
                f" Huber’s stops at {ends[1]:.2f}, and the mean moves on to {ends[0]:.2f}.",
                "three": f"Huber’s stops at {ends[1]:.2f} and does not return: its pull stays as"
                " large as the threshold.",
            },
            right="two",
        ),
        tries=["Double the threshold. Which of the four estimates moves most?"],
        caption="Above, the cost and the pull of a reading against its residual, under four"
        " kernels; beneath them the four estimates as it moves away from eight others.",
        state={"z": 0.0, "far": 0.0, "c": c},
        answer={"z": farthest, "far": farthest},
        data={"inliers": inliers},
        still=_kernels_still(inliers, farthest, four),
    )


def _location(readings: list[float], kernel: Kernel) -> float:
    """Return the estimate that a descent from 0 ends at."""
    return float(irls(LocationProblem(readings), kernel, x0=0.0).x)


@figure_style()
def _kernels_still(inliers: list[float], reading: float, four: list[Kernel]) -> Figure:
    """Return cost, influence and, beneath them, the estimates as the reading moves."""
    figure, axes = plt.subplot_mosaic([["cost", "pull"], ["drift", "drift"]], figsize=(5.6, 5.2))
    draw_costs(axes["cost"], four, u_max=15.0, mark=reading).set(ylim=(0, 15))
    draw_influences(axes["pull"], four, u_max=15.0, mark=reading).set(ylim=(0, 4))
    places = np.linspace(0.0, 15.0, 61)
    drift = {
        kernel.name: [_location([*inliers, float(z)], kernel) for z in places] for kernel in four
    }
    draw_drift(axes["drift"], places, drift).legend()
    return figure
