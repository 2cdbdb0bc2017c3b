"""Steps of the odometry that slipped: wheels spun, a scan was matched wrongly, a robot was lifted.

Such a step is off by far more than it claims, so closures on both sides of it contradict each
other although all of them are right. It is given up where the measurements support this: the
closures that return must be worth more than the measurement that is lost. Two signs point to a
step: it measured what no other step did, and rejected closures that cross it agree on one
displacement of all that is behind it.

Source: Mangelson et al. 2018 for closures that agree in pairs, MacKay 2003, chapter 28, for the
comparison by evidence; Latif, Cadena and Neira 2013 for the question; the rest is derived here.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import KDTree

from robust_slam._arrays import Array, Indices, Mask
from robust_slam.consistency.bridges import find_bridges
from robust_slam.consistency.pairwise import pcm
from robust_slam.errors import Underdetermined
from robust_slam.estimators import kernels
from robust_slam.estimators.reweighting import irls
from robust_slam.graphs.forest import Ancestors, Forest, find_forest
from robust_slam.graphs.odometry import spanning_tree
from robust_slam.graphs.pose_graph import (
    PoseGraph,
    connected_parts,
    select,
    unreached,
)
from robust_slam.solver.candidates import TOL, Candidate, Search
from robust_slam.solver.noise import rescaled
from robust_slam.solver.rivals import APART, compared, places

_MOST = 8
"""No more slips are looked for: the odometry is then of another kind."""
_NEIGHBOURS = 5
_UNLIKE, _USUAL = 3.0, 0.9
"""A step is unlike others if it is so many times as far from them as this share of the steps."""
_STRAYED = 2.0
"""A step leads astray if it is so many times as long as this share of the steps."""
_PRICES = {True: 4.0, False: 12.0}
"""What a slip must add to the evidence (nats), where the step is unlike others and where not."""
_PLACES = {True: 2, False: 3}
"""Closures must cross a slip at so many places: those of one place may be one mistake."""
_TIED = 1.0
"""Of maps whose evidence is so close, the one of the step that is most unlike others is taken."""
_TRIED = 3
"""So many groups of closures, and so many unlike steps, are tried for each slip."""
_LARGEST = 20_000_000
"""With more pairs of a pose and a closure, only steps that are unlike others are looked at."""
_MANY, _SOME = 500, 0.02
"""Of so many closures so small a share is rejected only where no step has slipped."""
_STEPS, _AT_REST = 10, 1e-2
_WITHIN = 1.5
"""More closures than before must be within so many thresholds, or none returns to pay a slip."""


@dataclass(frozen=True, eq=False)
class _Drive:
    """The tree of trusted edges, and how much each step is unlike others.

    ``below`` ``(k,)`` are the poses at the far ends of the steps ``edge`` ``(k,)``, ``unlike``
    ``(k,)`` is above 1 where a step is unlike others. Poses are numbered in depth-first order,
    ``number`` ``(n,)``; ``last`` ``(n,)`` is the largest number behind each pose.
    """

    forest: Forest
    below: Indices
    edge: Indices
    unlike: Array
    number: Indices
    last: Indices

    @classmethod
    def of(cls, search: Search) -> _Drive:
        graph = search.graph
        forest = find_forest(graph, search.trusted, np.ones(len(graph.edges)), np.array([0]))
        ancestors = Ancestors.of(forest)
        below = np.flatnonzero(forest.edge >= 0)
        below = below[graph.is_odometry[forest.edge[below]]]
        last = ancestors.number[:-1].copy()
        for pose in ancestors.order[:0:-1]:
            parent = forest.parent[pose]
            last[parent] = max(last[parent], last[pose])
        edge = forest.edge[below]
        return cls(forest, below, edge, _unlike(graph, edge), ancestors.number[:-1], last)

    def behind(self, step: Indices, poses: Indices) -> Mask:
        """Return whether each of the ``poses`` ``(p,)`` is behind each ``step``, ``(s, p)``."""
        v, number = self.below[step][:, None], self.number[poses]
        return np.asarray((self.number[v] <= number) & (number <= self.last[v]))

    def places(self, edges: Indices, step: int) -> int:
        """Return at how many places the ``edges`` ``(k, 2)`` across a ``step`` are.

        Across a usual step a run of closures, each beside the next, may be one place taken for
        another, however long it is.
        """
        if len(edges) == 0:
            return 0
        ends = np.sort(self.number[edges], axis=1)
        if self.unlike[step] > 1.0:
            return len(places(ends))
        beside = KDTree(ends).query_pairs(APART, p=np.inf, output_type="ndarray")
        return int(connected_parts(len(ends), beside).max()) + 1


def _unlike(graph: PoseGraph, edge: Indices) -> Array:
    """Return how unlike others each of the steps ``edge`` ``(k,)`` is, ``(k,)``.

    It is the distance to the neighbours among all that steps measured, in typical deviations,
    relative to what is usual; above 1 a step stands out. With few steps none does.
    """
    if edge.size <= 2 * _NEIGHBOURS:
        return np.zeros(edge.size)
    variances = np.diagonal(np.linalg.inv(graph.information[edge]), axis1=1, axis2=2)
    measured = graph.group.log(graph.measurement[edge]) / np.sqrt(np.median(variances, axis=0))
    distances, _ = KDTree(measured).query(measured, _NEIGHBOURS + 1)
    far = np.asarray(distances, dtype=np.float64)[:, -1]
    usual = _UNLIKE * float(np.quantile(far, _USUAL))
    return np.asarray(far / usual) if usual > 0.0 else np.zeros(edge.size)


def strayed(search: Search) -> int | None:
    """Return the first of two long steps, close to each other, that lead there and back, or None.

    A tracker that was lost for a few poses leaves where it was, and comes back.
    """
    graph = search.graph
    steps = np.flatnonzero(graph.is_odometry & ~search.slips)
    length = np.linalg.norm(graph.translation[steps], axis=1)
    far = length > _STRAYED * np.quantile(length, _USUAL) if length.size else length > 0.0
    long, length = steps[far], length[far]
    before, after = graph.edges[long[:-1], 0], graph.edges[long[1:], 1]
    place = graph.group.translation(search.x0)
    net = np.linalg.norm(place[after] - place[before], axis=1)
    found = (after - before <= APART + 1) & (2.0 * net < length[:-1] + length[1:])
    return int(long[np.argmax(found)]) if np.any(found) else None


@dataclass(frozen=True, eq=False)
class _Start:
    """A step that may have slipped, poses to start from, and weights ``(m,)`` to begin with."""

    step: int
    poses: Array
    weights: Array


def find_slips(search: Search, best: Candidate) -> tuple[Search, Candidate]:
    """Return the search without the steps that slipped, and its map, or both as they were."""
    closures = ~search.trusted
    count, rejected = int(np.sum(closures)), int(np.sum(closures & ~best.kept))
    nearly_all = count >= _MANY and rejected <= _SOME * count
    if count < min(_PLACES.values()) or nearly_all or search.deadline.passed:
        return search, best
    drive = _Drive.of(search)
    found = _fewer(drive, *_grown(drive, search, best))
    apart = _apart(drive, search, best)
    if apart is not None:
        other = _fewer(drive, *_grown(drive, *apart))
        found = max(found, other, key=lambda one: _worth(drive, *one))
    return found


def _worth(drive: _Drive, search: Search, one: Candidate) -> float:
    """Return the evidence of a map less the price of its slips."""
    prices = [_PRICES[bool(unlike > 1.0)] for unlike in drive.unlike[search.slips[drive.edge]]]
    return one.evidence - sum(prices)


def _grown(drive: _Drive, search: Search, best: Candidate) -> tuple[Search, Candidate]:
    """Return the search and the map with further slips, while each is worth its price."""
    while np.sum(search.slips) < _MOST:
        found = [
            one
            for start in _starts(drive, search, best)
            for one in _freed(drive, search, best, start)
        ]
        if not found:
            break
        most = max(_worth(drive, *one) for one in found)
        if most <= _worth(drive, search, best):
            break
        tied = [one for one in found if _worth(drive, *one) > most - _TIED]
        search, best = max(
            tied, key=lambda one: float(drive.unlike[one[0].slips[drive.edge]].sum())
        )
    return search, best


def _fewer(drive: _Drive, search: Search, best: Candidate) -> tuple[Search, Candidate]:
    """Return the search and the map without the slips that are not worth their price."""
    for edge in np.flatnonzero(search.slips):
        slips = search.slips.copy()
        slips[edge] = False
        less = replace(search, slips=slips)
        for one in _settled(less, best.poses, best.tested):
            if _worth(drive, less, one) > _worth(drive, search, best):
                search, best = less, one
    return search, best


def _settled(search: Search, poses: Array, tested: Array) -> Iterator[Candidate]:
    """Yield the candidate of the ``poses``, or nothing where kept edges do not join all."""
    if not search.deadline.passed:
        with suppress(ValueError):
            yield search.settle("slips", poses, tested)


def _freed(
    drive: _Drive, search: Search, best: Candidate, start: _Start
) -> Iterator[tuple[Search, Candidate]]:
    """Yield the search and the map where the step of ``start`` slipped, if enough cross it."""
    slips = search.slips.copy()
    slips[drive.edge[start.step]] = True
    trial = replace(search, slips=slips)
    problem = trial.problem(rescaled(search.graph, best.tested))
    poses = start.poses
    for _ in range(_STEPS):
        if search.deadline.passed:
            return
        before = problem.residual_norms(poses)
        try:
            poses = problem.solve(start.weights, poses)
        except Underdetermined:
            return
        moved = np.abs(problem.residual_norms(poses) - before)[start.weights > 0.0]
        if moved.max() < _AT_REST:
            break
    near = ~search.trusted & (problem.residual_norms(poses) <= _WITHIN * search.threshold)
    if near.sum() <= np.sum(best.kept & ~search.trusted):
        return
    for one in _settled(trial, poses, best.tested):
        ends = search.graph.edges[one.kept & ~search.trusted]
        at, to = (drive.behind(np.array([start.step]), end)[0] for end in ends.T)
        crossing = ends[at != to]
        if drive.places(crossing, start.step) >= _PLACES[bool(drive.unlike[start.step] > 1.0)]:
            yield trial, one


def _starts(drive: _Drive, search: Search, best: Candidate) -> list[_Start]:
    """Return the steps to try: groups of closures point to them, or they are unlike others."""
    weights = (best.kept | search.trusted).astype(np.float64)
    starts = _displaced(drive, search, best, weights)
    tried = {start.step for start in starts}
    order = np.argsort(-drive.unlike, kind="stable")
    fresh = order[(drive.unlike[order] > 1.0) & ~search.slips[drive.edge[order]]]
    more = [int(step) for step in fresh if int(step) not in tried][:_TRIED]
    return starts + [_Start(step, best.poses, weights) for step in more]


def _displaced(drive: _Drive, search: Search, best: Candidate, weights: Array) -> list[_Start]:
    """Return starts where rejected closures that agree displace what is behind a step."""
    groups = _groups(drive, search, best)
    groups.sort(key=lambda one: (len(one[2]) - one[1], drive.unlike[one[0]]), reverse=True)
    starts: list[_Start] = []
    seen: set[tuple[int, ...]] = set()
    for step, _, members, middle, inside in groups:
        if len(starts) == _TRIED:
            break
        if tuple(members) in seen or step in {start.step for start in starts}:
            continue
        seen.add(tuple(members))
        i, j = search.graph.edges.T
        now = np.where((inside[i] != inside[j]) & ~search.trusted, 0.0, weights)
        now[members] = 1.0
        starts.append(_Start(step, _moved(search.graph, best.poses, inside, middle), now))
    return starts


def _groups(
    drive: _Drive, search: Search, best: Candidate
) -> list[tuple[int, int, Indices, int, Mask]]:
    """Return step, kept closures against it, closures for it, their middle and what they move."""
    graph = search.graph
    kept = graph.edges[best.kept & ~search.trusted]
    left = np.flatnonzero(~best.kept & ~search.trusted)
    steps = np.flatnonzero(~search.slips[drive.edge])
    if graph.n * (len(kept) + left.size) > _LARGEST:
        steps = steps[drive.unlike[steps] > 1.0][: 10 * _MOST]
    whole = connected_parts(graph.n, graph.edges[search.trusted & ~search.slips])
    ahead = [False, True] if np.any(search.slips) else [False]
    cuts = []
    for flipped in ahead:
        lost = _crossing(drive, whole, steps, kept, flipped).sum(axis=1)
        crossing = _crossing(drive, whole, steps, graph.edges[left], flipped)
        usual = drive.unlike[steps] <= 1.0
        least = np.where(usual, _PLACES[False], _PLACES[True])
        use = crossing.sum(axis=1) - lost >= least
        cuts.append((flipped, steps[use], lost[use], crossing[use]))
    touched = np.any([crossing.any(axis=0) for *_, crossing in cuts], axis=0)
    if touched.sum() < min(_PLACES.values()):
        return []
    agree = compared(search, best, left[touched])[0][0] <= search.threshold
    found = []
    for flipped, chosen, lost, crossing in cuts:
        for rows in _alike(crossing):
            across = crossing[rows[0]][touched]
            inner = agree[np.ix_(across, across)]
            middle = int(np.argmax(inner.sum(axis=1)))
            members = left[touched][across][inner[middle]]
            first = rows[np.lexsort((-drive.unlike[chosen[rows]], lost[rows]))[0]]
            step = int(chosen[first])
            unlike = bool(drive.unlike[step] > 1.0)
            if members.size - lost[first] < _PLACES[unlike]:
                continue
            if drive.places(graph.edges[members], step) < _PLACES[unlike]:
                continue
            inside = _inside(drive, whole, np.array([step]), np.arange(graph.n), flipped)[0]
            found.append(
                (step, int(lost[first]), members, int(left[touched][across][middle]), inside)
            )
    return found


def _alike(crossing: Mask) -> list[Indices]:
    """Return the rows of ``crossing`` ``(s, r)`` that are equal, for each different row."""
    if not len(crossing):
        return []
    _, label = np.unique(np.packbits(crossing, axis=1), axis=0, return_inverse=True)
    order = np.argsort(label.ravel(), kind="stable")
    return np.split(order, np.flatnonzero(np.diff(label.ravel()[order])) + 1)


def _inside(drive: _Drive, whole: Indices, steps: Indices, poses: Indices, flipped: bool) -> Mask:
    """Return which ``poses`` ``(p,)`` a step would displace, ``(s, p)``.

    They are those behind it in the part ``whole`` ``(n,)`` that it belongs to or, ``flipped``,
    those ahead of it.
    """
    same = whole[drive.below[steps]][:, None] == whole[poses]
    return np.asarray(same & (drive.behind(steps, poses) != flipped))


def _crossing(
    drive: _Drive, whole: Indices, steps: Indices, edges: Indices, flipped: bool
) -> Mask:
    i, j = (_inside(drive, whole, steps, end, flipped) for end in edges.T)
    return np.asarray(i != j)


def _moved(graph: PoseGraph, poses: Array, inside: Mask, closure: int) -> Array:
    """Return ``poses`` with those ``inside`` ``(n,)`` moved so that the ``closure`` fits."""
    group = graph.group
    i, j = graph.edges[closure]
    z = graph.measurement[closure]
    if not inside[j]:
        i, j, z = j, i, group.inverse(z)
    goal = group.compose(poses[i], z)
    displacement = group.compose(goal, group.inverse(poses[j]))
    moved = poses.copy()
    moved[inside] = group.compose(displacement[None], poses[inside])
    return moved


def _apart(drive: _Drive, search: Search, best: Candidate) -> tuple[Search, Candidate] | None:
    """Return the search and the map where all steps unlike others slipped, if closures join it.

    The parts of the drive are then sessions, and PCM finds the closures that join them.
    """
    order = np.argsort(-drive.unlike, kind="stable")
    order = order[drive.unlike[order] > 1.0]
    if not 2 <= order.size <= _MOST or search.deadline.passed:
        return None
    graph = search.graph
    slips = np.zeros(len(graph.edges), dtype=np.bool_)
    slips[drive.edge[order]] = True
    if unreached(graph, ~slips).size:
        return None
    parts = replace(rescaled(graph, best.found), is_odometry=graph.is_odometry & ~slips)
    split = select(parts, ~slips)
    consistency = pcm(split, search.threshold, max_seconds=search.deadline.left)
    bridges = np.flatnonzero(~slips)[find_bridges(split, consistency.kept).edges]
    tree = search.trusted & ~slips
    tree[bridges] = True
    if unreached(graph, tree).size:
        return None
    trial = replace(search, slips=slips)
    problem = trial.problem(rescaled(graph, best.tested))
    x0 = spanning_tree(parts, tree.astype(np.float64))
    poses = irls(problem, kernels.dcs(search.threshold), x0, tol=TOL, max_iterations=100).x
    return next(((trial, one) for one in _settled(trial, poses, best.tested)), None)
