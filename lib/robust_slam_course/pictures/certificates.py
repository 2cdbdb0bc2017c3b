"""Pictures of certificates: headings on a ring and the proof that none cost less."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from robust_slam.certificates import sdp
from robust_slam.graphs import se2

from robust_slam_course.canvas.picture import Picture
from robust_slam_course.pictures.graphs import Array
from robust_slam_course.plots.certificates import draw_ring, draw_spectrum
from robust_slam_course.quiz import Option, Question
from robust_slam_course.style import figure_style

_TWISTED = [0, 72, 144, -144, -72]


def certificate() -> Picture:
    """Return a twisted ring of five headings, its certificate and the climb out of it."""
    Q, R = _twisted_ring()
    _, eigenvalues = sdp.dense_certificate(Q, R)
    lowest = f"{eigenvalues[0]:.2f}".replace("-", "−")
    return Picture(
        name="certificate",
        title="Is there a better map?",
        question=Question(
            "All headings were measured equal. Which turn of the arrows lowers the cost?",
            [
                Option(
                    "a small one",
                    "The pulls on each arrow balance, and when it turns they pull it back.",
                ),
                Option(
                    "several small ones",
                    "Between headings that differ by less than 90° every small change costs more.",
                ),
                Option(
                    "only a large one",
                    "The ring is a local minimum: every small turn, of one arrow or several,"
                    " raises the cost.",
                    correct=True,
                ),
            ],
        ),
        tries=[
            "press Play to climb. Which cost is reached with a third row, and which with a"
            " fourth?",
            "choose equal headings and increase the measured turn. At which α does an"
            " eigenvalue fall below 0?",
        ],
        caption="A ring of five headings, twisted once, costs"
        f" {np.trace(R @ Q @ R.T):.2f}; equal headings cost 0. The smallest eigenvalue of the"
        f" certificate S is {lowest}, so the ring is not certified.",
        state={"ring": "five", "degrees": _TWISTED, "alpha": 0, "step": 0},
        answer={"degrees": [0, 90, 144, -144, -72]},
        data={},
        still=_certificate_still(eigenvalues),
    )


def _twisted_ring() -> tuple[Array, Array]:
    """Return the connection matrix of the ring and its headings as rotations, side by side."""
    edges = np.array([[k, (k + 1) % 5] for k in range(5)])
    equal = np.broadcast_to(np.eye(2), (5, 2, 2))
    R = np.hstack(list(se2.rotation(np.outer(np.radians(_TWISTED), [0.0, 0.0, 1.0]))))
    return sdp.connection_matrix(5, edges, equal), R


def _certificate_still(eigenvalues: Array) -> Figure:
    """Return the twisted ring and the spectrum of its certificate."""
    with figure_style():
        figure = Figure(figsize=(5.6, 3.2), layout="constrained")
        left, right = figure.subplots(1, 2)
        draw_ring(left, np.radians(_TWISTED), turn=0.0)
        draw_spectrum(right, eigenvalues).set(title="eigenvalues of S")
        right.legend(loc="upper right", fontsize=9)
    return figure
