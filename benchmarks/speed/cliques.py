"""A largest clique, against networkx.

The graph is the consistency graph of PCM: two hundred closures of a walk through a town, half
of them outliers, joined where they agree. Both searches are exact.
"""

from __future__ import annotations

import networkx
import numpy as np
from robust_slam._arrays import Mask
from robust_slam.consistency import max_clique, pcm
from robust_slam.estimators import chi_square_threshold
from robust_slam.graphs import add_random_closures, manhattan

from benchmarks.speed.clock import Side, in_turns
from benchmarks.speed.figure import Figure, shown

CLOSURES = 200
POSES = 1000
SEED = 0


def measure() -> Figure:
    """Return the figure.

    Raises:
        RuntimeError: the sizes do not agree, or ours is not proven.
    """
    adjacency = consistency()
    joined = networkx.from_numpy_array(adjacency)
    ours, other = in_turns(
        [
            Side("ours", lambda: max_clique(adjacency), lambda c: (c.members.size, c.proven)),
            Side(
                "networkx",
                lambda: networkx.max_weight_clique(joined, weight=None),
                lambda found: (found[1], True),
            ),
        ]
    )
    if ours.answer != other.answer or not ours.answer[1]:
        raise RuntimeError(f"our size and proof are {ours.answer}, networkx's {other.answer}")
    remark = f"networkx {shown(other)}, ours {shown(ours)}; {ours.answer[0]} closures agree"
    return Figure(other, {"numpy": ours}, remark)


def consistency() -> Mask:
    """Return which closures agree, ``(200, 200)``, none with itself."""
    rng = np.random.default_rng(SEED)
    graph, truth = manhattan(POSES, rng, closures=CLOSURES // 2)
    spoiled, _ = add_random_closures(graph, CLOSURES // 2, rng, poses=truth)
    found = pcm(spoiled, chi_square_threshold(0.99, spoiled.group.DOF))
    adjacency = found.adjacency.copy()
    np.fill_diagonal(adjacency, False)
    return adjacency
