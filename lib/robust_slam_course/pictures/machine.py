"""The picture of chapter 9: the stages from the camera to the map, of which one fails."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib import pyplot as plt
from matplotlib.figure import Figure
from robust_slam.palette import PALETTE

from robust_slam_course.canvas.picture import Picture
from robust_slam_course.pictures.graphs import stored
from robust_slam_course.plots.stages import DOWN, STAGES, draw_stages
from robust_slam_course.quiz import ask
from robust_slam_course.style import figure_style

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
    "certificate": "The descent begins from headings that make two turns too many.",
    "plan": "The plan never returns to a place, so there are no closures.",
    "control": "Turns are jerky and images blur: there the odometry is ten times noisier.",
}
_FIRST = "places"  # the failure that is shown first


def machine() -> Picture:
    """Return the stages from the camera to the map, of which the reader lets one fail.

    `tools/data/machine.py` computes the outcomes.
    """
    data = _outcomes()
    first = data["outcomes"][_FIRST]
    (right, wrong), (kept, misled) = first["told"], first["kept"]
    return Picture(
        name="machine",
        title="Let one stage fail",
        question=ask(
            "The gyroscope of “Odometry (VIO)” has a bias. Which later stage reports it?",
            {
                "PCM": "PCM takes 9 of the 12 inliers for outliers, and rejects them silently.",
                "solver": "The solver rejects the inliers that PCM has left, and returns a map"
                " that is 2.97 m off.",
                "certificate": "The certificate asks only whether a better map for the kept edges"
                " exists, and none does.",
                "none": "PCM and the solver reject inliers silently, and the map of the rest is"
                " certified.",
            },
            right="none",
        ),
        tries=[
            "here “Place recognition” fails, with 24 outliers that agree. Which stage reports it?",
            "find the two failures whose map is not certified. What do they have in common?",
        ],
        caption=f"{_FAULTS[_FIRST]} The map keeps {kept} of {right} inliers and {misled} of"
        f" {wrong} outliers, is {first['off']:.2f} m off the true path, and is certified.",
        state={"broken": _FIRST},
        answer={"broken": "odometry"},
        data=data,
        still=_machine_still(data, _FIRST),
    )


def _outcomes() -> dict[str, Any]:
    """Return the stages with their places, the arrows between them, and the outcome of each."""
    stages = [
        {"key": key, "name": stage.name, "row": stage.row, "place": stage.place}
        for key, stage in STAGES.items()
    ]
    stages.append({"key": "nothing", "name": "No stage fails", "row": 8, "place": "middle"})
    for stage in stages:
        stage["fault"] = _FAULTS[str(stage["key"])]
    arrows = [[source, target, x / 10] for source, target, x, _ in DOWN]
    return {**stored("machine.json"), "stages": stages, "arrows": arrows}


@figure_style()
def _machine_still(data: dict[str, Any], broken: str) -> Figure:
    """Return the machine beside the map of one failure."""
    figure, (stages, ax) = plt.subplots(2, 1, figsize=(5.6, 9.6), height_ratios=(6.2, 3.4))
    draw_stages(stages)
    outcome = data["outcomes"][broken]
    for poses, look in ((data["truth"], ":"), (outcome["poses"], "-")):
        x, y, _ = np.reshape(poses, (-1, 3)).T
        color = PALETTE["muted" if look == ":" else "estimate"]
        ax.plot(x, y, look, color=color, label="true path" if look == ":" else "map")
    ax.set_aspect("equal")
    ax.set_axis_off()
    figure.legend(loc="outside lower center", ncols=2, fontsize=10)
    return figure
