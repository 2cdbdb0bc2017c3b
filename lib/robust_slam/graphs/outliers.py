"""Outliers: wrong loop closures added to a graph, with a mask of which they are.

Odometry is never changed, and no pair is drawn twice. An outlier has the noise and the information
of an inlier, and its error is large: before the noise it puts pose j at least ``apart`` (m) from
its position in ``poses``, by default those of ``spanning_tree``; give the true ones if you can.

From easy to hard: single random outliers are rarely consistent with other edges. A group repeats
one along the path, and local outliers join poses that are a few steps apart. Aliased closures are
consistent with each other and with the odometry; only edges outside the group contradict them.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from robust_slam._arrays import Array, Indices, Mask
from robust_slam.graphs.odometry import spanning_tree
from robust_slam.graphs.pose_graph import PoseGraph, check_graph, check_poses, with_closures
from robust_slam.groups.group import Group, group_of

_ROUNDS = 50
"""The largest number of batches of pairs to draw."""
_TIE = 1e-9
"""Distances that fall short by this share, as on a circle by rounding, are far enough."""
_POOL = 10
"""Candidates per pair that the aliased group chooses the most similar segments from."""
_Draw = Callable[[int], Indices]
"""Propose about the given number of pairs (i, j), i < j, as ``(k, 2)``."""
_Relation = Callable[[Indices], Array]
"""Return the relative poses that the outliers of segments ``(k, size, 2)`` measure."""


def add_random_closures(
    graph: PoseGraph,
    count: int,
    rng: int | np.random.Generator,
    *,
    poses: ArrayLike | None = None,
    apart: float | None = None,
) -> tuple[PoseGraph, Mask]:
    """Return ``graph`` with ``count`` random outliers, and a mask ``(m,)`` of the outliers.

    Each measures the identity, up to noise, between two poses that are at least ``apart`` (m) from
    each other in ``poses`` ``(n, 3)`` or ``(n, 3, 4)``, by default half of the longest side of the
    map. Its information is that of a closure drawn from the graph, if it has any.

    Raises:
        ValueError: ``count`` is negative, or fewer pairs are that far apart.

    Source: the random policy of Sünderhauf and Protzel 2012.

    >>> from robust_slam.graphs.generate import circle
    >>> graph, is_outlier = add_random_closures(circle(20, 0)[0], 3, 1)
    >>> len(graph.edges), np.flatnonzero(is_outlier).tolist()
    (23, [20, 21, 22])
    """
    return _without_motion(graph, "count", count, rng, 1, None, poses, apart)


def add_local_closures(
    graph: PoseGraph,
    count: int,
    rng: int | np.random.Generator,
    *,
    reach: int = 20,
    poses: ArrayLike | None = None,
    apart: float | None = None,
) -> tuple[PoseGraph, Mask]:
    """Return ``graph`` with ``count`` outliers between poses 2 to ``reach`` steps apart.

    They, the mask ``(m,)`` and the errors are as in ``add_random_closures``, but by default
    ``apart`` is the median distance of consecutive poses; ``reach`` is at least 2.

    Source: the local policy of Sünderhauf and Protzel 2012.
    """
    return _without_motion(graph, "count", count, rng, 1, reach, poses, apart)


def add_grouped_closures(
    graph: PoseGraph,
    groups: int,
    rng: int | np.random.Generator,
    *,
    size: int = 10,
    reach: int | None = None,
    poses: ArrayLike | None = None,
    apart: float | None = None,
) -> tuple[PoseGraph, Mask]:
    """Return ``graph`` with ``groups`` groups of ``size`` outliers, and their mask ``(m,)``.

    A group starts with a pair (i, j), as of ``add_random_closures`` or, if ``reach`` is given, of
    ``add_local_closures``, with their ``poses`` and ``apart``. It continues with (i + 1, j + 1) …
    and is consistent in itself only where both segments of the path have the same shape.

    Source: the random group and local group policies of Sünderhauf and Protzel 2012.
    """
    return _without_motion(graph, "groups", groups, rng, size, reach, poses, apart)


def add_aliased_closures(
    graph: PoseGraph,
    groups: int,
    rng: int | np.random.Generator,
    *,
    size: int = 10,
    poses: ArrayLike | None = None,
    apart: float | None = None,
) -> tuple[PoseGraph, Mask]:
    """Return ``graph`` with ``groups`` groups of ``size`` aliased closures, and their mask.

    The mask is ``(m,)``. The robot mistakes the segment i, i + 1, … for j, j + 1, …: the closures
    (i + k, j + k) all follow from one rigid displacement G of the world, which moves pose j to
    pose i. Before the noise each measures z = x_i⁻¹ ∘ G ∘ x_j, so the cycle of two of them and the
    odometry between them closes, and pairwise consistency accepts the group. G moves each pose j
    by at least ``apart``, as in ``add_random_closures``. The segments of the most similar shapes
    are taken, none with itself.

    Raises:
        ValueError: ``groups`` is negative, ``size`` is below 1, or fewer segments are so far.

    Source: derived here; perceptual aliasing in general, Lajoie et al. 2019.
    """
    rng, group = np.random.default_rng(rng), check_graph(graph).group
    (known, least), anywhere = _known(graph, poses, apart), _pairs(graph.n, None, rng)

    def displaced(edges: Indices) -> Array:
        i, j = known[edges[..., 0]], known[edges[..., 1]]
        displacement = group.compose(i[:, :1], group.inverse(j[:, :1]))
        return group.between(i, group.compose(displacement, j))

    def most_similar(count: int) -> Indices:
        # A street is similar to itself, shifted by some steps, so no segment overlaps its own.
        pairs = anywhere(_POOL * count)
        edges = _segments(pairs[pairs[:, 1] >= pairs[:, 0] + size], size, graph.n)
        longest = np.linalg.norm(group.translation(displaced(edges)), axis=2).max(axis=1)
        return np.asarray(edges[np.argsort(longest, kind="stable"), 0])

    found = _find("groups", groups, size, most_similar, displaced, known, least)
    return _with_outliers(graph, *found, rng)


def spoil_closures(
    graph: PoseGraph,
    fraction: float,
    rng: int | np.random.Generator,
    *,
    poses: ArrayLike | None = None,
    apart: float | None = None,
) -> tuple[PoseGraph, Mask]:
    """Return ``graph`` with a ``fraction`` of its closures replaced by outliers, and a mask.

    The mask is ``(m,)``, and the number is rounded. A replaced closure (i, j) measures another
    pose of the map instead of pose j, drawn from those at least ``apart`` from j, as in
    ``add_random_closures``. Its ends and its information stay, and its noise is drawn again.

    Raises:
        ValueError: ``fraction`` is not from 0 to 1, or no pose is that far from some j.

    Source: the experiments of Antonante et al. 2022 with spoiled loop closures.
    """
    rng = np.random.default_rng(rng)
    if not 0.0 <= fraction <= 1.0:
        raise ValueError(f"fraction is {fraction}; give a number from 0 to 1")
    (known, least), group = _known(graph, poses, apart), graph.group
    closures = np.flatnonzero(~graph.is_odometry)
    count = round(fraction * closures.size)
    chosen = np.sort(rng.choice(closures, size=count, replace=False))
    i, j = graph.edges[chosen].T
    mistaken = _elsewhere(group.translation(known), j, least, rng)
    relative = group.between(known[i], known[mistaken])
    measurement = graph.measurement.copy()
    measurement[chosen] = _noisy(group, relative, graph.information[chosen], rng)
    is_outlier = np.isin(np.arange(len(graph.edges)), chosen)
    return replace(graph, measurement=measurement), is_outlier


def _without_motion(
    graph: PoseGraph,
    name: str,
    count: int,
    rng: int | np.random.Generator,
    size: int,
    reach: int | None,
    poses: ArrayLike | None,
    apart: float | None,
) -> tuple[PoseGraph, Mask]:
    """Add ``count`` groups of ``size`` outliers that all measure the identity."""
    rng = np.random.default_rng(rng)
    (known, least), group = _known(graph, poses, apart, reach is not None), graph.group

    def identity(edges: Indices) -> Array:
        return np.broadcast_to(group.identity(), (*edges.shape[:2], *group.POSE_SHAPE))

    draw = _pairs(graph.n, reach, rng)
    found = _find(name, count, size, draw, identity, known, least)
    return _with_outliers(graph, *found, rng)


def _known(
    graph: PoseGraph, poses: ArrayLike | None, apart: float | None, nearby: bool = False
) -> tuple[Array, float]:
    """Return the poses, and how far (m) from them an outlier is at least."""
    known = spanning_tree(graph) if poses is None else check_poses("poses", poses, graph)
    place = graph.group.translation(known)
    if apart is not None:
        return known, float(apart)
    if nearby:
        return known, float(np.median(np.linalg.norm(np.diff(place, axis=0), axis=1)))
    return known, 0.5 * float(np.ptp(place, axis=0).max())


def _pairs(n: int, reach: int | None, rng: np.random.Generator) -> _Draw:
    """Draw pairs from the whole path, or 2 to ``reach`` steps apart."""
    if reach is None:
        return lambda count: np.sort(rng.integers(n, size=(count, 2)), axis=1)
    if reach < 2:
        raise ValueError(f"reach is {reach}; give at least 2 steps")

    def draw(count: int) -> Indices:
        first = rng.integers(n, size=count)
        return np.stack([first, first + rng.integers(2, reach + 1, size=count)], axis=1)

    return draw


def _segments(pairs: Indices, size: int, n: int) -> Indices:
    """Continue each pair as (i + k, j + k); return the segments ``(k, size, 2)`` that fit."""
    edges = pairs[:, None, :] + np.arange(size)[:, None]
    fits = (edges[:, -1, 1] < n) & (pairs[:, 1] > pairs[:, 0] + 1)
    return np.asarray(edges[fits])


def _find(
    name: str, count: int, size: int, draw: _Draw, relation: _Relation, known: Array, least: float
) -> tuple[Indices, Array]:
    """Find ``count`` segments of ``size`` wrong pairs; return the pairs and their measurements."""
    if count < 0:
        raise ValueError(f"{name} is {count}; give at least 0")
    if size < 1:
        raise ValueError(f"size is {size}; give at least 1 closure")
    kind = "pairs" if size == 1 else f"groups of {size}"
    most = (len(known) - 1) * (len(known) - 2) // 2 // size
    if count > most:
        there = f"{len(known)} poses have at most {most} {kind}"
        raise ValueError(f"{name} is {count}, and {there}; ask for fewer")
    found, taken, group = list[Indices](), set[tuple[int, int]](), group_of(known)
    for _ in range(_ROUNDS):
        edges = _segments(draw(4 * count + 100), size, len(known))
        # How far (m) each measurement displaces pose j.
        measured = group.compose(known[edges[..., 0]], relation(edges))
        off = group.translation(measured) - group.translation(known[edges[..., 1]])
        far = np.linalg.norm(off, axis=-1).min(axis=1) >= (1.0 - _TIE) * least
        for segment in edges[far]:
            pairs = {(int(i), int(j)) for i, j in segment}
            if taken.isdisjoint(pairs) and len(found) < count:
                taken |= pairs
                found.append(segment)
        if len(found) == count:
            chosen = np.array(found, dtype=np.intp).reshape(-1, size, 2)
            return chosen.reshape(-1, 2), relation(chosen).reshape(-1, *group.POSE_SHAPE)
    words = f"at least {least:.3g} m apart were found; ask for fewer or lower apart"
    raise ValueError(f"{name} is {count}, and only {len(found)} {kind} {words}")


def _elsewhere(positions: Array, j: Indices, least: float, rng: np.random.Generator) -> Indices:
    """Draw for each pose of ``j`` another pose at a distance of at least ``least``."""
    drawn = []
    for pose in j:
        distances = np.linalg.norm(positions - positions[pose], axis=1)
        far = np.flatnonzero(distances >= (1.0 - _TIE) * least)
        if far.size == 0:
            words = f"apart is {least:.3g}, and no pose is that far from pose {pose}; lower it"
            raise ValueError(words)
        drawn.append(rng.choice(far))
    return np.array(drawn, dtype=np.intp)


def _with_outliers(
    graph: PoseGraph, edges: Indices, relative: Array, rng: np.random.Generator
) -> tuple[PoseGraph, Mask]:
    """Add closures that measure ``relative`` with the noise of inliers, and return their mask."""
    model = np.flatnonzero(~graph.is_odometry | graph.is_odometry.all())
    information = graph.information[rng.choice(model, size=len(edges))]
    measurement = _noisy(graph.group, relative, information, rng)
    longer = with_closures(graph, edges, measurement, information)
    return longer, np.arange(len(longer.edges)) >= len(graph.edges)


def _noisy(group: Group, relative: Array, information: Array, rng: np.random.Generator) -> Array:
    """Return relative ∘ Exp(η), each η drawn with the inverse information as covariance."""
    white = rng.normal(size=information.shape[:2])
    root = np.linalg.cholesky(information)
    drawn = np.linalg.solve(np.swapaxes(root, 1, 2), white[..., None])[..., 0]
    return group.compose(relative, group.exp(drawn))
