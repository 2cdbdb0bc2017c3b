"""The picture of robots that share a map."""

import numpy as np
from matplotlib import pyplot as plt
from matplotlib.figure import Figure
from robust_slam.estimators import chi_square_threshold
from robust_slam.fleet import rounds
from robust_slam.graphs.generate import manhattan
from robust_slam.graphs.pose_graph import PoseGraph, select

from robust_slam_course.canvas.picture import Picture
from robust_slam_course.pictures.graphs import Array, graph_data, with_wrong
from robust_slam_course.plots.robots import draw_robots
from robust_slam_course.quiz import ask
from robust_slam_course.style import figure_style

_EACH = 20  # poses of a robot
_MEETING = [[52, 12]]


def robots() -> Picture:
    """Return three robots that agree on one map by exchanging poses; C meets the others rarely."""
    graph, truth, labels = _three_robots()
    between = np.ptp(labels[graph.edges], axis=1) > 0
    with_c = np.flatnonzero(between & (labels[graph.edges] == 2).any(axis=1))
    joined, _ = with_wrong(graph, _MEETING)
    # Robot C shares the wrong closure alone, which comes last.
    spoiled = select(joined, ~np.isin(np.arange(len(joined.edges)), with_c))
    c = chi_square_threshold(0.99, 3)
    first = rounds.solve(spoiled, labels, c, max_rounds=60, tol=1e-3).rounds[0]
    far = np.linalg.norm((first.poses - truth)[:, :2], axis=1)
    off_b, off_c = (far[labels == robot].mean() for robot in (1, 2))
    return Picture(
        name="robots",
        title="Three robots agree on one map",
        question=ask(
            "How many correct closures of C are enough to expose its wrong one?",
            {
                "none": "As long as it is alone nothing contradicts it, and its residual is 0.",
                "one": "With one correct closure there is one vote each; here the wrong one stays,"
                " because C has aligned its map by it.",
                "two": "Two that are correct agree, whereas with only one there is one vote each.",
                "all eight": "The first two already agree against it.",
            },
            right="two",
        ),
        tries=[
            "Show what each robot knows: its own poses, and as rings those that it was sent. Which"
            " poses of the others does C need?",
        ],
        caption="When the robots have just met, C trusts its wrong closure, which nothing"
        f" contradicts. It is {off_c:.2f} m off, and B {off_b:.2f} m.",
        state={"wrong": _MEETING, "correct": 0, "round": 0, "views": False},
        answer={"correct": 2, "round": 53},
        data={
            **graph_data(graph, truth, 3),
            "labels": labels.tolist(),
            "withC": with_c.tolist(),
            "wrong": _MEETING,
        },
        still=_robots_still(spoiled, labels, first),
    )


def _three_robots() -> tuple[PoseGraph, Array, np.ndarray]:
    """Return a town of three walks with correct closures, its true poses, and their robots."""
    labels = np.arange(3 * _EACH) // _EACH
    rng = np.random.default_rng(40)
    graph, truth = manhattan(3 * _EACH, rng, side=6, turn=0.25, closures=16)
    parted = np.ptp(labels[graph.edges], axis=1) > 0
    # Three walks, not one: no odometry leads from robot to robot.
    return select(graph, ~(graph.is_odometry & parted)), truth, labels


@figure_style()
def _robots_still(spoiled: PoseGraph, labels: np.ndarray, shown: rounds.Round) -> Figure:
    """Return a round of the robots' exchange."""
    is_outlier = np.arange(len(spoiled.edges)) == len(spoiled.edges) - 1
    figure, ax = plt.subplots(figsize=(5.0, 4.4))
    draw_robots(ax, spoiled, shown.poses, labels, shown.weights, is_outlier=is_outlier)
    for name, pose in zip("ABC", shown.poses[::_EACH], strict=True):
        ax.annotate(f"robot {name}", pose[:2], (6, 6), textcoords="offset points")
    return figure
