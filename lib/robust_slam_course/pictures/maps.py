"""Pictures of a map whose closures the reader moves."""

from __future__ import annotations

import numpy as np
from matplotlib import pyplot as plt
from matplotlib.figure import Figure
from numpy.typing import NDArray
from robust_slam.consistency import pcm
from robust_slam.drawing import draw_map
from robust_slam.estimators import chi_square_threshold, gnc, switchable
from robust_slam.graphs.generate import manhattan
from robust_slam.graphs.metrics import align
from robust_slam.graphs.outliers import add_aliased_closures
from robust_slam.graphs.pose_graph import PoseGraph, select
from robust_slam.problems import PoseGraphProblem

from robust_slam_course.canvas.picture import Picture
from robust_slam_course.pictures.graphs import Array, agreeing, graph_data, map_still, with_wrong
from robust_slam_course.plots.consistency import draw_consistency
from robust_slam_course.plots.opening import draw_opening, three_maps
from robust_slam_course.quiz import ask
from robust_slam_course.style import figure_style

_AGREEING = 9  # wrong closures (i, j), (i + 1, j + 1), … that follow from one displacement


def opening() -> Picture:
    """Return the opening map: a town, its correct closures, and a wrong one to move."""
    graph, truth = manhattan(60, np.random.default_rng(3), side=8, turn=0.4, closures=10)
    wrong = [[6, 41]]
    return Picture(
        name="opening",
        title="One wrong loop closure folds the map",
        question=ask(
            "How much of the map does one wrong closure (dashed) bend?",
            {
                "its two ends": "Least squares spreads the error over all edges that are on a"
                " cycle with it, 64 of the other 69.",
                "the path between": "Correct closures pass the error on to 64 of the other 69"
                " edges.",
                "nearly all": "Correct closures tie the streets together, so 64 of the other 69"
                " edges are on a cycle with it.",
            },
            right="nearly all",
        ),
        tries=[
            "Reject outliers, and add wrong closures: how many of them get into the map that the"
            " robust solver (GNC, chapter 5) returns?",
        ],
        caption="Three maps of one drive. Without the wrong closure least squares follows the true"
        " path; with it, nearly the whole map folds; a robust kernel restores the path.",
        state={"robust": False, "wrong": wrong, "joined": False},
        answer={"joined": True},
        data=graph_data(graph, truth),
        still=draw_opening(three_maps(graph, *with_wrong(graph, wrong), truth)),
    )


def cycles() -> Picture:
    """Return a town in which the reader moves a wrong closure, and what it bends."""
    graph, truth = manhattan(100, np.random.default_rng(2), side=9, turn=0.25, closures=12)
    wrong = [36, 69]
    folded, is_outlier = with_wrong(graph, [wrong])
    return Picture(
        name="cycles",
        title="A wrong closure bends the cycles that it closes",
        question=ask(
            "Without the correct closures, how many of the 99 odometry edges are still bent?",
            {
                "0": "The 33 steps between its ends form a cycle with it, and they contradict it.",
                "33": "Only the 33 steps between its ends form a cycle with it.",
                "66": "The other 66 steps are outside its ends, where nothing contradicts it.",
                "99": "Outside its ends nothing contradicts it; only the 33 steps between them"
                " form a cycle with it.",
            },
            right="33",
        ),
        tries=[
            "Make the σ of the wrong closure small: which edges look worse than the wrong one?",
        ],
        caption="A town drawn by least squares with one wrong closure (dashed), over the dotted"
        " true path. It pulls the top right corner of the town on to the bottom street and bends"
        " every other edge except the four at each end of the drive.",
        state={"correct": True, "sigma": 0.05, "wrong": wrong},
        answer={"correct": False},
        data={**graph_data(graph, truth), "turn": 0.4},
        still=map_still(folded, PoseGraphProblem(folded).initial(), truth, is_outlier),
    )


def showcase() -> Picture:
    """Return three estimators side by side on a map with wrong closures that the reader moves."""
    graph, truth = _drive()
    wrong = [42, 9]
    return Picture(
        name="showcase",
        title="Nine wrong closures, three estimators",
        question=ask(
            "Do switches and GNC keep nine wrong closures that agree, against ten correct ones?",
            {
                "never": "This is no vote: with the diamond at pose 3, both keep all nine from"
                " least squares.",
                "from some starts": "With the diamond at pose 3, both keep all nine from least"
                " squares, none from odometry.",
                "always": "From odometry both keep none: what fits depends on the map at which"
                " they begin.",
            },
            right="from some starts",
        ),
        tries=[
            "drag the diamond to where the drive begins: do the switches and GNC follow the nine"
            " wrong closures? Then start from odometry.",
            "leave a single wrong closure. Can you find a place for its ends where the switches"
            " or GNC follow it?",
        ],
        caption="One drive with nine wrong closures that agree (dashed), over the dotted true"
        " path. Least squares and switchable constraints fold the map, and GNC does not.",
        state={"wrong": wrong, "size": _AGREEING, "start": "squares"},
        answer={"wrong": [42, 3]},
        data=graph_data(graph, truth, 4),
        still=_three_estimators(graph, truth, wrong),
    )


