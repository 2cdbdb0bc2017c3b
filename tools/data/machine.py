"""What each failing stage of chapter 9 does to the map: the table of its live picture.

python -m tools.data.machine
python -m tools.data.machine --out lib/robust_slam_course/pictures/machine.json
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from robust_slam._arrays import Array, Mask
from robust_slam.certificates import Verdict
from robust_slam.graphs import ate
from robust_slam.graphs.metrics import align
from robust_slam_course.failures import Outcome, outcome, town
from robust_slam_course.plots.stages import STAGES

from tools.data import make


def table() -> dict[str, Any]:
    """Return the true poses and the outcome of each stage."""
    truth = town()[2]
    outcomes = {stage: _of_stage(truth, outcome(stage)) for stage in ("nothing", *STAGES)}
    return {"truth": _flat(truth), "outcomes": outcomes}


def _of_stage(truth: Array, found: Outcome) -> dict[str, Any]:
    graph, is_outlier = found.graph, found.is_outlier
    masks = found.passed, found.left, found.kept
    loops = ~graph.is_odometry
    passed, left, kept = (_counts(loops, is_outlier, mask) for mask in masks)
    kinds = 2 * is_outlier.astype(int) + ~found.kept
    closures = np.column_stack([graph.edges, kinds])[loops]
    return {
        "told": _counts(loops, is_outlier, np.ones_like(loops)),
        "passed": passed,
        "left": left,
        "kept": kept,
        "certified": found.verdict is Verdict.CERTIFIED,
        "off": round(float(ate(found.poses, truth)), 4),
        "poses": _flat(align(found.poses, truth)),
        "closures": closures.tolist(),
    }


def _counts(loops: Mask, is_outlier: Mask, mask: Mask | None) -> list[int] | None:
    """Return how many correct and how many wrong closures a mask over the edges has."""
    if mask is None:
        return None
    return [int(np.sum(mask & loops & which)) for which in (~is_outlier, is_outlier)]


def _flat(poses: Array) -> list[float]:
    """Return x, y and 0 of each pose: a drawing has no headings."""
    flat = np.column_stack([poses[:, :2], np.zeros(len(poses))])
    return [round(float(value), 2) for value in np.ravel(flat)]


def told(made: dict[str, Any]) -> Iterator[str]:
    """Yield what the later stages report of each failing one."""
    for stage, found in made["outcomes"].items():
        reports = (found[key] for key in ("off", "passed", "left", "kept", "certified"))
        yield f"{stage} {' '.join(map(str, reports))}"


if __name__ == "__main__":
    make(__doc__, table, told)
