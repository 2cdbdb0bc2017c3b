"""What speaks against a map: rivals of it, and places that alone hold a part of it.

A rival is what rejected closures that agree with each other give, forced into the map and settled.
The contest is local: closures that both keep say nothing about it, so each is judged by the
evidence of what it keeps beyond them. Closures of one place may all be wrong for one reason. A
place is therefore one witness, however many closures it has, and a part of the map that hangs on
one place is as right as this place.

Source: Mangelson et al. 2018 for closures that agree in pairs, MacKay 2003, chapter 28, for the
comparison by evidence, Baarda 1968 for what the others leave of a measurement; the rest is derived
here.
"""

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from robust_slam._arrays import Array, Indices, Mask
from robust_slam._deadline import Deadline
from robust_slam.consistency.bridges import find_bridges
from robust_slam.consistency.pairwise import pairwise_distances
from robust_slam.estimators.graduation import gnc
from robust_slam.graphs.odometry import find_forest, poses_along
from robust_slam.graphs.pose_graph import (
    PoseGraph,
    connected_parts,
    relative_poses,
    residual_norms,
    residuals,
    select,
    squared_norms,
)
from robust_slam.problems import PoseGraphProblem
from robust_slam.solver.candidates import TOL, Candidate, Search, Sparing
from robust_slam.solver.evidence import any_entropy, evidence, gained
from robust_slam.solver.fitted import Fitted
from robust_slam.solver.noise import rescaled

APART, _ALONG = 4, 20
"""Closures are of one place if both ends are so few poses apart, or one end, and the other so."""
_LEAST = 3
"""Fewer rejected closures are no rival; so many of a group are trusted, lest one is wrong."""
_TRIED = 5
"""So many groups are tried, the largest first."""
_MORE = 1.3
"""A rival has more closures than this many times those that agree by chance, and one."""
_CLEAR = 2.0
"""A closure within so many thresholds is no matter of dispute."""
_STEPS, _AT_REST = 10, 0.05
"""A minimum takes so many steps, or fewer if one changes its cost (nats) by less."""
_COMPARABLE = 0.1
"""A rival is comparable if what it keeps beyond both has this share of the map's evidence."""
_WON = 3
"""So many rivals in turn may take the place of the map."""
_ALONE, _PERHAPS = 4.0, 8.0
"""A place is not confirmed if the map without it predicts it less (nats) better than chance, or
perhaps not, by a rough estimate …"""
_RESTING = 25
"""… and named if so many poses rest on it."""


def places(ends: Indices) -> Indices:
    """Return the first closure of each place among those with ``ends`` ``(k, 2)``."""
    free, first = np.ones(len(ends), dtype=np.bool_), []
    for k in range(len(ends)):
        if free[k]:
            first.append(k)
            off = np.abs(ends - ends[k])
            free &= (off.min(axis=1) > APART) | (off.max(axis=1) > _ALONG)
    return np.array(first, dtype=np.intp)


@dataclass(frozen=True, eq=False)
class Agreement:
    """How far pairs of rejected ``closures`` ``(k,)`` disagree, and how many must agree.

    The distances ``far`` ``(t, k, k)``, inf beyond the threshold, are along t trees of edges. More
    than ``enough`` ``(t,)`` must agree with one, since that many do by chance, where closures
    measure how any pose of the map is seen from any other.
    """

    closures: Indices
    far: Array
    enough: Array


