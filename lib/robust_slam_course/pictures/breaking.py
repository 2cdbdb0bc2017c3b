"""The game *Break the map*; `tools/data/breaking.py` computes the best possible scores."""

from __future__ import annotations

import json
from importlib.resources import files

import numpy as np
from matplotlib.figure import Figure
from robust_slam import breaking as game
from robust_slam.drawing import draw_map, map_legend

from robust_slam_course.canvas.picture import Picture
from robust_slam_course.pictures.graphs import graph_data
from robust_slam_course.quiz import Option, Question
from robust_slam_course.style import figure_style

_FIRST = "A:gnc:2-9:1,1:1"


def breaking() -> Picture:
    """Return three small towns in which the reader fools a solver with few and small outliers."""
    text = files(__package__).joinpath("breaking.json").read_text(encoding="utf-8")
    best = {key: found["score"] for key, found in json.loads(text).items()}
    first = game.attack(_FIRST)
    return Picture(
        name="breaking",
        title="Break the map",
        question=Question(
            "Town A has three inliers. How many outliers that agree does it take to fool GNC?",
            [
                Option("one", "A single one fools it at no place and with no offset."),
                Option("two", "They need not outnumber the three inliers.", correct=True),
                Option("four", "Two are enough, although there are three inliers."),
            ],
        ),
        tries=[
            "fool least squares with one outlier, and make its offset shorter. Where do its ends"
            " have to be?",
            "reach the best possible score for GNC, and copy it. Does the same attack fool"
            " Geman–McClure, or PCM before GNC?",
        ],
        caption=f"One outlier with an offset of {first.rank[1]:.2f} m bends the map of GNC in town"
        f" A by {game.bent(first):.2f} m, and {game.BOUND} m is enough to fool it. Outliers are"
        " dashed.",
        state={
            "town": first.town,
            "solver": first.solver,
            "ends": [first.i, first.j],
            "offset": [first.dx, first.dy],
            "count": first.count,
            "copied": "",
        },
        data={
            "towns": {name: graph_data(*game.town(name)[:2], 9) for name in game.TOWNS},
            "best": {key: score and game.attack(score).rank for key, score in best.items()},
            "bound": game.BOUND,
            "reach": game.REACH,
            "most": game.MOST,
        },
        still=_still(first),
    )


def _still(attack: game.Attack) -> Figure:
    """Return the map of an attacked town."""
    graph, truth, _ = game.town(attack.town)
    spoiled = game.attacked(attack)
    is_outlier = np.arange(len(spoiled.edges)) >= len(graph.edges)
    with figure_style():
        figure = Figure(figsize=(5.0, 3.6), layout="constrained")
        poses = game.SOLVERS[attack.solver](spoiled)
        draw_map(spoiled, poses, figure.subplots(), is_outlier=is_outlier, truth=truth)
        figure.legend(handles=map_legend(), loc="outside lower center", ncols=2)
    return figure
