"""The pictures of the labs; `tools/data/labs.py` computes what the library decides in them."""

import numpy as np
from robust_slam._arrays import Array
from robust_slam.estimators import Result, chi_square_threshold, gnc, switchable
from robust_slam.graphs import ate, dead_reckoning
from robust_slam.graphs.pose_graph import select
from robust_slam.problems import PoseGraphProblem

from robust_slam_course import labs
from robust_slam_course.canvas.picture import Picture
from robust_slam_course.pictures.graphs import (
    graph_data,
    map_still,
    numbers,
    stored,
)
from robust_slam_course.quiz import ask


def arena() -> Picture:
    """Return two solvers on one town, with as many outliers as the reader likes."""
    table = stored("arena.json")
    solvers = table.pop("solvers")
    whole = {kind: labs.spoiled(kind, labs.PERCENTS[-1]) for kind in labs.KINDS}
    graph, is_outlier, truth = labs.spoiled("random", 20)
    _, letters, _, _ = table["runs"]["random 20"][solvers.index("GNC")]
    found: Result[Array] = gnc(graph, chi_square_threshold(0.99, 3))
    return Picture(
        name="arena",
        title="As many outliers as you like",
        question=ask(
            "Up to which share of random outliers is GNC’s map good, less than 0.5 m off?",
            {
                "30 %": "Up to 70 % it finds the same good map.",
                "70 %": "Up to there its map is 0.27 m off, and at 80 % 1.42 m.",
                "90 %": "With the 40 outliers of 80 % its map is already 1.42 m off.",
            },
            right="70 %",
        ),
        tries=[
            "Let the outliers agree, in groups of 15. At which share does GNC follow them, and"
            " which solver does not?",
        ],
        caption=f"GNC lets none of {np.sum(is_outlier)} outliers in and keeps"
        f" {letters[:10].count('1')} inliers.",
        state={"percent": 20, "kind": "random", "right": "least squares"},
        answer={"percent": 70},
        data={
            "table": table,
            "solvers": solvers,
            "kinds": list(labs.KINDS),
            "truth": numbers(truth * [1.0, 1.0, 0.0], 2),
            "inliers": graph.edges[~graph.is_odometry & ~is_outlier].tolist(),
            "outliers": {
                kind: each.edges[wrong].tolist() for kind, (each, wrong, _) in whole.items()
            },
        },
        still=map_still(graph, found.x, truth, is_outlier, found.weights >= 0.25),
    )


def growing() -> Picture:
    """Return a map that grows with the drive and withdraws an outlier."""
    graph, truth = labs.late_town()
    last = graph.n - 1
    is_outlier = np.arange(len(graph.edges)) == len(graph.edges) - 1
    poses = PoseGraphProblem(select(graph, ~is_outlier)).initial()
    return Picture(
        name="growing",
        title="A map that changes its mind",
        question=ask(
            "The outlier arrives at pose 17, and nothing contradicts it. When is it withdrawn?",
            {
                "at the next closure": "Two arrive at pose 23, but the map bends to fit them.",
                "when one contradicts it clearly": "It is the closure from 17 to 29, twelve poses"
                " later.",
                "never": "Whenever the map moves, every closure is examined again.",
            },
            right="when one contradicts it clearly",
        ),
        tries=[
            "Let the outlier arrive later. From which pose on is it rejected on arrival?",
        ],
        caption=f"The map of the whole drive, to pose {last}, without the outlier from 6 to 17.",
        state={"pose": 16, "arrives": labs.ARRIVALS[0]},
        answer={"pose": 29},
        data={
            **graph_data(graph, truth, 4),
            "minds": stored("labs.json")["minds"],
            "arrivals": list(labs.ARRIVALS),
            "last": last,
        },
        still=map_still(graph, poses, truth, is_outlier, ~is_outlier),
    )


def proofs() -> Picture:
    """Return runs of two reweighting loops from headings that the reader winds, all certified."""
    graph, is_outlier, _ = labs.ring(0)
    best, runs = labs.best_of_ring(), stored("labs.json")["proofs"]
    first: Result[Array] = gnc(graph, chi_square_threshold(0.99, 3), x0=dead_reckoning(graph))
    loops = ~graph.is_odometry
    fates = {
        solver: "".join("w" if run["off"] > labs.GOOD else "g" for run in each)
        for solver, each in runs.items()
    }
    thrice = labs.TURNS.index(3.0)
    return Picture(
        name="proofs",
        title="Certify inside the loop",
        question=ask(
            "Every weighted problem of a run is certified. Is its last map good, within 0.1 m?",
            {
                "yes": "From headings that are wound three times every certificate succeeds, and"
                " the map is lost.",
                "not always": "Each certificate is about its own weights, and these may be wrong.",
                "no": "From odometry all certificates succeed, and the map is good.",
            },
            right="not always",
        ),
        tries=["Let switches solve. Does a certificate fail, and is the map good?"],
        caption="A ring of two rounds with 12 inliers and four outliers. From odometry all"
        f" {len(runs['gnc'][0]['signs'])} certificates of GNC succeed, and the map is"
        f" {runs['gnc'][0]['off']:.2f} m from the best one.",
        state={"solver": "gnc", "wound": 0, "tried": {}},
        answer={"wound": thrice, "tried": {"gnc": fates["gnc"]}},
        data={
            "turns": list(labs.TURNS),
            "best": numbers(best * [1.0, 1.0, 0.0], 2),
            "closures": graph.edges[loops].tolist(),
            "inliers": int(np.sum(loops & ~is_outlier)),
            "unit": labs.UNIT,
            "runs": runs,
        },
        still=map_still(graph, first.x, best, is_outlier, first.weights >= 0.25),
    )


def priors() -> Picture:
    """Return a town whose closures claim to be inliers, and switches that weigh the claim."""
    town, log_odds = labs.scored_town()
    graph, is_false = town.graph, town.is_false
    best = PoseGraphProblem(select(graph, ~is_false)).initial()
    found = switchable(graph, chi_square_threshold(0.99, 3) ** 2, dead_reckoning(graph))
    loops = ~graph.is_odometry
    used = found.weights >= 0.25
    return Picture(
        name="priors",
        title="How sure may a closure be?",
        question=ask(
            f"All {town.scores.size} closures claim 99.9 %, and {np.sum(is_false)} are outliers."
            " Is the map lost, over 0.1 m off?",
            {
                "yes": "Log-odds of 7 raise λ from 11 to 25 only, and the residuals of outliers"
                " are larger.",
                "no": "The residuals overrule the claim, and the map stays good.",
            },
            right="no",
        ),
        tries=[
            "Add the log-odds of the scores. Does the map become better, or lost later?",
        ],
        caption=f"A claim of log-odds 0 keeps all {np.sum(is_false & ~used)} outliers out,"
        f" beside {np.sum(used & loops & ~is_false)} of"
        f" {np.sum(loops & ~is_false)} inliers. The map is {ate(found.x, best):.2f} m from the"
        " best one.",
        state={"odds": 0, "score": False},
        answer={"odds": 7},
        data={
            **graph_data(graph, best, 6),
            "best": numbers(best, 4),
            "outlier": is_false[loops].astype(int).tolist(),
            "logOdds": np.round(log_odds, 3).tolist(),
        },
        still=map_still(graph, found.x, best, is_false, used),
    )
