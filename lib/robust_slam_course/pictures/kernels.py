"""The picture of chapter 2: one reading that moves away, as four kernels see it."""

from __future__ import annotations

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
    """Return the location of chapter 2: a reading that moves away, as four kernels see it."""
    inliers = [-1.4, -0.9, -0.5, -0.2, 0.2, 0.5, 0.9, 1.4]
    reading, c = 8.0, 2.5
    four = [KERNELS[name](c) for name in ("squared", "huber", "cauchy", "tls")]
    estimates = [_location([*inliers, reading], kernel) for kernel in four]
    pulls = [float(kernel.psi(reading - x)) for kernel, x in zip(four, estimates, strict=True)]
    return Picture(
        name="kernels",
        title="One reading and four kernels",
        question=ask(
            "The threshold c doubles from 2.5 to 5. Which of the four estimates moves most?",
            {
                "squared": "The square has no threshold and stays, whereas Huber lets a distant"
                " reading pull with c itself.",
                "Huber": "It lets a distant reading pull with c itself, and its estimate goes from"
                " 0.312 to 0.625.",
                "Cauchy": "Cauchy’s estimate moves by 0.19, Huber’s by 0.31: Huber lets a distant"
                " reading pull with c itself.",
                "TLS": "TLS rejects a reading at 8 in either case, whereas Huber lets it pull with"
                " c itself.",
            },
            right="Huber",
        ),
        tries=[
            "begin with the reading at 0 and move it outwards. Where does Cauchy pull hardest, and"
            " where does TLS reject it? Compare both with c.",
            "bring the reading to 4 and change c: with a larger one TLS keeps the reading again."
            " How small can c be before TLS rejects inliers?",
        ],
        caption=f"The reading at {reading:.1f} pulls with {pulls[0]:.2f} (squared), {pulls[1]:.2f}"
        f" (Huber) and {pulls[2]:.2f} (Cauchy, at most {c / 2:.2f}); TLS rejects it."
        f" Estimates: {', '.join(f'{abs(x):.2f}' for x in estimates)}.",
        state={"z": reading, "c": c, "curve": "psi"},
        answer={"c": 5.0},
        data={"inliers": inliers},
        still=_kernels_still(inliers, reading, four),
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
