"""The picture of the game: its words, its first state and its data."""

import numpy as np

from robust_slam_course.canvas.picture import Picture
from robust_slam_course.pictures.breaking import rules as game
from robust_slam_course.pictures.graphs import graph_data, map_still, stored
from robust_slam_course.quiz import ask

_FIRST = "A:gnc:0-9:1,1:2"


def breaking() -> Picture:
    """Return three small towns in which the reader fools a solver with few and small outliers."""
    best = {key: found["score"] for key, found in stored("breaking/best.json").items()}
    first, shown = game.attack(_FIRST), game.attack(best["A:gnc"])
    graph, truth, _ = game.town(first.town)
    spoiled = game.attacked(first)
    is_outlier = np.arange(len(spoiled.edges)) >= len(graph.edges)
    return Picture(
        name="breaking",
        title="Break the map",
        question=ask(
            "Town A has three inliers. How many outliers that agree does it take to fool GNC?",
            {
                "one": "A single one fools it at no place and with no offset.",
                "two": "They need not outnumber the three inliers.",
                "four": "Two are enough, although there are three inliers.",
            },
            right="two",
        ),
        tries=[
            "Town B has four inliers. With how few outliers can you fool GNC there?",
        ],
        caption=f"Two outliers with an offset of {first.rank[1]:.2f} m bend the map of GNC in town"
        f" A by {game.bent(first):.2f} m, and {game.BOUND} m is enough to fool it. Outliers are"
        " dashed.",
        state={
            "town": first.town,
            "solver": first.solver,
            "ends": [first.i, first.j],
            "offset": [first.dx, first.dy],
            "count": first.count,
            "tried": {},
        },
        answer={"ends": [shown.i, shown.j], "offset": [shown.dx, shown.dy], "count": shown.count},
        data={
            "towns": {name: graph_data(*game.town(name)[:2], 9) for name in game.TOWNS},
            "best": {key: score and game.attack(score).rank for key, score in best.items()},
            "bound": game.BOUND,
            "reach": game.REACH,
            "most": game.MOST,
        },
        still=map_still(spoiled, game.SOLVERS[first.solver](spoiled), truth, is_outlier),
    )
