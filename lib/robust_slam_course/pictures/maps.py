"""Pictures of a map whose closures the reader moves."""

from __future__ import annotations

import numpy as np
from robust_slam.graphs.generate import manhattan

from robust_slam_course.canvas.picture import Picture
from robust_slam_course.pictures.graphs import graph_data
from robust_slam_course.plots import opening as opening_plot

_WRONG = [[7, 38]]


def opening() -> Picture:
    """Return the opening map: a town, its closures, and a wrong one to move."""
    graph, truth = manhattan(60, np.random.default_rng(2), side=7, turn=0.3, closures=8)
    data = graph_data(graph, truth)
    # As precise as the closures that are correct: nothing but the others contradict it.
    closure = int(np.flatnonzero(~graph.is_odometry)[0])
    data["wrongInformation"] = graph.information[closure].ravel().tolist()
    scene = opening_plot.town()
    return Picture(
        name="opening",
        title="One wrong loop closure folds the map",
        tries=[
            "the two orange handles claim that two distant poses are the same place. What happens"
            " to the map if you drag one of them across the town?",
            "switch to the robust estimator, then drag again. Add more wrong closures until it"
            " fails, too.",
        ],
        caption="Left: the map without the wrong closure. Middle: least squares folds it. Right:"
        " a robust estimator rejects the wrong closure.",
        state={"robust": False, "wrong": _WRONG},
        data=data,
        still=opening_plot.draw_opening(scene),
    )
