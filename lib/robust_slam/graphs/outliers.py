"""Wrong loop closures, put into a graph on purpose, with a record of which they are.

Every function returns the graph with the lies and a mask ``(m,)`` of them over its edges;
odometry is never touched. A lie claims the noise and the information of an honest closure,
so that nothing in its numbers gives it away, and it is really wrong: before its noise it
puts pose j at least ``apart`` (m) from where ``poses`` have it. ``poses`` ``(n, 3)`` in
SE(2) or ``(n, 3, 4)`` in SE(3) are by default dead reckoning; give the truth where it is
known.

From harmless to hard: single random lies rarely agree with anything. A group repeats one
lie along the way, and local lies are short, so that they look like honest closures of slow
driving. Aliased closures agree with each other and with the odometry: only what lies
outside the group speaks against them.

Source: the policies random, local, random group and local group of Sünderhauf and Protzel
2012; spoiled closures as in Antonante et al. 2022; the aliased group is derived here.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from robust_slam._arrays import Array, Indices, Mask
from robust_slam.graphs.group import Group, group_of
from robust_slam.graphs.odometry import dead_reckoning
from robust_slam.graphs.pose_graph import PoseGraph, check_poses, with_closures

_ROUNDS = 50
"""Batches of pairs to draw before giving up."""

_POOL = 10
"""How many times more stretches are drawn for the aliased group, to choose the most alike."""

_Draw = Callable[[int], Indices]
"""Propose about so many pairs (i, j), i < j, as ``(k, 2)``."""

_Claim = Callable[[Indices], Array]
"""Return what stretches of pairs ``(k, size, 2)`` say, a pose each."""


def add_random_closures(
    graph: PoseGraph,
    count: int,
    rng: np.random.Generator,
    *,
    poses: ArrayLike | None = None,
    apart: float | None = None,
) -> tuple[PoseGraph, Mask]:
    """Return ``graph`` with ``count`` closures that are lies, and a mask ``(m,)`` of the lies.

    Each says that two poses which are at least ``apart`` (m) from each other are the same
    place, up to the noise of an honest closure, and claims the information of an honest
    closure drawn from the graph (of an odometry edge if it has none). ``poses`` ``(n, 3)``
    or ``(n, 3, 4)`` tell how far apart poses are. ``apart`` is by default half of the
    longest side of their map. No pair is drawn twice.

    Raises:
        ValueError: ``count`` is negative, or fewer pairs are that far apart.

    Source: the random policy of Sünderhauf and Protzel 2012.
    """
    known = _known(graph, poses)
    least = _half_side(graph.group, known) if apart is None else float(apart)
    edges, claim = _find("count", count, 1, _anywhere(graph.n, rng), _same(graph), known, least)
    return _with_lies(graph, edges, claim, rng)


def add_local_closures(
    graph: PoseGraph,
    count: int,
    rng: np.random.Generator,
    *,
    reach: int = 20,
    poses: ArrayLike | None = None,
    apart: float | None = None,
) -> tuple[PoseGraph, Mask]:
    """Return ``graph`` with ``count`` lies between poses 2 to ``reach`` steps apart, and a mask.

    The mask is ``(m,)``; ``poses`` are ``(n, 3)`` or ``(n, 3, 4)``. Each lie says that two
    poses which are at least ``apart`` (m) from each other are the same place; ``apart`` is
    by default the median distance between neighbours on the way.

    Raises:
        ValueError: ``count`` is negative, ``reach`` is below 2, or fewer pairs are that far
            apart.

    Source: the local policy of Sünderhauf and Protzel 2012.
    """
    known = _known(graph, poses)
    least = _median_step(graph.group, known) if apart is None else float(apart)
    draw = _nearby(graph.n, reach, rng)
    edges, claim = _find("count", count, 1, draw, _same(graph), known, least)
    return _with_lies(graph, edges, claim, rng)


def add_grouped_closures(
    graph: PoseGraph,
    groups: int,
    rng: np.random.Generator,
    *,
    size: int = 10,
    reach: int | None = None,
    poses: ArrayLike | None = None,
    apart: float | None = None,
) -> tuple[PoseGraph, Mask]:
    """Return ``graph`` with ``groups`` times ``size`` lies, and a mask ``(m,)`` of the lies.

    A group starts with a pair (i, j) and goes on with (i + 1, j + 1), (i + 2, j + 2), …:
    each says that its two poses are the same place, at least ``apart`` (m) from each other
    by ``poses`` ``(n, 3)`` or ``(n, 3, 4)``. The first pair is drawn as by
    ``add_random_closures``, or, if ``reach`` is given, as by ``add_local_closures``; the
    default of ``apart`` follows. A group is consistent in itself only where both stretches
    have the same shape; see ``add_aliased_closures``. No pair is drawn twice.

    Raises:
        ValueError: ``groups`` is negative, ``size`` is below 1, ``reach`` is below 2, or
            fewer groups are that far apart.

    Source: the random group and local group policies of Sünderhauf and Protzel 2012.
    """
    known = _known(graph, poses)
    default = _half_side if reach is None else _median_step
    least = default(graph.group, known) if apart is None else float(apart)
    draw = _anywhere(graph.n, rng) if reach is None else _nearby(graph.n, reach, rng)
    edges, claim = _find("groups", groups, size, draw, _same(graph), known, least)
    return _with_lies(graph, edges, claim, rng)


def add_aliased_closures(
    graph: PoseGraph,
    groups: int,
    rng: np.random.Generator,
    *,
    size: int = 10,
    poses: ArrayLike | None = None,
    apart: float | None = None,
) -> tuple[PoseGraph, Mask]:
    """Return ``graph`` with ``groups`` mistaken places of ``size`` lies each, and a mask.

    The mask is ``(m,)``. The robot takes the stretch i, i + 1, … for j, j + 1, …: the
    closures (i + k, j + k) all follow from one rigid displacement G of the world, with
    which pose j falls on pose i. Before its noise each says z = x_i⁻¹ ∘ G ∘ x_j of its own
    i and j. So the cycle of two of them and the odometry between closes, up to noise, and
    pairwise consistency accepts the group. G moves each pose j by at least ``apart`` (m) of
    ``poses`` ``(n, 3)`` or ``(n, 3, 4)``, by default half of the longest side of their map.
    Of the stretches that are drawn those are taken whose shapes are most alike, since
    there a robot is mistaken; none overlaps itself. No pair is drawn twice.

    Raises:
        ValueError: ``groups`` is negative, ``size`` is below 1, or fewer stretches are that
            far apart.

    Source: derived here; perceptual aliasing in general, Lajoie et al. 2019.
    """
    known = _known(graph, poses)
    least = _half_side(graph.group, known) if apart is None else float(apart)
    group = graph.group

    def displaced(edges: Indices) -> Array:
        i, j = known[edges[..., 0]], known[edges[..., 1]]
        move = group.compose(i[:, :1], group.inverse(j[:, :1]))
        return group.between(i, group.compose(move, j))

    draw = _most_alike(_anywhere(graph.n, rng), displaced, size, group, graph.n)
    edges, claim = _find("groups", groups, size, draw, displaced, known, least)
    return _with_lies(graph, edges, claim, rng)


def spoil_closures(
    graph: PoseGraph,
    fraction: float,
    rng: np.random.Generator,
    *,
    poses: ArrayLike | None = None,
    apart: float | None = None,
) -> tuple[PoseGraph, Mask]:
    """Return ``graph`` with a ``fraction`` of its closures made wrong in place, and a mask.

    The mask is ``(m,)``. The number of lies is rounded; which they are is drawn. A spoiled
    closure (i, j) measures another pose of the map instead of pose j, drawn from those at
    least ``apart`` (m) from j by ``poses`` ``(n, 3)`` or ``(n, 3, 4)``, by default half of
    the longest side of their map. Its edge and its information stay, and its noise is
    drawn anew.

    Raises:
        ValueError: ``fraction`` is not from 0 to 1, or no pose is that far from some j.

    Source: the experiments of Antonante et al. 2022 with spoiled loop closures.
    """
    if not 0.0 <= fraction <= 1.0:
        raise ValueError(f"fraction is {fraction}; give a number from 0 to 1")
    known, group = _known(graph, poses), graph.group
    least = _half_side(group, known) if apart is None else float(apart)
    closures = np.flatnonzero(~graph.is_odometry)
    count = round(fraction * closures.size)
    chosen = np.sort(rng.choice(closures, size=count, replace=False))
    i, j = graph.edges[chosen].T
    mistaken = _elsewhere(group.translation(known), j, least, rng)
    claim = group.between(known[i], known[mistaken])
    measurement = graph.measurement.copy()
    measurement[chosen] = _noisy(group, claim, graph.information[chosen], rng)
    is_lie = np.isin(np.arange(len(graph.edges)), chosen)
    spoiled = PoseGraph(graph.n, graph.edges, measurement, graph.information, graph.is_odometry)
    return spoiled, is_lie


def _known(graph: PoseGraph, poses: ArrayLike | None) -> Array:
    return dead_reckoning(graph) if poses is None else check_poses("poses", poses, graph)


def _half_side(group: Group, known: Array) -> float:
    return 0.5 * float(np.ptp(group.translation(known), axis=0).max())


def _median_step(group: Group, known: Array) -> float:
    steps = np.diff(group.translation(known), axis=0)
    return float(np.median(np.linalg.norm(steps, axis=1)))


def _anywhere(n: int, rng: np.random.Generator) -> _Draw:
    """Draw both poses from the whole way."""
    return lambda count: np.sort(rng.integers(n, size=(count, 2)), axis=1)


def _nearby(n: int, reach: int, rng: np.random.Generator) -> _Draw:
    """Draw pairs 2 to ``reach`` steps apart."""
    if reach < 2:
        raise ValueError(f"reach is {reach}; give at least 2 steps")

    def draw(count: int) -> Indices:
        first = rng.integers(n, size=count)
        return np.stack([first, first + rng.integers(2, reach + 1, size=count)], axis=1)

    return draw


def _most_alike(draw: _Draw, claim: _Claim, size: int, group: Group, n: int) -> _Draw:
    """Put those pairs first whose stretches claim the shortest way between their poses.

    A stretch that overlaps itself is left out: every street looks like itself, a little on.
    """

    def sorted_draw(count: int) -> Indices:
        pairs = draw(_POOL * count)
        edges = _stretches(pairs[pairs[:, 1] >= pairs[:, 0] + size], size, n)
        longest = np.linalg.norm(group.translation(claim(edges)), axis=2).max(axis=1)
        return np.asarray(edges[np.argsort(longest, kind="stable"), 0])

    return sorted_draw


def _same(graph: PoseGraph) -> _Claim:
    """Every pair is said to be one place."""
    group = graph.group
    return lambda edges: np.broadcast_to(group.identity(), (*edges.shape[:2], *group.POSE_SHAPE))


def _stretches(pairs: Indices, size: int, n: int) -> Indices:
    """Continue each pair, (i + k, j + k): those ``(k, size, 2)`` that stay on the way."""
    edges = pairs[:, None, :] + np.arange(size)[:, None]
    fits = (edges[:, -1, 1] < n) & (pairs[:, 1] > pairs[:, 0] + 1)
    return np.asarray(edges[fits])


def _find(
    name: str, count: int, size: int, draw: _Draw, claim: _Claim, known: Array, least: float
) -> tuple[Indices, Array]:
    """Find ``count`` wrong stretches of ``size`` pairs; return all pairs and what they say."""
    if count < 0:
        raise ValueError(f"{name} is {count}; give at least 0")
    if size < 1:
        raise ValueError(f"size is {size}; give at least 1 closure")
    found: list[Indices] = []
    taken: set[tuple[int, int]] = set()
    for _ in range(_ROUNDS):
        edges = _stretches(draw(4 * count + 100), size, len(known))
        for stretch in edges[_errors(known, edges, claim(edges)).min(axis=1) >= least]:
            pairs = {(int(i), int(j)) for i, j in stretch}
            if taken.isdisjoint(pairs) and len(found) < count:
                taken |= pairs
                found.append(stretch)
        if len(found) == count:
            chosen = np.array(found, dtype=np.intp).reshape(-1, size, 2)
            said = claim(chosen)
            return chosen.reshape(-1, 2), said.reshape(-1, *said.shape[2:])
    kind = "pairs" if size == 1 else f"groups of {size}"
    raise ValueError(
        f"{name} is {count}, and only {len(found)} {kind} at least {least:.3g} m apart were "
        "found; ask for fewer or lower apart"
    )


def _errors(known: Array, edges: Indices, claim: Array) -> Array:
    """Return how far (m) each claim puts pose j from where it is, ``(k, size)``."""
    group = group_of(known)
    put = group.compose(known[edges[..., 0]], claim)
    gap = group.translation(put) - group.translation(known[edges[..., 1]])
    return np.asarray(np.linalg.norm(gap, axis=-1))


def _elsewhere(place: Array, j: Indices, least: float, rng: np.random.Generator) -> Indices:
    """Draw for each pose of ``j`` another that stands at least ``least`` from it."""
    drawn = np.empty(len(j), dtype=np.intp)
    for k, pose in enumerate(j):
        far = np.flatnonzero(np.linalg.norm(place - place[pose], axis=1) >= least)
        if far.size == 0:
            raise ValueError(
                f"apart is {least:.3g}, and no pose is that far from pose {pose}; lower it"
            )
        drawn[k] = rng.choice(far)
    return drawn


def _with_lies(
    graph: PoseGraph, edges: Indices, claim: Array, rng: np.random.Generator
) -> tuple[PoseGraph, Mask]:
    """Add closures that say ``claim`` up to the noise of honest ones, and mark them."""
    model = np.flatnonzero(~graph.is_odometry)
    model = np.arange(len(graph.edges)) if model.size == 0 else model
    information = graph.information[rng.choice(model, size=len(edges))]
    measurement = _noisy(graph.group, claim, information, rng)
    longer = with_closures(graph, edges, measurement, information)
    return longer, np.arange(len(longer.edges)) >= len(graph.edges)


def _noisy(group: Group, claim: Array, information: Array, rng: np.random.Generator) -> Array:
    """Return claim ∘ Exp(η), each η drawn with the inverse information as covariance."""
    white = rng.normal(size=information.shape[:2])
    root = np.linalg.cholesky(information)
    drawn = np.linalg.solve(np.swapaxes(root, 1, 2), white[..., None])[..., 0]
    return group.compose(claim, group.exp(drawn))
