"""Whether a graph fits better when its edges are read in another way.

Programs disagree about the direction of an edge and the sense of a rotation, and a graph that is
read in the wrong way is still a graph: its closures merely contradict each other. So each other
way is tried in which more neighbouring closures agree, and named if it keeps closures that the
given one rejects.

Source: Mangelson et al. 2018 for closures that agree in pairs; their use is derived here.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from robust_slam._arrays import Indices, Mask
from robust_slam.consistency.pairwise import pairwise_consistent
from robust_slam.files.doubts import rolled
from robust_slam.graphs.pose_graph import PoseGraph, deviations, residual_norms
from robust_slam.progress import Progress, stages
from robust_slam.solver import solve
from robust_slam.solver.answer import Answer

_DOUBTFUL = 0.02
"""Where a smaller share of the closures is rejected, nothing is gained by another reading."""
_BETTER = 0.5
"""Another reading is named if it rejects at most this share of what the given one rejects."""
_RUNS, _RUN = 10, 20
"""Pairs are taken from so many runs of so many closures along the drive …"""
_REACH = 10
"""… of which so many in a row are neighbours: over longer odometry all pairs agree."""
_TELLING = 0.05
"""The smallest share of pairs that agree in some reading, if they tell it from others."""
_COARSE = 0.3
"""The deviation (rad) of a rotation from which on it may be in degrees."""
_IN_DEGREES = 0.1
"""So many neighbours agree at least when degrees are read as such."""


@dataclass(frozen=True, eq=False)
class Reading:
    """Another way to read the edges, in ``words``; the ``graph`` so read, and its ``answer``."""

    words: str
    graph: PoseGraph
    answer: Answer


def better_reading(
    answer: Answer,
    *,
    others: Mapping[str, PoseGraph] | None = None,
    progress: bool | Progress = False,
    max_seconds: float = 60.0,
) -> Reading | None:
    """Return the way to read the answer's graph that rejects the fewest closures, or None.

    Tried are rotations in degrees, edges from j to i in place of i to j, all of them, the odometry
    or the closures, rotations of the other sense, as of a left-handed frame, quaternions that
    begin with w, and the graphs ``others`` by their words, such as ``other_orders`` of a file.
    None means that no other reading rejects at most half as many closures, or that the given one
    rejects hardly any. Each reading in which at least as many neighbouring closures agree takes a
    ``solve`` of at most ``max_seconds`` of CPU time.

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
        for words, graph in _promising(answer.graph, answer.threshold, others or {}):
            tell(f"the graph is read {words}")
            other = solve(graph, max_seconds=max_seconds)
            found.append(Reading(words, graph, other))
    if not found:
        return None
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


def _promising(
    graph: PoseGraph, threshold: float, others: Mapping[str, PoseGraph]
) -> list[tuple[str, PoseGraph]]:
    """Return the readings, in words and as graphs, in which no fewer neighbours agree."""
    chosen, near = _neighbours(graph)

    def agree(read: PoseGraph, gamma: float) -> int:
        return int(np.sum(pairwise_consistent(read, gamma, chosen) & near))

    if graph.group.DIMENSION == 2 and np.median(deviations(graph)[1]) > _COARSE:
        degrees = _from_degrees(graph)
        if agree(degrees, threshold) > _IN_DEGREES * near.sum():
            return [("with rotations and their information in degrees", degrees)]
    read = {words: change(graph) for words, change in READINGS.items()} | dict(others)
    if graph.group.DIMENSION == 3:
        w_first = replace(graph, measurement=rolled(graph.measurement, -1))
        read["with quaternions that begin with w"] = w_first
    for gamma in (threshold, 10.0 * threshold):
        counts = {words: agree(other, gamma) for words, other in read.items()}
        own = agree(graph, gamma)
        if max(own, *counts.values()) > _TELLING * near.sum():
            break  # else deviations are claimed too small
    return [(words, other) for words, other in read.items() if counts[words] >= own]


def _neighbours(graph: PoseGraph) -> tuple[Mask, Mask]:
    """Return some closures ``(m,)``, and which pairs of them ``(k, k)`` are neighbours."""
    closures = np.flatnonzero(~graph.is_odometry)
    order = closures[np.argsort(graph.edges[closures].min(axis=1), kind="stable")]
    first = np.linspace(0, max(0, order.size - _RUN), _RUNS).astype(np.intp)
    place = np.unique(first[:, None] + np.arange(_RUN))
    chosen = np.zeros(len(graph.edges), dtype=np.bool_)
    chosen[order[place[place < order.size]]] = True
    rank = np.zeros(len(graph.edges), dtype=np.intp)
    rank[order] = np.arange(order.size)
    apart = np.abs(rank[chosen][:, None] - rank[chosen])
    return chosen, (apart > 0) & (apart <= _REACH)


def _swapped(graph: PoseGraph, chosen: Mask) -> PoseGraph:
    rows = chosen.reshape(-1, *[1] * (graph.measurement.ndim - 1))
    measurement = np.where(rows, graph.inverse_measurement, graph.measurement)
    return replace(graph, measurement=measurement)


def _mirrored(graph: PoseGraph) -> PoseGraph:
    turned = np.swapaxes(graph.rotation, -1, -2)
    return replace(graph, measurement=graph.group.from_parts(turned, graph.translation))


def _from_degrees(graph: PoseGraph) -> PoseGraph:
    unit = np.array([1.0, 1.0, np.pi / 180.0])
    information = graph.information / unit[:, None] / unit
    return replace(graph, measurement=graph.measurement * unit, information=information)


READINGS: dict[str, Callable[[PoseGraph], PoseGraph]] = {
    "with i and j swapped in all edges": lambda g: _swapped(g, np.ones_like(g.is_odometry)),
    "with i and j swapped in the loop closures": lambda g: _swapped(g, ~g.is_odometry),
    "with i and j swapped in the odometry": lambda g: _swapped(g, g.is_odometry),
    "with rotations of the other sense, as in a left-handed frame": _mirrored,
}
"""Each undoes itself."""
