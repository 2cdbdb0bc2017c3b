"""What the live pictures of the labs show and the page cannot compute: the library's decisions.

python -m tools.data.labs
python -m tools.data.labs --out lib/robust_slam_course/pictures/labs.json
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from robust_slam._arrays import Mask
from robust_slam.certificates import Verdict, certify
from robust_slam.estimators import Result, chi_square_threshold, gnc, irls, kernels
from robust_slam.estimators.result import Step
from robust_slam.graphs import PoseGraph
from robust_slam.incremental.growing_map import GrowingMap
from robust_slam.problems import PoseGraphProblem
from robust_slam_course import labs

from tools.data import make


def mind(arrives: int) -> Iterator[int]:
    """Yield each pose at which other closures are kept than before, and these as bits.

    The bits are in the order of the graph; the outlier arrives at the pose ``arrives``.
    """
    graph, _ = labs.late_town()
    closures = np.flatnonzero(~graph.is_odometry)
    before = 0
    for pose, mask in _grown(graph, arrives):
        bits = int(np.sum(mask[closures] * 2 ** np.arange(closures.size)))
        if bits != before:
            yield from (pose, bits)
        before = bits


def _grown(graph: PoseGraph, arrives: int) -> Iterator[tuple[int, Mask]]:
    """Yield each pose with the edges ``(m,)`` that are kept once all its edges have arrived."""
    order = labs.in_order(graph, arrives)
    growing = GrowingMap(PoseGraph(2, **labs.edge(graph, order[0])), find_noise=False)
    for count, k in enumerate(order[1:], 2):
        pose = len(growing.poses) - 1
        if graph.is_odometry[k] and pose > 1:
            yield pose, _in_graph(order[: count - 1], growing, len(graph.edges))
        growing.add(**labs.edge(graph, k))
    yield len(growing.poses) - 1, _in_graph(order, growing, len(graph.edges))


def _in_graph(order: np.ndarray, growing: GrowingMap, m: int) -> Mask:
    mask = np.zeros(m, dtype=np.bool_)
    mask[order] = growing.kept
    return mask


def proofs() -> dict[str, list[float]]:
    """Return of each step of each run on the ring the share of its cost that is not proved."""
    graph = labs.ring(0)[0]
    return {
        f"{solver} {start}": [_gap(graph, step) for step in _run(graph, solver, x0).history[1:]]
        for start, x0 in labs.starts(graph).items()
        for solver in ("gnc", "switches")
    }


def _run(graph: PoseGraph, solver: str, x0: np.ndarray) -> Result[np.ndarray]:
    problem, c = PoseGraphProblem(graph, tol=1e-9, steps=200), chi_square_threshold(0.99, 3)
    if solver == "gnc":
        return gnc(problem, c, x0=x0, tol=1e-6)
    return irls(problem, kernels.geman_mcclure(c), x0, tol=1e-6)


def _gap(graph: PoseGraph, step: Step[np.ndarray]) -> float:
    _, proof = certify(graph, step.x, step.weights)
    if proof.verdict is Verdict.CERTIFIED:
        return 0.0
    return round(proof.bound / proof.cost, 3)


def tables() -> dict[str, Any]:
    """Return both tables."""
    return {"minds": [list(mind(pose)) for pose in labs.ARRIVALS], "proofs": proofs()}


def told(made: dict[str, Any]) -> Iterator[str]:
    """Yield the number of histories, and the gaps of each run: a dot where there is none."""
    yield f"{len(made['minds'])} histories of kept closures"
    for name, gaps in made["proofs"].items():
        yield f"{name} {''.join('x' if gap else '.' for gap in gaps)}"


if __name__ == "__main__":
    make(__doc__, tables, told)
