"""Pictures of chapter 9: stages that fail, methods compared, and robots that share a map."""

from __future__ import annotations

import csv
import json
from importlib.resources import files
from typing import Any

import numpy as np
from matplotlib import pyplot as plt
from matplotlib.figure import Figure
from robust_slam.estimators import chi_square_threshold
from robust_slam.fleet import rounds
from robust_slam.graphs.generate import manhattan
from robust_slam.graphs.pose_graph import PoseGraph, select, with_closures
from robust_slam.palette import PALETTE

from robust_slam_course.canvas.picture import Picture
from robust_slam_course.pictures.graphs import Array, graph_data
from robust_slam_course.plots.robots import draw_robots
from robust_slam_course.plots.stages import DOWN, STAGES, draw_stages

_FAULTS = {
    "nothing": "No stage fails.",
    "sensors": "The focal length is 5 % too short, so every turn is measured 5 % too large.",
    "features": "The odometry is five times as noisy as it claims.",
    "views": "Two views give no scale: each step is measured 1 % shorter than the one before.",
    "places": "One street is mistaken for another, 24 times in a row.",
    "ransac": "RANSAC returns a wrong motion: one step of the odometry turns by 45° too much.",
    "odometry": "The gyroscope has a bias: each step turns by 0.04 rad too much.",
    "pcm": "PCM is left out.",
    "solve": "All closures go into plain least squares.",
    "certificate": "The descent begins with headings that wind twice too often.",
    "plan": "The plan never returns to a place, so there are no closures.",
    "control": "Turns are jerky and images blur: there the odometry is ten times noisier.",
}


def machine() -> Picture:
    """Return the stages from the camera to the map, of which the reader lets one fail.

    `benchmarks.machine` computes the outcomes, with the cells of chapter 9.
    """
    data = _outcomes()
    return Picture(
        name="machine",
        title="Let one stage fail",
        tries=[
            "let “Odometry (VIO)” fail: its gyroscope has a bias. Which later stage reports it,"
            " the consistency test, the solver or the certificate?",
            "then let “Place recognition” fail, with 24 outliers that agree. Which stage"
            " reports something now?",
            "find the two failures whose map is not certified. What do they have in common?",
        ],
        caption=f"{_FAULTS['nothing']} Of 12 inliers and 6 outliers PCM keeps 12 and 0, GNC 12 and"
        " 0, the map 12 and 0. The map is 0.09 m off and certified.",
        state={"broken": "nothing"},
        data=data,
        still=_machine_still(data, "nothing"),
    )


def _outcomes() -> dict[str, Any]:
    """Return the stages with their places, the arrows between them, and the outcome of each."""
    found = json.loads(files(__package__).joinpath("machine.json").read_text(encoding="utf-8"))
    stages = [
        {"key": key, "name": stage.name, "row": stage.row, "place": stage.place}
        for key, stage in STAGES.items()
    ]
    stages.append({"key": "nothing", "name": "No stage fails", "row": 8, "place": "middle"})
    for stage in stages:
        stage["fault"] = _FAULTS[str(stage["key"])]
    poses = np.concatenate(
        [np.reshape(each["poses"], (-1, 3)) for each in found["outcomes"].values()]
    )
    extent = [*poses.min(axis=0), *poses.max(axis=0)]
    arrows = [[source, target, x / 10] for source, target, x, _ in DOWN]
    return {**found, "stages": stages, "arrows": arrows, "extent": extent}


def _machine_still(data: dict[str, Any], broken: str) -> Figure:
    """Return the machine beside the map of one failure."""
    figure, (stages, ax) = plt.subplots(
        2, 1, figsize=(5.6, 9.6), height_ratios=(6.2, 3.4), layout="constrained"
    )
    draw_stages(stages)
    outcome = data["outcomes"][broken]
    for poses, look in ((data["truth"], ":"), (outcome["poses"], "-")):
        x, y, _ = np.reshape(poses, (-1, 3)).T
        color = PALETTE["muted" if look == ":" else "estimate"]
        ax.plot(x, y, look, color=color, label="true path" if look == ":" else "map")
    ax.set_aspect("equal")
    ax.set_axis_off()
    ax.legend(loc="upper right", fontsize=10)
    plt.close(figure)
    return figure


_STARTS = ("odometry", "least squares")
_METHODS = ("IRLS-TLS", "GNC-TLS", "IRLS-GM", "GNC-GM")


def graduation() -> Picture:
    """Return good maps of two starts and four methods, over odometry noise and claimed σ."""
    data = _counts()
    return Picture(
        name="graduation",
        title="The start, or graduation?",
        tries=[
            "let half of the closures be consistent outliers, with 0.05 rad of noise a step. What"
            " saves more maps: to start at odometry, or to graduate, GNC in place of IRLS?",
            "drag the point up and down. Which method fails first when the claimed σ is too small,"
            " and which one is best when it is eight times too large?",
            "drag the point to noisier odometry. What becomes of the methods that start at least"
            " squares? And with 75 % of outliers?",
        ],
        caption="Noise 0.01 rad a step, the true σ is claimed. 50 % of the closures are random"
        " outliers. Good maps of 10: from odometry GNC-TLS, IRLS-GM and GNC-GM have 10; from least"
        " squares GNC-TLS, IRLS-GM and GNC-GM have 10.",
        state={"kind": "random", "percent": "50", "noise": 0, "claim": 2},
        data=data,
        still=_counts_still(data, "random 50"),
    )