def starts() -> Picture:
    """Return the picture of ``showcase`` where the start decides what is kept."""
    graph, truth = _drive()
    wrong = [42, 3]
    return Picture(
        name="starts",
        script="showcase",
        title="The start decides which closures fit",
        question=ask(
            "From least squares GNC uses 3 of 10 correct closures. How many from odometry?",
            {
                "3": "In the shape of the odometry, it is the wrong closures that do not fit.",
                "7": "So many it uses from least squares with the diamond at pose 9.",
                "all ten": "No closure has bent the odometry, so the correct ones fit it first.",
            },
            right="all ten",
        ),
        tries=[
            "start from odometry and drag the diamond along the drive. Does any method follow?",
            "start from least squares and take wrong closures away. With how many does GNC"
            " reject them?",
        ],
        caption="The same drive, with the diamond at pose 3. From least squares, switchable"
        " constraints and GNC both keep all nine wrong closures (dashed).",
        state={"wrong": wrong, "size": _AGREEING, "start": "squares"},
        answer={"start": "odometry"},
        data={**graph_data(graph, truth, 4), "main": "start"},
        still=_three_estimators(graph, truth, wrong),
    )


def _drive() -> tuple[PoseGraph, Array]:
    """Return the drive of chapter 8's pictures and its true poses."""
    return manhattan(60, np.random.default_rng(6), side=6, turn=0.35, closures=10)


@figure_style()
def _three_estimators(correct: PoseGraph, truth: Array, wrong: list[int]) -> Figure:
    """Return the maps of least squares, switchable constraints and GNC side by side."""
    graph, is_outlier = with_wrong(correct, *agreeing(truth, wrong, _AGREEING))
    problem = PoseGraphProblem(graph, steps=1, tol=1e-6)
    c = chi_square_threshold(0.99, 3)
    squares = problem.initial()
    switched = switchable(problem, c**2, squares, max_iterations=300)
    robust = gnc(problem, c, x0=squares)
    answers = (
        ("least squares", squares, None),
        ("switches", switched.x, switched.weights),
        ("GNC", robust.x, robust.weights),
    )
    figure, axes = plt.subplots(1, 3, sharex=True, sharey=True, figsize=(6.0, 2.4))
    for ax, (name, poses, weights) in zip(axes, answers, strict=True):
        placed = align(poses, truth)
        draw_map(graph, placed, ax, is_outlier=is_outlier, weights=weights, truth=truth)
        ax.set_title(name)
    return figure


def consistency() -> Picture:
    """Return the closures of a town, and which of them agree."""
    rng = np.random.default_rng(3)
    graph, truth = manhattan(48, rng, side=4, turn=0.35, closures=8)
    misled, is_outlier = add_aliased_closures(graph, 1, 1, size=_AGREEING, poses=truth, apart=1.5)
    return Picture(
        name="consistency",
        title="Who agrees with whom",
        question=ask(
            "How many of the nine outliers must go before PCM is sure to keep the eight inliers?",
            {
                "none": "PCM only counts: nine that agree outvote eight, whichever of them are"
                " right.",
                "one": "With eight against eight both sets are largest, and which one is found is"
                " arbitrary.",
                "two": "PCM only counts: eight against eight is undecided, and eight outvote"
                " seven.",
                "all nine": "A majority is enough: eight that agree outvote seven.",
            },
            right="two",
        ),
        tries=[
            "Let switches draw the map, and drag an end of the nine. Where do switches find the"
            " inliers, although PCM does not?",
        ],
        caption="Left: the map that PCM and least squares give, over the true path (dotted)."
        " Right: the closures, joined where two agree; the nine outliers are the largest set.",
        state={"count": _AGREEING, "map": "pcm", "group": misled.edges[-_AGREEING].tolist()},
        answer={"count": 7},
        data={**graph_data(graph, truth, 4), "gamma": 3.37},
        still=_agreement(misled, is_outlier, truth),
    )


@figure_style()
def _agreement(graph: PoseGraph, is_outlier: NDArray[np.bool_], truth: Array) -> Figure:
    """Return the map of the closures that agree, and the graph of their agreement."""
    answer = pcm(graph, chi_square_threshold(0.99, 3))
    poses = align(PoseGraphProblem(select(graph, answer.kept)).initial(), truth)
    outlying = is_outlier[answer.closures]
    nameless = [""] * len(outlying)
    figure, (left, ring) = plt.subplots(1, 2, figsize=(6.0, 3.0))
    draw_map(graph, poses, left, is_outlier=is_outlier, kept=answer.kept, truth=truth)
    members = answer.clique.members
    draw_consistency(ring, answer.adjacency, members, is_outlier=outlying, names=nameless)
    return figure
