"""Pictures of certificates: headings on a ring and the proof that none cost less."""

import numpy as np
from matplotlib import pyplot as plt
from matplotlib.figure import Figure
from robust_slam.certificates import sdp
from robust_slam.groups import se2

from robust_slam_course.canvas.picture import Picture
from robust_slam_course.pictures.graphs import Array
from robust_slam_course.plots.certificates import draw_ring, draw_spectrum
from robust_slam_course.quiz import ask
from robust_slam_course.style import figure_style

_TWISTED = [0, 72, 144, -144, -72]
_REST = {"held": 1, "turn": 0, "far": 0}


def certificate() -> Picture:
    """Return a twisted ring of five headings to pull, and its certificate."""
    Q, R = _twisted_ring()
    _, eigenvalues = sdp.dense_certificate(Q, R)
    lowest = f"{eigenvalues[0]:.2f}".replace("-", "−")
    return Picture(
        name="certificate",
        title="Is there a better map?",
        question=ask(
            "All headings were measured equal. Pull one: which turn lowers the cost?",
            {
                "a small one": "The pulls on each arrow balance, and pull it back when it turns.",
                "none": "Turn an arrow that is not beside the nail by more than 54° one way, or"
                " 36° the other: the ring untwists, and the cost falls.",
                "only a large one": "Small turns raise the cost; beyond 54° one way, or 36° the"
                " other, two neighbours are over 90° apart, and the ring untwists.",
            },
            right="only a large one",
        ),
        tries=[
            "Twist the ring again and pull the arrow beside the nail. How far must it turn?",
        ],
        caption="A ring of five headings, twisted once, costs"
        f" {np.trace(R @ Q @ R.T):.2f}; equal headings cost 0. The smallest eigenvalue of the"
        f" certificate S is {lowest}, so the ring is not certified.",
        state=_REST | {"ring": "five", "alpha": 0, "twisted": True},
        answer={"held": 3, "turn": 90, "far": 90},
        data={"main": "Let go"},
        still=_certificate_still(eigenvalues),
    )


def turning() -> Picture:
    """Return the picture of ``certificate`` with three equal headings and the turn as control."""
    return Picture(
        name="turning",
        script="certificate",
        title="Where equal headings stop being best",
        question=ask(
            "Up to which α are three equal headings certified?",
            {
                "30°": "The eigenvalues there are 0, 1.73 and 3.46, each of them twice.",
                "60°": "There, turning each heading by 120° costs as much; beyond, it costs less.",
                "90°": "Up to 90° they are a local minimum, but from 60° on not the lowest.",
            },
            right="60°",
        ),
        tries=[
            "Choose five headings, and find the α at which equal ones stop being best.",
        ],
        caption="Three equal headings, each measured to be turned by α from the one before, and"
        " the eigenvalues of their S for every α. Up to 60° none is negative.",
        state=_REST | {"ring": "three", "alpha": 0, "twisted": False},
        answer={"alpha": 60},
        data={"main": "alpha"},
        still=_turning_still(),
    )


def _twisted_ring() -> tuple[Array, Array]:
    """Return the connection matrix of the ring and its headings as rotations, side by side."""
    edges = np.array([[k, (k + 1) % 5] for k in range(5)])
    equal = np.broadcast_to(np.eye(2), (5, 2, 2))
    R = np.hstack(list(se2.rotation(np.outer(np.radians(_TWISTED), [0.0, 0.0, 1.0]))))
    return sdp.connection_matrix(5, edges, equal), R


@figure_style()
def _certificate_still(eigenvalues: Array) -> Figure:
    """Return the twisted ring and the spectrum of its certificate."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(5.6, 3.2))
    draw_ring(left, np.radians(_TWISTED))
    draw_spectrum(right, eigenvalues).set(title="eigenvalues of S")
    right.legend(loc="upper right", fontsize=9)
    return figure


@figure_style()
def _turning_still() -> Figure:
    """Return the eigenvalues of S over α for a ring of three with equal headings."""
    alpha = np.linspace(0.0, 90.0, 181)
    figure, ax = plt.subplots(figsize=(5.6, 3.0))
    for k, dash in zip((0, 1, 2), ("-", "--", ":"), strict=True):
        values = 2 * (np.cos(np.radians(alpha)) - np.cos(np.radians(alpha + 120 * k)))
        ax.plot(alpha, values, dash, label=f"k = {k}")
    ax.axvspan(60.0, 90.0, color="0.9", zorder=0)
    ax.text(75.0, 3.0, "not certified", ha="center")
    ax.text(17.0, 0.6, "certified", ha="center")
    ax.set(xlabel="α in degrees", ylabel="eigenvalues of S, twice each")
    ax.legend(loc="lower left")
    return figure
