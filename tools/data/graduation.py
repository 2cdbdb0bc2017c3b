"""Where a robust descent starts, and whether it graduates: which of the two saves a map.

Each world is a town of 100 poses and 20 correct closures with outliers among them. Two axes make
it harder: the heading noise of its odometry, and by how much every edge claims another σ than its
true one. From dead reckoning and from least squares, TLS and Geman–McClure are minimised by IRLS
and by GNC: the functions of ``methods``. A map is good if it is at most 0.1 m (ATE) from the
least-squares map of the correct edges.

    python -m tools.data.graduation
    python -m tools.data.graduation --out lib/course/robust_slam_course/pictures/graduation.csv
    python -m tools.data.graduation --maps lib/course/robust_slam_course/pictures/graduation.json

The last writes the maps of half the closures consistent outliers and the true σ, as a picture
draws them: a town is told by the steps between every second pose, each a letter for x and one for
y, and in the place of a good map, which looks like its town, there are no letters.
"""

import argparse
import csv
import dataclasses
import json
import sys
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from robust_slam._arrays import Array
from robust_slam.errors import NotConverged, Underdetermined
from robust_slam.estimators import chi_square_threshold
from robust_slam.graphs import Noise, PoseGraph, add_random_closures, ate, manhattan
from robust_slam.graphs.metrics import align
from robust_slam.graphs.outliers import add_aliased_closures
from robust_slam.problems import PoseGraphProblem
from robust_slam_course.pictures.graphs import map_steps
from tqdm import tqdm

from benchmarks import methods

KINDS = ("random", "consistent")
PERCENTS = (50, 75)
NOISES = (0.01, 0.02, 0.03, 0.05, 0.07, 0.1)
CLAIMS = (0.25, 0.5, 1.0, 2.0, 4.0, 8.0)
SEEDS = range(10)
CLOSURES = 20
GROUP = 5
GOOD = 0.1
"""The largest distance (m) of a good map from that of the correct edges."""
UNIT = 0.5
"""How far (m) a drawn pose may move by one letter."""
C = chi_square_threshold(methods.PROBABILITY, 3)
Place = tuple[int, str, float, float]
"""A row of the table: percent and kind of outliers, noise and claim."""


class World(NamedTuple):
    """What names a world: percent of outliers, their kind, heading noise (rad) a step, seed."""

    percent: int
    kind: str
    noise: float
    seed: int


METHODS: dict[str, methods.Descent] = {
    "IRLS-TLS": methods.irls_tls,
    "GNC-TLS": methods.gnc_tls,
    "IRLS-GM": methods.irls_gm,
    "GNC-GM": methods.gnc_gm,
}
STARTS = ("odometry", "least squares")
COLUMNS = tuple(f"{method} from {start}" for start, method in product(STARTS, METHODS))


def make(world: World) -> tuple[PoseGraph, Array]:
    """Return the graph with outliers, and the least-squares poses of its correct edges."""
    of_graph, of_outliers = np.random.default_rng(world.seed).spawn(2)
    noise = Noise(odometry=(0.05, world.noise))
    correct, truth = manhattan(100, of_graph, side=8, turn=0.25, closures=CLOSURES, noise=noise)
    reference = PoseGraphProblem(correct).initial()
    count = round(CLOSURES * world.percent / (100 - world.percent))
    if world.kind == "random":
        return add_random_closures(correct, count, of_outliers, poses=truth)[0], reference
    found = add_aliased_closures(correct, count // GROUP, of_outliers, size=GROUP, poses=truth)
    return found[0], reference


def good_maps(graph: PoseGraph, reference: Array, claim: float) -> list[bool]:
    """Tell of each start and method, in the order of COLUMNS, whether its map is good.

    Every edge claims ``claim`` times its true σ.
    """
    claimed = dataclasses.replace(graph, information=graph.information / claim**2)
    return [found is not None and ate(found, reference) <= GOOD for found in solved(claimed)]


def solved(graph: PoseGraph) -> list[Array | None]:
    """Return the map of each start and method, in the order of COLUMNS; None for a failure."""
    problem = PoseGraphProblem(graph, steps=methods.STEPS)
    starts = [methods.STARTS[name](problem) for name in STARTS]
    return [_map_of(method, problem, x0) for x0, method in product(starts, METHODS.values())]


def _map_of(method: methods.Descent, problem: PoseGraphProblem, x0: Array) -> Array | None:
    try:
        return method(problem, C, x0)
    except (NotConverged, Underdetermined):
        return None


def drawn() -> dict[str, Any]:
    """Return the towns and, by column, noise and seed, the maps that are lost."""
    lost: list[list[list[str]]] = [[[] for _ in NOISES] for _ in COLUMNS]
    towns = [letters(make(World(50, "consistent", NOISES[0], seed))[1]) for seed in SEEDS]
    for (n, noise), seed in product(enumerate(NOISES), SEEDS):
        graph, reference = make(World(50, "consistent", noise, seed))
        for k, found in enumerate(solved(graph)):
            lost[k][n].append(lost_letters(found, reference))
    return {"unit": UNIT, "towns": towns, "lost": lost}


def lost_letters(found: Array | None, reference: Array) -> str:
    """Return the letters of a map, none where it is good."""
    if found is None:
        return letters(0.0 * reference)
    return "" if ate(found, reference) <= GOOD else letters(align(found, reference))


def letters(poses: Array) -> str:
    """Return the steps between every second of ``poses``, "N" for none, in ``UNIT``."""
    steps = np.clip(map_steps(poses[::2], UNIT), -35, 40)
    return "".join(chr(ord("N") + step) for step in steps)


def count_good() -> dict[Place, np.ndarray]:
    """Return the number of good maps ``(8,)``, in the order of COLUMNS, for each place."""
    counts: dict[Place, np.ndarray] = {}
    worlds = [World(*each) for each in product(PERCENTS, KINDS, NOISES, SEEDS)]
    for world in tqdm(worlds, disable=not sys.stderr.isatty()):
        graph, reference = make(world)
        for claim in CLAIMS:
            good = np.array(good_maps(graph, reference, claim), dtype=int)
            place = (*world[:3], claim)
            counts[place] = counts.get(place, 0) + good
    return counts


def main() -> int:
    """Write the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, help="the CSV file; by default it is printed")
    parser.add_argument("--maps", type=Path, help="write the maps of the picture to this file")
    chosen = parser.parse_args()
    if chosen.maps:
        chosen.maps.write_text(json.dumps(drawn(), separators=(",", ":")) + "\n", "utf-8")
        return 0
    out = chosen.out
    counts = count_good()
    with out.open("w", encoding="utf-8") if out else sys.stdout as file:
        file.write(
            f"# good maps of {len(SEEDS)}: at most {GOOD} m from the map of the correct edges\n"
        )
        file.write("# python -m tools.data.graduation --out <this file>\n")
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["percent", "kind", "noise", "claim", *COLUMNS])
        writer.writerows([*place, *counts[place]] for place in sorted(counts))
    return 0


if __name__ == "__main__":
    sys.exit(main())
