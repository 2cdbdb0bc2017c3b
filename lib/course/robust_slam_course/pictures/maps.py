"""Pictures of a map whose closures the reader moves."""

from typing import Any

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
                "0": "The 33 steps between its ends, 36 and 69, form a cycle with it, and they"
                " contradict it.",
                "33": "Only the 33 steps between its ends, 36 and 69, form a cycle with it.",
                "66": "The other 66 steps are outside its ends, 36 and 69, where nothing"
                " contradicts it.",
                "99": "Outside its ends, 36 and 69, nothing contradicts it; only the 33 steps"
                " between them form a cycle with it.",
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


_END = 42
_PLACES = 52  # for the other end of the first of nine wrong closures
_LOST = {
    "gnc squares": {1, 2, 3, 4, 5, 6, 13, 14, 18, 19, 20, 29, 30},
    "gnc odometry": {18},
}
"""From which places the nine bend the map of a method and a start by more than 0.4 m."""


def _tried(run: str) -> str:
    """Return the ribbon of a run as the reader's drag paints it, a letter for each place."""
    near = range(_END - 1, _END + 2)
    return "".join("." if k in near else "w" if k in _LOST[run] else "g" for k in range(_PLACES))


def showcase() -> Picture:
    """Return the map of one of three methods, and wrong closures to drag along the drive."""
    lost, places = len(_LOST["gnc squares"]), _PLACES - 3
    return _dragged(
        "showcase",
        "Nine wrong closures that agree",
        "Drag the diamond: from how many places do nine wrong closures bend GNC’s map?",
        {
            "none": f"This is no vote against ten correct ones: from {lost} of {places} places"
            " the nine win.",
            "a quarter": f"{lost} of {places}, poses 1 to 6 among them, where least squares"
            " has hidden their error.",
            "half": f"GNC rejects all nine from most places, but from {lost} of {places}"
            " they win.",
        },
        "a quarter",
        "Choose least squares, and drag to where GNC is lost. Which places has the start bent?",
        {"place": 3, "tried": {"gnc squares": _tried("gnc squares")}},
        place=9,
        tried={},
        main="method",
    )


def starts() -> Picture:
    """Return the picture of ``showcase`` where the start is chosen, and one is tried already."""
    (exception,) = _LOST["gnc odometry"]
    tried = {"gnc squares": _tried("gnc squares")}
    return _dragged(
        "starts",
        "The start decides which closures fit",
        f"GNC is lost from {len(_LOST['gnc squares'])} places. From how many if it starts from"
        " odometry?",
        {
            "one": f"Only from pose {exception}, and there the map is 0.58 m off.",
            "half as many": f"Only one is left, pose {exception}: no closure has bent the"
            " odometry, so the correct ones fit it first.",
            "as many": "The measurements are the same, but in the shape of the odometry it is the"
            " wrong closures that do not fit.",
        },
        "one",
        "From which places do the switches follow the nine, from either start?",
        {
            "start": "odometry",
            "place": exception,
            "tried": tried | {"gnc odometry": _tried("gnc odometry")},
        },
        place=3,
        tried=tried,
        main="start",
    )


def _dragged(
    name: str, title: str, prompt: str, answers: dict[str, str], right: str, to_try: str,
    answer: dict[str, Any], *, place: int, tried: dict[str, str], main: str,
) -> Picture:  # fmt: skip
    """Return the drive of chapter 8 with nine wrong closures from pose 42 to ``place`` on."""
    graph, truth = _drive()
    return Picture(
        name=name,
        script="showcase",
        title=title,
        question=ask(prompt, answers, right),
        tries=[to_try],
        caption="One drive with nine wrong closures that agree (dashed), over the dotted true"
        f" path, with the diamond at pose {place}: the maps of least squares, switches and GNC.",
        state={"place": place, "method": "gnc", "start": "squares", "tried": tried},
        answer=answer,
        data={**graph_data(graph, truth, 4), "end": _END, "main": main},
        still=_three_estimators(graph, truth, [_END, place]),
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
                "one": "Eight against eight is a tie: both sets are largest, and which one PCM"
                " keeps is arbitrary.",
                "two": "PCM only counts: eight against eight is a tie, and eight outvote seven.",
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
