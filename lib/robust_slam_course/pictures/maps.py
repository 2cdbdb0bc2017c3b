"""Pictures of a map whose closures the reader moves."""

from __future__ import annotations

import numpy as np
from robust_slam.graphs.generate import manhattan
from robust_slam.graphs.pose_graph import PoseGraph, with_closures

from robust_slam_course.canvas.picture import Picture
from robust_slam_course.pictures.graphs import Array, graph_data
from robust_slam_course.plots.opening import Town, draw_opening, three_maps

_WRONG = [[6, 41]]


def opening() -> Picture:
    """Return the opening map: a town, its closures, and a wrong one to move."""
    graph, truth = manhattan(60, np.random.default_rng(3), side=8, turn=0.4, closures=10)
    # As precise as the correct closures: nothing but the other edges contradicts it.
    information = graph.information[~graph.is_odometry][0]
    return Picture(
        name="opening",
        title="One wrong loop closure folds the map",
        tries=[
            "the dashed closure claims that two distant poses are one place. Which part of the map"
            " moves most when you drag one of its ends?",
            "switch to the robust estimator and drag again. Then add wrong closures until it"
            " fails, too.",
        ],
        caption="Three maps of one drive: least squares without the wrong closure follows the true"
        " path, with it the map folds, and a robust kernel brings the path back.",
        state={"robust": False, "wrong": _WRONG},
        data={**graph_data(graph, truth), "wrongInformation": information.ravel().tolist()},
        still=draw_opening(_three_maps(graph, truth, information)),
    )


def _three_maps(correct: PoseGraph, truth: Array, information: Array) -> Town:
    """Return the maps of the first state."""
    graph = with_closures(correct, _WRONG, np.zeros((1, 3)), information[None])
    is_outlier = np.arange(len(graph.edges)) >= len(correct.edges)
    return three_maps(correct, graph, is_outlier, truth)
