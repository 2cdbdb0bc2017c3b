"""Steps of the odometry that slipped: wheels spun, a scan was matched wrongly, a robot was lifted.

Such a step is off by far more than it claims, so closures on both sides of it contradict each
other although all of them are right. It is given up where the measurements support this: the
closures that return must be worth more than the measurement that is lost. Two signs point to a
step: it measured what no other step did, and rejected closures that cross it agree on one
displacement of all that is behind it.

Source: Mangelson et al. 2018 for closures that agree in pairs, MacKay 2003, chapter 28, for the
comparison by evidence; Latif, Cadena and Neira 2013 for the question; the rest is derived here.
"""

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csc_array, eye_array
from scipy.sparse.linalg import spsolve
from scipy.spatial import KDTree

from robust_slam._arrays import Array, Indices, Mask
from robust_slam.consistency.bridges import find_bridges
from robust_slam.consistency.pairwise import pcm
from robust_slam.estimators import kernels
from robust_slam.estimators.reweighting import irls
from robust_slam.graphs.odometry import Ancestors, Forest, find_forest, poses_along, spanning_tree
from robust_slam.graphs.pose_graph import (
    PoseGraph,
    connected_parts,
    residual_norms,
    select,
    unreached,
)
from robust_slam.solver.candidates import TOL, Candidate, Search
from robust_slam.solver.noise import rescaled
from robust_slam.solver.rivals import APART, Agreement, as_mapped, at_rest, compared, largest

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
_GROSS = 30.0
"""A usual step that a run of closures alone points to is off by so many deviations."""
_TIED = 1.0
"""Of maps whose evidence is so close, the one of the step that is most unlike others is taken."""
_TRIED = 3
"""So many groups of closures, and so many unlike steps, are tried for each slip."""
_WITHIN = 1.5
"""More closures than before must be within so many thresholds, or none returns to pay a slip."""


def find_slips(search: Search, best: Candidate, agreement: Agreement) -> tuple[Search, Candidate]:
    """Return the search without the steps that slipped, and its map, or both as they were.

    ``agreement`` is that of the closures that ``best`` rejects.
    """
    unlike, first = _unlike(search.graph), best
    apart = [_fewer(unlike, *one) for one in _apart(search, best, unlike)]
    search, best = max([(search, best), *apart], key=lambda one: _worth(unlike, *one))
    while np.sum(search.slips) < _MOST and not search.deadline.passed:
        agree = agreement if best is first else compared(search, best, in_map=True)
        found = [
            one
            for start in _starts(search, best, unlike, agree)
            if not search.deadline.passed
            for one in _freed(search, best, start)
            if _is_sure(search, best, *one, unlike)
        ]
        most = max((_worth(unlike, *one) for one in found), default=-np.inf)
        if most <= _worth(unlike, search, best):
            break
        tied = [one for one in found if _worth(unlike, *one) > most - _TIED]
        search, best = max(tied, key=lambda one: float(unlike[one[0].slips].sum()))
    return _fewer(unlike, search, best)


def _worth(unlike: Array, search: Search, one: Candidate) -> float:
    """Return the evidence of a map less the price of its slips."""
    return one.evidence - sum(_PRICES[bool(each > 1.0)] for each in unlike[search.slips])


def _unlike(graph: PoseGraph) -> Array:
    """Return how unlike others each step of the odometry is, ``(m,)``, 0 of a closure.

    It is the distance to the neighbours among all that steps measured, in typical deviations,
    relative to what is usual; above 1 a step stands out. With few steps none does.
    """
    steps, unlike = np.flatnonzero(graph.is_odometry), np.zeros(len(graph.edges))
    if steps.size <= 2 * _NEIGHBOURS:
        return unlike
    variances = np.diagonal(np.linalg.inv(graph.information[steps]), axis1=1, axis2=2)
    measured = graph.group.log(graph.measurement[steps]) / np.sqrt(np.median(variances, axis=0))
    distances, _ = KDTree(measured).query(measured, _NEIGHBOURS + 1)
    far = np.asarray(distances, dtype=np.float64)[:, -1]
    usual = _UNLIKE * float(np.quantile(far, _USUAL))
    unlike[steps] = far / usual if usual > 0.0 else 0.0
    return unlike


