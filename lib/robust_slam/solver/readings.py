"""Whether a graph fits better when its edges are read in another way.

Programs disagree about the direction of an edge and the sense of a rotation, and a graph that is
read in the wrong way is still a graph: its closures merely contradict each other. So each other
way is tried, and named if it keeps closures that the given one rejects.

Source: derived here.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from robust_slam._arrays import Array, Indices, Mask
from robust_slam.graphs.pose_graph import PoseGraph, residual_norms
from robust_slam.progress import Progress, stages
from robust_slam.solver import solve
from robust_slam.solver.answer import Answer

_DOUBTFUL = 0.02
"""Where a smaller share of the closures is rejected, nothing is gained by another reading."""
_BETTER = 0.5
"""Another reading is named if it rejects at most this share of what the given one rejects."""


@dataclass(frozen=True, eq=False)
class Reading:
    """Another way to read the edges, in ``words``; the ``graph`` so read, and its ``answer``."""

    words: str
    graph: PoseGraph
    answer: Answer


def better_reading(
    answer: Answer, *, progress: bool | Progress = False, max_seconds: float = 60.0
) -> Reading | None:
    """Return the way to read the answer's graph that rejects the fewest closures, or None.

    Tried are edges from j to i in place of i to j, all of them, the odometry or the closures, and
    rotations of the other sense, as of a left-handed frame. None means that no other reading
    rejects at most half as many closures, or that the given one rejects hardly any. Each try
    takes a quick ``solve`` of at most ``max_seconds`` of CPU time.

    >>> from robust_slam import graphs, solve
    >>> graph, _ = graphs.manhattan(60, np.random.default_rng(0), closures=30)
    >>> swapped = replace(graph, measurement=graph.inverse_measurement)
    >>> better_reading(solve(swapped)).words
    'with i and j swapped in all edges'
    """
    count = int(np.sum(~answer.graph.is_odometry))
    rejected = _rejected(answer)
    if rejected <= _DOUBTFUL * count:
        return None
    found: list[Reading] = []
    with stages(progress) as tell:
        for words, read in _READINGS.items():
            tell(f"the graph is read {words}")
            graph = replace(answer.graph, measurement=read(answer.graph))
            other = solve(graph, quick=True, max_seconds=max_seconds)
            found.append(Reading(words, graph, other))
    # Readings that reject equally few differ in the noise that they leave.
    best = min(found, key=lambda one: (_rejected(one.answer), -one.answer.best.evidence))
    return best if _rejected(best.answer) <= _BETTER * rejected else None


def swapped_closures(answer: Answer) -> Indices:
    """Return the rejected closures ``(k,)``, ascending, that fit the map with i and j swapped.

    They pass the test that the kept ones passed, ``Answer.threshold``.
    """
    graph = answer.precise
    turned = replace(graph, measurement=graph.inverse_measurement)
    fits = residual_norms(turned, answer.poses) <= answer.threshold
    found: Indices = np.flatnonzero(fits & ~answer.kept & ~graph.is_odometry)
    return found


def _rejected(answer: Answer) -> int:
    return int(np.sum(~answer.kept & ~answer.graph.is_odometry))


def _swapped(graph: PoseGraph, chosen: Mask) -> Array:
    rows = chosen.reshape(-1, *[1] * (graph.measurement.ndim - 1))
    return np.where(rows, graph.inverse_measurement, graph.measurement)


def _mirrored(graph: PoseGraph) -> Array:
    turned = np.swapaxes(graph.rotation, -1, -2)
    return graph.group.from_parts(turned, graph.translation)


_READINGS: dict[str, Callable[[PoseGraph], Array]] = {
    "with i and j swapped in all edges": lambda graph: graph.inverse_measurement,
    "with i and j swapped in the loop closures": lambda g: _swapped(g, ~g.is_odometry),
    "with i and j swapped in the odometry": lambda g: _swapped(g, g.is_odometry),
    "with rotations of the other sense, as in a left-handed frame": _mirrored,
}
