"""What the library's solvers do with a growing share of outliers: the table of a live picture.

python -m tools.data.arena
python -m tools.data.arena --out lib/course/robust_slam_course/pictures/arena.json
"""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import robust_slam as rs
from robust_slam._arrays import Array
from robust_slam.certificates import Verdict, certify
from robust_slam.consistency import pcm
from robust_slam.estimators import Result, chi_square_threshold, gnc, irls, kernels, switchable
from robust_slam.graphs import PoseGraph, ate
from robust_slam.graphs.metrics import align
from robust_slam.graphs.pose_graph import select
from robust_slam.problems import PoseGraphProblem
from robust_slam_course import labs
from robust_slam_course.pictures.graphs import map_steps

from tools.data import make

_C = chi_square_threshold(0.99, 3)
_UNIT = 0.08  # m, two pixels of the picture
_IN_USE = 0.25  # the weight of a closure whose switch is one half


def _consistent(graph: PoseGraph) -> tuple[Array, Array]:
    """Return the map and the weights ``(m,)`` of GNC over what PCM keeps."""
    kept = pcm(graph, _C).kept
    found = gnc(select(graph, kept), _C)
    weights = np.zeros(kept.size)
    weights[kept] = found.weights
    return found.x, weights


def _whole(graph: PoseGraph) -> tuple[Array, Array]:
    answer = rs.solve(graph)
    return answer.poses, answer.kept.astype(float)


def _end(found: Result[Array]) -> tuple[Array, Array]:
    return found.x, found.weights


SOLVERS: dict[str, Callable[[PoseGraph], tuple[Array, Array]]] = {
    "least squares": lambda graph: (PoseGraphProblem(graph).initial(), np.ones(len(graph.edges))),
    "IRLS, Huber": lambda graph: _end(irls(graph, kernels.huber(1.345))),
    "DCS": lambda graph: _end(irls(graph, kernels.dcs(_C))),
    "switches": lambda graph: _end(switchable(graph, _C**2)),
    "GNC": lambda graph: _end(gnc(graph, _C)),
    "PCM + GNC": _consistent,
    "rs.solve": _whole,
}


def table() -> dict[str, Any]:
    """Return what each solver does with each share of each kind of outliers.

    A run has the number of its map among ``maps``, a 1 for each closure in use and a 0 for others,
    the error (m), and whether the map is certified. A map has x and y of its first pose in
    ``unit`` m, then of each step.
    """
    maps: dict[tuple[int, ...], int] = {}
    runs = {
        f"{kind} {percent}": [_run(solver, kind, percent, maps) for solver in SOLVERS.values()]
        for kind in labs.KINDS
        for percent in labs.PERCENTS
    }
    return {"solvers": list(SOLVERS), "unit": _UNIT, "maps": [*map(list, maps)], "runs": runs}


def _run(
    solver: Callable[[PoseGraph], Any], kind: str, percent: int, maps: dict[tuple[int, ...], int]
) -> list[Any]:
    graph, _, truth = labs.spoiled(kind, percent)
    poses, weights = solver(graph)
    _, proof = certify(graph, poses, weights)
    used = "".join(str(int(w >= _IN_USE)) for w in weights[~graph.is_odometry])
    steps = tuple(map_steps(align(poses, truth), _UNIT))
    number = maps.setdefault(steps, len(maps))
    certified = proof.verdict is Verdict.CERTIFIED
    return [number, used, round(float(ate(poses, truth)), 2), int(certified)]


def told(made: dict[str, Any]) -> Iterator[str]:
    """Yield for each share of outliers the errors, with a star where the map is certified."""
    for name, runs in made["runs"].items():
        errors = (f"{error:5.2f}{'*' * proved:1}" for *_, error, proved in runs)
        yield f"{name:13} {' '.join(errors)}"


if __name__ == "__main__":
    make(__doc__, table, told)