def strayed(search: Search) -> int | None:
    """Return a long step that leads where the drive was not, or None.

    A tracker that was lost for a few poses leaves where it was and comes back, or it reports one
    pose again and again. So another long step leads back soon, or there is no motion beside it.
    """
    graph = search.graph
    steps = np.flatnonzero(graph.is_odometry & ~search.slips)
    length = np.linalg.norm(graph.translation[steps], axis=1)
    far = length > _STRAYED * np.quantile(length, _USUAL) if length.size else length > 0.0
    still = np.pad(length == 0.0, 1)
    stuck = steps[far & (still[:-2] | still[2:])]
    long, length = steps[far], length[far]
    before, after = graph.edges[long[:-1], 0], graph.edges[long[1:], 1]
    place = graph.group.translation(search.x0)
    net = np.linalg.norm(place[after] - place[before], axis=1)
    there = long[:-1][(after - before <= APART + 1) & (2.0 * net < length[:-1] + length[1:])]
    found = np.sort(np.concatenate([stuck, there]))
    return int(found[0]) if found.size else None


def _apart(search: Search, best: Candidate, unlike: Array) -> Iterator[tuple[Search, Candidate]]:
    """Yield the search and the map where all steps unlike others slipped, if closures join it.

    The parts of the drive are then sessions, and PCM finds the closures that join them.
    """
    graph, slips = search.graph, unlike > 1.0
    if not 2 <= np.sum(slips) <= _MOST or search.deadline.passed or unreached(graph, ~slips).size:
        return
    parts = replace(rescaled(graph, best.found), is_odometry=graph.is_odometry & ~slips)
    split = select(parts, ~slips)
    agree = pcm(split, search.threshold, max_seconds=search.deadline.left).kept
    tree = search.trusted & ~slips
    tree[np.flatnonzero(~slips)[find_bridges(split, agree).edges]] = True
    if unreached(graph, tree).size:
        return
    trial = replace(search, slips=slips)
    problem = trial.problem(rescaled(graph, best.tested))
    x0 = spanning_tree(parts, tree.astype(np.float64))
    most = search.deadline.left
    poses = irls(problem, kernels.dcs(search.threshold), x0, tol=TOL, max_seconds=most).x
    with suppress(ValueError):
        yield trial, trial.settle("slips", poses, best.tested)


def _fewer(unlike: Array, search: Search, best: Candidate) -> tuple[Search, Candidate]:
    """Return the search and the map without the slips that are not worth their price."""
    for step in np.flatnonzero(search.slips):
        if search.deadline.passed:
            break
        less = replace(search, slips=search.slips & (np.arange(best.kept.size) != step))
        with suppress(ValueError):
            name = "slips" if np.any(less.slips) else "DCS"
            one = less.settle(name, best.poses, best.tested)
            if _worth(unlike, less, one) > _worth(unlike, search, best):
                search, best = less, one
    return search, best


@dataclass(frozen=True, eq=False)
class _Start:
    """A step that may have slipped, poses to start from, and the edges ``(m,)`` of their map."""

    step: int
    poses: Array
    used: Mask


def _starts(
    search: Search, best: Candidate, unlike: Array, agreement: Agreement
) -> Iterator[_Start]:
    """Yield a start for each step to try: unlike ones, and those that a group points to."""
    order = np.argsort(-unlike, kind="stable")
    for step in order[(unlike[order] > 1.0) & ~search.slips[order]][:_TRIED]:
        yield _Start(int(step), best.poses, best.kept | search.trusted)
    graph = as_mapped(rescaled(search.graph, best.found), best)
    length = np.where(search.graph.is_odometry, 1.0, float(graph.n) ** 2)
    forest = find_forest(graph, best.kept, length, np.array([0]))
    for group in _groups(search, agreement):
        for step in _pointed_at(graph, forest, unlike, group, best.kept & ~search.trusted):
            tree = graph.edges[forest.edge[(forest.edge >= 0) & (forest.edge != step)]]
            i, j = connected_parts(graph.n, tree)[graph.edges.T]
            used = best.kept & (i == j)
            used[group[0]] = True
            poses = poses_along(graph, find_forest(graph, used, length, np.array([0])))
            used[group] = True
            yield _Start(step, poses, used)