def compared(search: Search, best: Candidate, *, in_map: bool = False) -> Agreement:
    """Return how the closures that a map rejects agree.

    First the kept edges of the map, a tree of the fewest of them, take the place of the odometry,
    and then the trusted edges; ``in_map`` asks along the first tree alone.
    """
    closures = np.flatnonzero(~best.kept & ~search.graph.is_odometry)
    graph = rescaled(search.graph, best.found)
    whole, every = as_mapped(graph, best), np.arange(best.kept.size)
    fewest = find_forest(whole, best.kept, np.ones(best.kept.size), np.array([graph.n // 2]))
    trees = (
        replace(whole, is_odometry=np.isin(every, fewest.edge)),
        replace(graph, is_odometry=search.trusted),
    )
    asked, far, enough = np.isin(every, closures), [], []
    for tree in trees[:1] if in_map else trees:
        far.append(pairwise_distances(tree, asked, most=search.threshold))
        enough.append(_LEAST - 1.0)
        if largest(np.array(far[-1:]), np.array(enough[-1:]), search.threshold) is not None:
            by_chance = _by_chance(tree, best.poses, closures)
            drawn = pairwise_distances(by_chance, asked, most=search.threshold)
            agree = np.sum(drawn <= search.threshold, axis=1).max()
            enough[-1] = max(enough[-1], _MORE * (agree + 1))
    return Agreement(closures, np.array(far), np.array(enough))


def largest(far: Array, enough: Array, threshold: float) -> Array | None:
    """Return how far closures ``(k,)`` are from that which most agree with, beyond chance.

    The distances ``far`` ``(t, k, k)`` and what is not ``enough`` ``(t,)`` are those of an
    ``Agreement``, or of some of its closures. It is None where no more agree.
    """
    more = np.sum(far <= threshold, axis=1) - enough[:, None]
    if more.max(initial=0.0) <= 0.0:
        return None
    return np.asarray(far[np.unravel_index(np.argmax(more), more.shape)])


def _by_chance(graph: PoseGraph, poses: Array, closures: Indices) -> PoseGraph:
    """Return the graph whose ``closures`` measure where one pose is seen from another."""
    i, j = poses[np.random.default_rng(0).integers(graph.n, size=(2, closures.size))]
    measurement = graph.measurement.copy()
    measurement[closures] = graph.group.between(i, j)
    return replace(graph, measurement=measurement)


def as_mapped(graph: PoseGraph, best: Candidate) -> PoseGraph:
    """Return the graph whose kept edges measure what they do in the map."""
    measurement = graph.measurement.copy()
    measurement[best.kept] = relative_poses(graph, best.poses)[best.kept]
    return replace(graph, measurement=measurement)


@dataclass(frozen=True, eq=False)
class Contest:
    """A rival, and the evidence (nats) of what it, and of what the map keeps beyond both."""

    rival: Candidate
    for_rival: float
    for_map: float


def comparable(found: Sequence[Contest]) -> list[Candidate]:
    """Return the rivals that explain what is contested nearly as well as the map, best first."""
    near = [one for one in found if one.for_rival > _COMPARABLE * one.for_map > 0.0]
    return [one.rival for one in sorted(near, key=lambda one: one.for_map / one.for_rival)]


def unbeaten(
    search: Search, best: Candidate, found: list[Contest]
) -> tuple[Search, Candidate, list[Contest]]:
    """Return the search and the map that no rival beats, and its contests, at first ``found``.

    Other closures may join the sessions of a rival.
    """
    for _ in range(_WON):
        better = [one for one in found if one.for_rival > one.for_map]
        if not better:
            break
        first = max(better, key=lambda one: one.for_rival - one.for_map)
        free = replace(search, trusted=search.given)
        won = search.refined(free.settle("rival", first.rival.poses, best.tested))
        if won.evidence <= best.evidence:
            break
        beaten = Contest(best, first.for_map, first.for_rival)
        trusted = search.given.copy()
        trusted[find_bridges(search.graph, won.kept).edges] = True
        search, best = replace(search, trusted=trusted), won
        found = [beaten, *contests(search, best)]
    return search, best, found


def contests(
    search: Search, best: Candidate, agreement: Agreement | None = None
) -> Iterator[Contest]:
    """Yield a contest with each of the ``rivals`` of the map."""
    free = _free(search, best)
    for rival in rivals(search, best, agreement or compared(search, best)):
        for_rival = _beyond(free, rival, best)
        for_map = _beyond(free, best, rival) if for_rival > 0.0 else np.inf
        yield Contest(rival, for_rival, for_map)


def rivals(search: Search, best: Candidate, agreement: Agreement) -> Iterator[Candidate]:
    """Yield a map for each group of closures that ``best`` rejects and that agree.

    The middle of a group is trusted, GNC finds what else agrees with it, and truncated least
    squares decides freely from there, with the noise of the map.
    """
    free = _free(search, best)
    asked = _rejected(free, best.poses)[agreement.closures]
    left, far = agreement.closures[asked], agreement.far[:, asked][:, :, asked]
    for _ in range(_TRIED):
        near = largest(far, agreement.enough, search.threshold)
        if near is None or search.deadline.passed:
            return
        agree = near <= search.threshold
        seed = np.argsort(near, kind="stable")[:_LEAST]
        # Of a group that is torn or leads nowhere, another part may be right.
        tried = near <= max(np.median(near[agree]), near[seed].max())
        if places(free.graph.edges[left[agree]]).size > 1:
            with suppress(ValueError):
                for poses in _forced(free, best, left[seed], left[agree]):
                    rival = free.settle("rival", poses, np.ones(4))
                    if np.any(rival.kept[left]):
                        yield rival
                    if np.all(rival.kept[left[agree]]):
                        tried |= rival.kept[left]
        left, far = left[~tried], far[:, ~tried][:, :, ~tried]


def _free(search: Search, best: Candidate) -> Search:
    """Return the search with the noise of the map, where what is given alone is trusted."""
    graph = rescaled(search.graph, best.found)
    return replace(search, graph=graph, trusted=search.given, learns=False)


def _forced(free: Search, best: Candidate, seed: Indices, group: Indices) -> Iterator[Array]:
    """Yield the poses that GNC reaches with a ``group`` whose ``seed`` is trusted, if it fits.

    It begins at the map without the closures that may contradict the seed, where the seed
    puts sessions. If most of the seed does not fit there, there is no rival.
    """
    used, trusted, n = best.kept.copy(), free.trusted.copy(), free.graph.n
    used[group] = trusted[seed] = True
    length = np.where(free.graph.is_odometry, 1.0, float(n) ** 2)
    length[seed] = n
    whole = as_mapped(free.graph, best)
    poses = poses_along(whole, find_forest(whole, used, length, np.zeros(1, dtype=np.intp)))
    problem = Sparing(select(free.graph, used), poses, trusted[used], steps=1)
    first = trusted | (best.kept & ~_against(free, best, seed))
    poses = at_rest(problem, first[used], poses, free.deadline)
    left, c = free.deadline.left, free.threshold
    if np.median(residual_norms(free.graph, poses)[seed]) <= c:
        yield gnc(problem, c, "tls", poses, tol=TOL, max_seconds=left).x


def _against(free: Search, best: Candidate, seed: Indices) -> Mask:
    """Return the kept closures ``(m,)`` that join what the ``seed`` joins, across a cut of fewest.

    A cut parts earlier from later poses, sessions before others; where no cut parts the ends of
    all the seed, the one with most of it counts.
    """
    low, high = np.sort(free.graph.edges, axis=1).T
    cuts = np.arange(1, free.graph.n)
    kept = best.kept & ~free.given

    def crossing(closures: Indices) -> Indices:
        before = np.searchsorted(np.sort(low[closures]), cuts)
        return before - np.searchsorted(np.sort(high[closures]), cuts)

    joined = crossing(np.flatnonzero(free.graph.is_odometry)) > 0
    against = np.where(joined, kept.size, 0) + crossing(np.flatnonzero(kept))
    ranked = crossing(seed) * (2 * kept.size + 1) - against
    cut = cuts[np.argmax(ranked)]
    return np.asarray(kept & (low < cut) & (high >= cut))


def _beyond(free: Search, one: Candidate, other: Candidate) -> float:
    """Return the evidence of what one map keeps and the other clearly rejects, each place once.

    What joins sessions that are apart without it is no evidence, and one place alone none either.
    """
    own = np.flatnonzero(one.kept & _rejected(free, other.poses))
    own = own[places(free.graph.edges[own])]
    if own.size < 2:
        return 0.0
    base = one.kept & other.kept
    for edge in own:
        part = connected_parts(free.graph.n, free.graph.edges[base])
        i, j = free.graph.edges[edge]
        base[edge] = part[i] != part[j]
    rich = base.copy()
    rich[own] = True
    less, more, there = (
        evidence(free.graph, _minimum(free, kept, start.poses), kept, free.entropy)
        for kept, start in ((base, one), (rich, one), (base, other))
    )
    # A rival that tears the odometry may be stuck where its base is no minimum.
    return more - max(less, there)


def _rejected(free: Search, poses: Array) -> Mask:
    """Return which closures ``(m,)`` a map clearly rejects, even if they claim too much."""
    graph, closures = free.graph, ~free.graph.is_odometry
    if not np.any(closures):
        return closures
    typical = np.median(graph.information[closures], axis=0)
    r = residuals(graph, poses)
    squares = np.minimum(squared_norms(graph, poses), np.einsum("ka,ab,kb->k", r, typical, r))
    return np.asarray(closures & (squares > (_CLEAR * free.threshold) ** 2))


def _minimum(search: Search, kept: Mask, poses: Array) -> Array:
    return at_rest(search.problem(search.graph), kept, poses, search.deadline)


def at_rest(problem: PoseGraphProblem, used: Mask, poses: Array, deadline: Deadline) -> Array:
    """Return the poses ``(n, …)`` near ``poses`` where the ``used`` edges ``(m,)`` are at rest.

    Steps end when one hardly changes their cost.

    Raises:
        Underdetermined: the edges do not determine the poses to working precision.
    """
    cost = np.inf
    for _ in range(_STEPS):
        poses = problem.solve(used.astype(np.float64), poses)
        before, cost = cost, 0.5 * float(np.sum(problem.residual_norms(poses)[used] ** 2))
        if abs(before - cost) < _AT_REST or deadline.passed:
            break
    return poses


@dataclass(frozen=True, eq=False)
class Lone:
    """A closure of the place that ``poses`` ``(k,)`` rest on, which nothing else confirms."""

    edge: int
    poses: Indices


def lone_places(search: Search, best: Candidate) -> tuple[Lone, ...]:
    """Return the places that hold a part of the map, and that nothing confirms.

    Chance are two poses of the map: without the place, the others and the odometry hardly tell
    those that it joins from any two.
    """
    free = replace(search, graph=rescaled(search.graph, best.found))
    closures = np.flatnonzero(best.kept & ~search.graph.is_odometry)
    one_each = np.zeros(best.kept.size, dtype=np.bool_)
    one_each[closures[places(search.graph.edges[closures])]] = True
    # What joins sessions is needed, also where its ends are near those of another one.
    one_each |= best.kept & search.trusted & ~search.graph.is_odometry
    kept = (best.kept & search.graph.is_odometry) | one_each
    poses = _minimum(free, kept, best.poses)
    fit, entropy = Fitted.of(free.graph, poses, kept), any_entropy(free.graph.group, poses)
    closures = np.flatnonzero(one_each[kept])
    for limit, left in ((_PERHAPS, fit.roughly_left), (_ALONE, fit.left)):
        if closures.size:
            closures = closures[gained(fit, closures, left(closures), entropy) < limit]
    if not closures.size:
        return ()
    alone, shares = np.flatnonzero(kept)[closures], fit.following(closures)
    found = (
        Lone(int(k), np.flatnonzero(share > 0.5)) for k, share in zip(alone, shares, strict=True)
    )
    return tuple(one for one in found if one.poses.size >= _RESTING)
