"""What each failing stage of chapter 9 does to the map: the table of its live picture.

The chapter's own cells make the town, the faults and the maps.

    python -m benchmarks.machine
    python -m benchmarks.machine --out lib/robust_slam_course/pictures/machine.json
"""

from __future__ import annotations

import argparse
import json
import os
from pathlib import Path
from typing import Any, NamedTuple

# It is read when numpy is first imported.
os.environ["OPENBLAS_NUM_THREADS"] = "1"

import numpy as np
from numpy.typing import NDArray
from robust_slam._arrays import Array
from robust_slam.graphs import PoseGraph, ate
from robust_slam.graphs.metrics import align
from robust_slam_course.plots.stages import STAGES

Mask = NDArray[np.bool_]

CHAPTER = Path(__file__).parents[1] / "chapters" / "09-frontiers.ipynb"
CELLS = ("imports", "world", "faults", "outcomes")


class Outcome(NamedTuple):
    """What the chapter's function `outcome` returns."""

    graph: PoseGraph
    is_outlier: Mask
    poses: Array
    masks: tuple[Mask | None, Mask | None, Mask]
    """The edges (m,) that PCM passes, GNC leaves and the map uses."""
    verdict: str


def chapter() -> dict[str, Any]:
    """Return the names that the chapter's cells define."""
    notebook = json.loads(CHAPTER.read_text(encoding="utf-8"))
    cells = {cell["id"]: "".join(cell["source"]) for cell in notebook["cells"]}
    names: dict[str, Any] = {}
    for name in CELLS:
        exec(cells[name].replace("use_style()\n", ""), names)
    return names


def table(names: dict[str, Any]) -> dict[str, Any]:
    """Return the true poses and the outcome of each stage, from the names of ``chapter``."""
    truth = names["town"]()[2]
    outcomes = {
        stage: _of_stage(truth, Outcome(*names["outcome"](stage)))
        for stage in ("nothing", *STAGES)
    }
    return {"truth": _flat(truth), "outcomes": outcomes}


def _of_stage(truth: Array, outcome: Outcome) -> dict[str, Any]:
    graph, is_outlier, poses, masks, verdict = outcome
    loops = ~graph.is_odometry
    passed, left, kept = (_counts(loops, is_outlier, mask) for mask in masks)
    kinds = 2 * is_outlier.astype(int) + ~masks[2]
    closures = np.column_stack([graph.edges, kinds])[loops]
    return {
        "told": _counts(loops, is_outlier, np.ones_like(loops)),
        "passed": passed,
        "left": left,
        "kept": kept,
        "certified": verdict == "certified",
        "off": round(float(ate(poses, truth)), 4),
        "poses": _flat(align(poses, truth)),
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


def main() -> None:
    """Compute the table, and write it if asked to."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--out", type=Path, help="write the table to this file")
    out = parser.parse_args().out
    made = table(chapter())
    for stage, outcome in made["outcomes"].items():
        print(stage, *(outcome[key] for key in ("off", "passed", "left", "kept", "certified")))
    if out:
        out.write_text(json.dumps(made, separators=(",", ":")) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
