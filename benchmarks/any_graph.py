"""`solve` on graphs of every kind: CPU seconds, memory and verdict of each, in its own process.

Run `python -m benchmarks.any_graph [NAME…]`; without names all. The first four are generated:

- `building`: 15,000 poses in one building, badly conditioned, with gaps in the odometry
- `sphere`: 2,200 poses and 8,649 edges, deviation of a rotation 0.3 rad
- `sessions`: 2,000 poses in five sessions that closures alone join
- `large`: 100,000 poses in a town, 30,000 closures

The others are the nine public graphs. `+300` after a name adds as many outliers.
"""

from __future__ import annotations

import resource
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from typing import TypeAlias

import numpy as np
import robust_slam as rs
from robust_slam.graphs import Noise, add_random_closures, manhattan, sphere
from robust_slam.graphs.datasets import NAMES
from robust_slam.graphs.laser import building
from robust_slam.graphs.pose_graph import PoseGraph, select

World: TypeAlias = tuple[PoseGraph, np.ndarray | None]
"""A graph and its true poses, where these are known."""

SEED = 0
HEAD = f"{'graph':<14}{'poses':>8}{'edges':>9}{'made, read':>12}{'solve':>8}{'MB':>7}  result"


def _building() -> World:
    return building(15_000, SEED)


def _sphere() -> World:
    noise = Noise(odometry=(0.1, 0.3), closure=(0.1, 0.3))
    return sphere(2200, SEED, around=50, neighbours=3, noise=noise)


def _sessions() -> World:
    graph, truth = manhattan(2000, np.random.default_rng(SEED), closures=300)
    gaps = np.isin(graph.edges[:, 0], (300, 700, 1100, 1500)) & graph.is_odometry
    return select(graph, ~gaps), truth


def _large() -> World:
    return manhattan(100_000, np.random.default_rng(SEED), closures=30_000)


GENERATED: dict[str, Callable[[], World]] = {
    "building": _building,
    "sphere": _sphere,
    "sessions": _sessions,
    "large": _large,
}


def run(name: str) -> str:
    """Solve one graph and return its line of the table.

    Raises:
        ValueError: there is no graph of this name.
    """
    kind, _, added = name.partition("+")
    if kind not in GENERATED and kind not in NAMES:
        raise ValueError(f"there is no graph {kind!r}; give one of {', '.join(names())}")
    start = time.process_time()
    graph, truth = GENERATED[kind]() if kind in GENERATED else (rs.load(kind), None)
    is_outlier = np.zeros(len(graph.edges), dtype=np.bool_)
    if added:
        # Without truth, dead reckoning tells which closures are wrong.
        graph, is_outlier = add_random_closures(graph, int(added), SEED, poses=truth)
    made = time.process_time() - start
    answer = rs.solve(graph)
    solved = time.process_time() - start - made
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    size = f"{name:<14}{graph.n:>8,}{len(graph.edges):>9,}"
    spent = f"{made:>10.1f} s{solved:>6.1f} s{memory:>7.0f}"
    return f"{size}{spent}  {_outcome(answer, is_outlier)}"


def _outcome(answer: rs.solver.Answer, is_outlier: np.ndarray) -> str:
    """Return the verdict, and how many closures were kept."""
    closures = ~answer.graph.is_odometry
    kept = f"{int(np.sum(answer.kept & closures)):,} of {int(closures.sum()):,} closures kept"
    if is_outlier.any():
        kept += f", {int(np.sum(answer.kept & is_outlier))} of {int(is_outlier.sum())} outliers"
    proof = answer.certificate
    stop = f" ({proof.stop.value})" if proof.stop and proof.verdict.value != "certified" else ""
    gap = f"gap at most {proof.bound:.2g} of {proof.cost:.6g}"
    return f"{answer.verdict}{stop}, {gap}; {kept}"


def names() -> list[str]:
    """Return the names of all graphs, with outliers for some."""
    return [*GENERATED, "building+300", "sphere+600", "sessions+100", *NAMES, "CSAIL+100"]


def main(arguments: Sequence[str]) -> int:
    """Print the table; each graph has a process of its own, so that memory is told apart."""
    if len(arguments) == 2 and arguments[0] == "--one":
        print(run(arguments[1]), flush=True)
        return 0
    print(f"CPU seconds of one thread; generated graphs with seed {SEED}.\n{HEAD}", flush=True)
    failed = 0
    for name in arguments or names():
        command = [sys.executable, "-m", "benchmarks.any_graph", "--one", name]
        failed |= subprocess.run(command, check=False).returncode
    return int(failed != 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
