"""What the picture of the growing map shows and the page cannot compute: the library's decisions.

python -m tools.data.labs
python -m tools.data.labs --out lib/course/robust_slam_course/pictures/labs.json
"""

from collections.abc import Iterator
from typing import Any

import numpy as np
from robust_slam._arrays import Mask
from robust_slam.graphs import PoseGraph
from robust_slam.incremental.growing_map import GrowingMap
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


def table() -> dict[str, Any]:
    """Return the table by the name that the picture knows."""
    return {"minds": [list(mind(pose)) for pose in labs.ARRIVALS]}


def told(made: dict[str, Any]) -> Iterator[str]:
    """Yield the number of histories."""
    yield f"{len(made['minds'])} histories of kept closures"


if __name__ == "__main__":
    make(__doc__, table, told)
