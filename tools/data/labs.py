"""What two pictures of the labs show and the page cannot compute: decisions and certificates.

python -m tools.data.labs
python -m tools.data.labs --out lib/course/robust_slam_course/pictures/labs.json
"""

from collections.abc import Iterator
from typing import Any

import numpy as np
from robust_slam._arrays import Mask
from robust_slam.certificates import Verdict, certify
from robust_slam.estimators import chi_square_threshold, gnc, irls, kernels
from robust_slam.graphs import PoseGraph, ate
from robust_slam.graphs.metrics import align
from robust_slam.incremental.growing_map import GrowingMap
from robust_slam.problems import PoseGraphProblem
from robust_slam_course import labs
from robust_slam_course.pictures.graphs import map_steps

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


def certified(solver: str, turns: float) -> dict[str, Any]:
    """Return where a loop ends on the first ring, from headings wound by so many ``turns``.

    The ``signs`` are of the certificate of each step, "." or, if it fails, "x"; ``off`` (m) is the
    distance from the map of the inliers; ``used`` tells of each closure whether it is in use.
    """
    graph, c = labs.ring(0)[0], chi_square_threshold(0.99, 3)
    problem, x0 = PoseGraphProblem(graph, tol=1e-9, steps=200), labs.wound(graph, turns)
    if solver == "gnc":
        found = gnc(problem, c, x0=x0, tol=1e-6)
    else:
        found = irls(problem, kernels.geman_mcclure(c), x0, tol=1e-6)
    proofs = [certify(graph, step.x, step.weights)[1] for step in found.history[1:]]
    best = labs.best_of_ring()
    return {
        "signs": "".join("x" if p.verdict is not Verdict.CERTIFIED else "." for p in proofs),
        "off": round(float(ate(found.x, best)), 2),
        "used": "".join(str(int(w >= 0.25)) for w in found.weights[~graph.is_odometry]),
        "steps": map_steps(align(found.x, best), labs.UNIT),
    }


def table() -> dict[str, Any]:
    """Return the tables by the names that the pictures know."""
    solvers = ("gnc", "switches")
    proofs = {each: [certified(each, turns) for turns in labs.TURNS] for each in solvers}
    return {"minds": [list(mind(pose)) for pose in labs.ARRIVALS], "proofs": proofs}


def told(made: dict[str, Any]) -> Iterator[str]:
    """Yield the numbers of histories and of runs."""
    yield f"{len(made['minds'])} histories of kept closures"
    yield f"{sum(map(len, made['proofs'].values()))} runs with their certificates"


if __name__ == "__main__":
    make(__doc__, table, told)