def _counts() -> dict[str, Any]:
    """Return the table of `benchmarks.graduation` for the script.

    Under "good" the counts of each kind and percent of outliers are nested by start, method,
    claimed σ and noise.
    """
    text = files(__package__).joinpath("graduation.csv").read_text(encoding="utf-8")
    first, *lines = text.splitlines()
    rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    noises, claims = (sorted({float(row[key]) for row in rows}) for key in ("noise", "claim"))
    place = {(r["kind"], r["percent"], float(r["noise"]), float(r["claim"])): r for r in rows}
    good = {
        f"{kind} {percent}": [
            [
                [
                    [int(place[kind, percent, n, c][f"{m} from {s}"]) for n in noises]
                    for c in claims
                ]
                for m in _METHODS
            ]
            for s in _STARTS
        ]
        for kind in ("random", "consistent")
        for percent in ("50", "75")
    }
    runs = int(first.split(":")[0].rsplit(" ", 1)[1])
    return {
        "starts": _STARTS, "methods": _METHODS, "noises": noises, "claims": claims, "runs": runs,
        "good": good,
    }  # fmt: skip


def _counts_still(data: dict[str, Any], kind: str) -> Figure:
    """Return the heat maps of both starts."""
    figure, axes = plt.subplots(
        4, 2, figsize=(5.0, 6.6), sharex=True, sharey=True, layout="constrained"
    )
    for s, start in enumerate(data["starts"]):
        for m, method in enumerate(data["methods"]):
            ax, grid = axes[m, s], np.array(data["good"][kind][s][m])
            ax.imshow(grid, origin="lower", cmap="Blues", vmin=0, vmax=data["runs"], aspect="auto")
            ax.set_title(f"{method} from {start}", fontsize=10)
            ax.set_xticks(range(len(data["noises"])), [f"{noise:g}" for noise in data["noises"]])
            ax.set_yticks(range(len(data["claims"])), ["¼", "½", "1", "2", "4", "8"])
            ax.tick_params(labelsize=9, length=0)
            ax.grid(visible=False)
    figure.supxlabel("odometry noise (rad a step)", fontsize=10)
    figure.supylabel("claimed σ, in true ones", fontsize=10)
    plt.close(figure)
    return figure


_EACH = 20  # poses of a robot
_MEETING = [[52, 12]]


def robots() -> Picture:
    """Return three robots that agree on one map by exchanging poses; C meets the others rarely."""
    graph, truth, labels = _three_robots()
    between = np.ptp(labels[graph.edges], axis=1) > 0
    with_c = np.flatnonzero(between & (labels[graph.edges] == 2).any(axis=1))
    information = graph.information[~graph.is_odometry][0]
    return Picture(
        name="robots",
        title="Three robots agree on one map",
        tries=[
            "robot C shares one closure with the others, and it is wrong: its map is 5 m off. How"
            " many correct closures does C need until the wrong one is rejected?",
            "give C exactly one correct closure. Which of the two is rejected, and could a robot"
            " know better?",
            "give C all eight, go to round 0 and play. When is the wrong closure rejected? Add"
            " another, and drag its ends.",
        ],
        caption="Round 13 of 13. Rejected of C’s closures: 0 of 1 wrong. Its residual is 0:"
        " nothing contradicts it. B is 0.35 m off, C 5.07 m.",
        state={"wrong": _MEETING, "correct": 0, "round": 999},
        data={
            **graph_data(graph, truth, 3),
            "labels": labels.tolist(),
            "withC": with_c.tolist(),
            "wrong": _MEETING,
            "wrongInformation": information.ravel().tolist(),
        },
        still=_robots_still(graph, labels, with_c, information),
    )


def _three_robots(seed: int = 40) -> tuple[PoseGraph, Array, np.ndarray]:
    """Return a town of three walks with correct closures, its true poses, and their robots."""
    labels = np.arange(3 * _EACH) // _EACH
    rng = np.random.default_rng(seed)
    graph, truth = manhattan(3 * _EACH, rng, side=6, turn=0.25, closures=16)
    parted = np.ptp(labels[graph.edges], axis=1) > 0
    # Three walks, not one: no odometry leads from robot to robot.
    return select(graph, ~(graph.is_odometry & parted)), truth, labels


def _robots_still(
    graph: PoseGraph, labels: np.ndarray, with_c: np.ndarray, wrong: Array
) -> Figure:
    """Return the last round where robot C shares the wrong closure alone."""
    joined = with_closures(graph, _MEETING, np.zeros((1, 3)), wrong[None])
    spoiled = select(joined, ~np.isin(np.arange(len(joined.edges)), with_c))
    last = rounds.solve(spoiled, labels, chi_square_threshold(0.99, 3), max_rounds=60).rounds[-1]
    is_outlier = np.arange(len(spoiled.edges)) == len(spoiled.edges) - 1
    figure, ax = plt.subplots(figsize=(5.0, 4.4), layout="constrained")
    draw_robots(ax, spoiled, last.poses, labels, last.weights, is_outlier=is_outlier)
    for name, pose in zip("ABC", last.poses[::_EACH], strict=True):
        ax.annotate(f"robot {name}", pose[:2], (6, 6), textcoords="offset points")
    plt.close(figure)
    return figure
