"""Pictures of certificates: headings on a ring and the proof that none cost less."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from robust_slam.certificates import sdp
from robust_slam.graphs import se2

from robust_slam_course.canvas.picture import Picture
from robust_slam_course.plots.certificates import draw_ring, draw_spectrum
from robust_slam_course.style import figure_style

_TWISTED = [0, 72, 144, -144, -72]


def certificate() -> Picture:
    """Return a twisted ring of five headings, its certificate and the climb out of it."""
    return Picture(
        name="certificate",
        title="Is there a better map?",
        tries=[
            "five headings were measured to be equal, but each is 72° ahead of the one before."
            " Turn any one of them: can the cost fall?",
            "press Play to climb. Which cost is reached with a third row, and which with a"
            " fourth?",
            "choose equal headings and increase the measured turn. At which α does λ_min fall"
            " below 0?",
        ],
        caption="A ring of five headings, twisted once: its cost is 13.82, and equal headings cost"
        " 0. The certificate S has eigenvalues below 0, the smallest −1.38: not certified.",
        state={"ring": "five", "degrees": _TWISTED, "alpha": 0, "step": 0},
        data={},
        still=_certificate_still(),
    )


def _certificate_still() -> Figure:
    """Return the twisted ring and the spectrum of its certificate."""
    angles = np.radians(_TWISTED)
    edges = np.array([[k, (k + 1) % 5] for k in range(5)])
    equal = np.broadcast_to(np.eye(2), (5, 2, 2))
    R = np.hstack(list(se2.rotation(np.outer(angles, [0.0, 0.0, 1.0]))))
    _, eigenvalues = sdp.dense_certificate(sdp.connection_matrix(5, edges, equal), R)
    with figure_style():
        figure = Figure(figsize=(5.6, 3.2), layout="constrained")
        left, right = figure.subplots(1, 2)
        draw_ring(left, angles, turn=0.0)
        draw_spectrum(right, eigenvalues).set(title="eigenvalues of S")
        right.legend(loc="upper right", fontsize=9)
    return figure
