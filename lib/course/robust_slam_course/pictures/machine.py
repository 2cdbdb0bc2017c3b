"""The picture of chapter 9: the stages from the odometry to the map, of which one fails."""

from functools import cache
from typing import Any

import numpy as np
from robust_slam.certificates import Verdict
from robust_slam.graphs import ate
from robust_slam.graphs.metrics import align

from robust_slam_course.canvas.picture import Picture
from robust_slam_course.failures import Outcome, town, turned
from robust_slam_course.pictures.graphs import map_steps, map_still, numbers
from robust_slam_course.quiz import ask

_UNIT = 0.05  # m, less than two pixels of the picture
_DIALS = {
    "odometry": ("Gyroscope’s bias", "rad", np.linspace(0.0, 0.05, 11)),
    "places": ("Mistaken places", "closures", np.arange(0.0, 25.0, 2.0)),
    "certificate": ("Wound start", "turns", np.linspace(0.0, 2.0, 9)),
}
"""What is turned at a stage, its unit, and the values that the dial has."""
_BIASED = 8  # the place of 0.04 rad


def machine() -> Picture:
    """Return the stages from the odometry to the map, each with the dial by which it fails."""
    data = _machine()
    first = turned("odometry", 0.0)
    biased = data["dials"][0]["runs"][_BIASED]
    return Picture(
        name="machine",
        title="Let one stage fail",
        question=ask(
            "A bias of the gyroscope bends the map. Which lamp lights?",
            {
                "PCM": f"PCM drops {biased['fates'][:12].count('p')} of the 12 inliers, GNC"
                " the others, and neither says so.",
                "GNC": "It drops the inliers that PCM has left, and returns a map that is"
                f" {biased['off']:.2f} m off.",
                "Certificate": "It asks only whether a better map for the kept edges exists, and"
                " there is no better one.",
                "none": "PCM and GNC drop the inliers silently, and the map of the rest is"
                " certified.",
            },
            right="none",
        ),
        tries=["Which dial lights a lamp, and what has failed there, a measurement or a search?"],
        caption=f"With every dial at 0 the map is {data['dials'][0]['runs'][0]['off']:.2f} m off"
        " the true path (dotted); the dashed outliers are rejected.",
        state={"dial": 0, "value": 0, "tried": [0] * len(_DIALS)},
        answer={"value": _BIASED, "tried": [_BIASED, 0, 0]},
        data=data,
        still=map_still(first.graph, first.poses, town()[2], first.is_outlier, first.kept),
    )


@cache
def _machine() -> dict[str, Any]:
    """Return the dials with an outcome for each of their values, and the closures that arise."""
    truth = town()[2]
    most = turned("places", 24.0).graph
    dials = [
        {
            "label": label,
            "unit": unit,
            "values": numbers(values, 3),
            "runs": [_run(turned(stage, float(by))) for by in values],
        }
        for stage, (label, unit, values) in _DIALS.items()
    ]
    return {
        "truth": numbers(truth * [1.0, 1.0, 0.0], 2),
        "closures": most.edges[~most.is_odometry].tolist(),
        "inliers": 12,
        "unit": _UNIT,
        "dials": dials,
    }


def _run(found: Outcome) -> dict[str, Any]:
    """Return a map, and for each closure where it ended: at PCM, at GNC, or "m", in the map."""
    truth, loops = town()[2], ~found.graph.is_odometry
    passed = found.kept if found.passed is None else found.passed
    fates = np.where(found.kept, "m", np.where(passed, "g", "p"))[loops]
    return {
        "fates": "".join(fates),
        "off": round(float(ate(found.poses, truth)), 2),
        "certified": found.verdict is Verdict.CERTIFIED,
        "steps": map_steps(align(found.poses, truth), _UNIT),
    }