def _groups(search: Search, agreement: Agreement) -> Iterator[Indices]:
    """Yield groups of rejected closures that agree in the map, their middle first."""
    left, far = agreement.closures, agreement.far[:1]
    for _ in range(_TRIED):
        near = largest(far, agreement.enough[:1], search.threshold)
        if near is None or search.deadline.passed:
            return
        order = np.argsort(near, kind="stable")
        group = order[near[order] <= search.threshold]
        yield left[group]
        left, far = np.delete(left, group), np.delete(np.delete(far, group, 1), group, 2)


def _pointed_at(
    graph: PoseGraph, forest: Forest, unlike: Array, group: Indices, kept: Mask
) -> set[int]:
    """Return the step that most of a ``group`` cross, less ``kept`` ones, of unlike and of all."""
    ends = np.concatenate([graph.edges[group], graph.edges[kept]]).T
    sign = np.repeat([1.0, -1.0], [group.size, int(np.sum(kept))])
    turn = Ancestors.of(forest).common(*ends)
    # Paths go up from both ends to where they turn: with that off twice, an edge sums its own.
    passed = np.concatenate([ends.ravel(), turn])
    count = np.bincount(passed, np.concatenate([sign, sign, -2.0 * sign]), graph.n)
    below = np.flatnonzero(forest.edge >= 0)
    edge, up = forest.edge[below], (forest.parent[below], below)
    tree = csc_array((np.ones(below.size), up), shape=(graph.n, graph.n))
    gained = np.round(spsolve(eye_array(graph.n, format="csc") - tree, count))[below]
    found = set()
    for alone in (True, False):
        asked = graph.is_odometry[edge] & (gained >= _PLACES[alone])
        which = np.flatnonzero(asked & (unlike[edge] > 1.0) if alone else asked)
        if which.size:
            found.add(int(edge[which[np.lexsort((-unlike[edge[which]], -gained[which]))[0]]]))
    return found


def _freed(search: Search, best: Candidate, start: _Start) -> Iterator[tuple[Search, Candidate]]:
    """Yield the search and the map where the step slipped, if more closures than before fit."""
    trial = replace(search, slips=search.slips | (np.arange(best.kept.size) == start.step))
    problem = trial.problem(rescaled(search.graph, best.tested))
    with suppress(ValueError):
        poses = at_rest(problem, start.used, start.poses, search.deadline)
        near = ~search.trusted & (problem.residual_norms(poses) <= _WITHIN * search.threshold)
        if near.sum() > np.sum(best.kept & ~search.trusted) and not search.deadline.passed:
            yield trial, trial.settle("slips", poses, best.tested)


def _is_sure(
    search: Search, best: Candidate, trial: Search, one: Candidate, unlike: Array
) -> bool:
    """Tell whether closures that return to ``one`` across its last slip cannot be one mistake.

    A run of closures, each beside the next, may be one place taken for another, however long it
    is. But where it begins beside a closure that does not cross the step, it was cut there.
    """
    graph, last = search.graph, trial.slips & ~search.slips
    part = connected_parts(graph.n, graph.edges[search.trusted & ~last])
    closures = one.kept & ~search.trusted
    ends, returns = np.sort(graph.edges[closures], axis=1), ~best.kept[closures]
    crosses = part[ends[:, 0]] != part[ends[:, 1]]
    a, b = KDTree(ends).query_pairs(APART, p=np.inf, output_type="ndarray").T
    cut, alone = returns & crosses, bool(unlike[last] > 1.0)
    off = residual_norms(rescaled(graph, one.found), one.poses)[last].max()
    gross = cut.sum() >= _PLACES[False] and (alone or off > _GROSS)
    if gross and np.any((cut[a] & ~crosses[b]) | (cut[b] & ~crosses[a])):
        return True
    runs = connected_parts(len(ends), np.column_stack([a, b])[crosses[a] & crosses[b]])
    return np.unique(runs[crosses]).size >= _PLACES[alone]
