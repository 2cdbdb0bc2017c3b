"""Worlds of tiers G to J: what is contested is a part of the map, and errors come together.

- G: a town whose last third hangs on few closures, some of which agree on a wrong place.
- H: laps of a square with a step that slipped, and closures at every so many poses.
- I: public graphs with what place recognition gives wrong: neighbours of the right pose, an
  aisle seen the other way round, whole wrong stretches, and copies.
- J: sessions of a fleet, and closures between two of them that agree on a wrong place.

In the ``CONTROLS`` nothing wrong agrees: a good map needs no doubt there.

Source: derived here; slips and trackers that restart as users of RTAB-Map and Isaac ROS met them.
"""

from dataclasses import replace
from itertools import accumulate

import numpy as np
from robust_slam._arrays import Array, Indices, Mask
from robust_slam.graphs import Noise, PoseGraph, add_local_closures, add_random_closures, manhattan
from robust_slam.graphs.generate import near_pairs
from robust_slam.graphs.outliers import add_aliased_closures
from robust_slam.graphs.pose_graph import select, with_closures
from robust_slam.groups import se2
from robust_slam.groups.group import group_of

from benchmarks.methods import Made

CONTROLS = ("none", "random", "local", "aliased")
CONTESTS = {
    "G": (
        *("aisle 3:5", "aisle 5:8", "aisle 8:12", "aisle 8:20", "aisle 6:6", "aisle 6:9"),
        *("aisle 6:15", "bridge 6:10", "bridge 6:6", "bridge 6:3", "copies 1", "copies 3"),
        *("copies 6", "copies 12", "beside 6", "beside 12", *CONTROLS),
    ),
    "H": (
        *(f"{kind} {every}" for kind in ("turn", "shift") for every in (1, 2, 4, 5)),
        *("restart 2", "restart 4", "origin 2", "origin 4", "none 1", "none 4"),
    ),
    "I": ("neighbours", "mirrored", "stretch", "copies", "none", "random"),
    "J": (*(f"{kind} {size}" for kind in ("agreeing", "random") for size in (2, 3, 5)), "none 3"),
}
"""The changes of the tiers: what is wrong, and how much of it."""
_POSES, _EARLY, _LATE = 300, 60, 12
"""A town's poses, the closures of its first two thirds, and those of the last in a control."""
_NEAR, _AISLE, _BESIDE = 1.0, 4.0, 3.0
"""Poses of a closure are so near (m); a wrong aisle is so far off, and the place of a copy."""
_CLOSURE = np.array([0.05, 0.05, 0.02])
_LAPS, _SIDE, _STEP = 3, 8, 0.5
"""Laps of the square, steps of a side, and their length (m)."""
_STEPS = np.array([0.02, 0.02, 0.01])
_LOOSE = 1e-6
"""A step that slipped is left this share of its information where that shall be true."""
_ROBOT, _WITHIN, _BETWEEN, _AGREEING = 60, 20, 6, 10
"""Poses and closures of a session; right closures between two of them, and wrong ones."""
_SPOILED, _STRETCH = 0.2, 12
"""This share of a public graph's closures is added as wrong ones, in stretches so long."""


def contest(tier: str, change: str, rng: np.random.Generator) -> Made:
    """Return the world of a ``change`` of tier G, H or J."""
    kind, _, size = change.partition(" ")
    if tier == "H":
        return _laps(kind, int(size), rng)
    return _fleet(kind, int(size), rng) if tier == "J" else _town(kind, size, rng)


def _made(graph: PoseGraph, right: int, truth: Array, is_truth: bool = True) -> Made:
    """Return the world where edges from number ``right`` on are wrong."""
    return Made(graph, np.arange(len(graph.edges)) >= right, truth, graph, is_truth)


def _closed(
    graph: PoseGraph, truth: Array, pairs: Indices, rng: np.random.Generator, moved: Array
) -> PoseGraph:
    """Return the graph with closures ``pairs`` ``(k, 2)`` that see j ``moved`` in the world."""
    group = group_of(truth)
    sigma = _CLOSURE if group is se2 else np.repeat(_CLOSURE[1:], 3)
    i, j = truth[pairs[:, 0]], group.compose(moved, truth[pairs[:, 1]])
    noise = group.exp(sigma * rng.normal(size=(len(pairs), group.DOF)))
    return with_closures(
        graph, pairs, group.compose(group.between(i, j), noise), np.diag(sigma**-2.0)
    )


def _some(pairs: Indices, count: int, rng: np.random.Generator) -> Indices:
    """Return ``count`` of the pairs, fewer where there are not so many."""
    chosen = rng.choice(len(pairs), size=min(count, len(pairs)), replace=False)
    return np.asarray(pairs[np.sort(chosen)])


def _aisle(
    truth: Array, late: Mask, far: float, rng: np.random.Generator
) -> tuple[Indices, Array]:
    """Return pairs of an early and a ``late`` pose that seem near once the late are so ``far``."""
    angle = rng.choice(4) * np.pi / 2
    moved = np.array([far * np.cos(angle), far * np.sin(angle), 0.0])
    seen = np.where(late[:, None], se2.compose(moved, truth), truth)
    pairs = near_pairs(seen[:, :2], _NEAR)
    return pairs[late[pairs[:, 0]] != late[pairs[:, 1]]], moved


def _town(kind: str, size: str, rng: np.random.Generator) -> Made:
    """Return a town whose last third hangs on few closures, or where two robots drive."""
    graph, truth = manhattan(_POSES, rng, closures=0, noise=Noise((0.05, 0.05)))
    two, control = kind == "bridge", kind in CONTROLS
    first = _POSES // 2 if two else 2 * _POSES // 3
    late, near = np.arange(_POSES) >= first, near_pairs(truth[:, :2], _NEAR)
    across = late[near[:, 0]] != late[near[:, 1]]
    early = ~across if two else ~late[near].any(axis=1)
    right, wrong = (int(word) for word in size.split(":")) if ":" in size else (0, 0)
    pairs = (
        _some(near[early], _EARLY, rng),
        _some(near[across], _LATE if control else right, rng),
    )
    graph = _closed(graph, truth, np.concatenate(pairs), rng, np.zeros(3))
    if control:
        return _controlled(graph, kind, truth, 30, rng)
    right = len(graph.edges)
    pairs, moved = _aisle(truth, late, _AISLE if wrong else _BESIDE, rng)
    pairs = _some(pairs, wrong or 1, rng)
    if kind == "beside":
        i, j = np.minimum(pairs[0], [first - int(size), _POSES - int(size)])
        pairs = np.column_stack([np.full(int(size), i), j + np.arange(int(size))])
    graph = _closed(graph, truth, pairs, rng, moved)
    if kind == "copies":
        graph = _copied(graph, np.repeat(right, int(size) - 1))
    return _made(_cut(graph, [first]) if two else graph, right - two, truth)


def _cut(graph: PoseGraph, first: list[int]) -> PoseGraph:
    """Return the graph without the steps that lead to the poses ``first`` of its sessions."""
    return select(graph, ~(graph.is_odometry & np.isin(graph.edges[:, 1], first)))


def _controlled(
    graph: PoseGraph, kind: str, truth: Array, count: int, rng: np.random.Generator
) -> Made:
    """Return the world with outliers that do not decide about a part of the map, or none."""
    if kind == "none":
        return _made(graph, len(graph.edges), truth)
    if kind == "aliased":
        spoiled, _ = add_aliased_closures(graph, 1, rng, size=8, poses=truth)
    else:
        add = add_random_closures if kind == "random" else add_local_closures
        spoiled, _ = add(graph, count, rng, poses=truth)
    return _made(spoiled, len(graph.edges), truth)


def _fleet(kind: str, robots: int, rng: np.random.Generator) -> Made:
    """Return the sessions of some robots in one town, and what joins each two of them."""
    graph, truth = manhattan(robots * _ROBOT, rng, side=5, closures=0, noise=Noise((0.05, 0.05)))
    robot, near = np.arange(robots * _ROBOT) // _ROBOT, near_pairs(truth[:, :2], _NEAR)
    of = robot[near]
    pairs = np.concatenate(
        [
            _some(near[np.all(of == (a, b), axis=1)], _WITHIN if a == b else _BETWEEN, rng)
            for a in range(robots)
            for b in range(a, robots)
        ]
    )
    first = [_ROBOT * k for k in range(1, robots)]
    graph = _cut(_closed(graph, truth, pairs, rng, np.zeros(3)), first)
    if kind != "agreeing":
        return _controlled(graph, kind, truth, 8 * robots, rng)
    right, (a, b) = len(graph.edges), np.sort(rng.choice(robots, size=2, replace=False))
    pairs, moved = _aisle(truth, robot == b, _AISLE, rng)
    pairs = _some(pairs[np.all(np.isin(robot[pairs], (a, b)), axis=1)], _AGREEING, rng)
    return _made(_closed(graph, truth, pairs, rng, moved), right, truth)


def _laps(kind: str, every: int, rng: np.random.Generator) -> Made:
    """Return laps of a square with closures at ``every`` so many poses, and steps that slipped."""
    straight, corner = [_STEP, 0.0, 0.0], [_STEP, 0.0, np.pi / 2]
    steps = np.tile([straight] * (_SIDE - 1) + [corner], (4 * _LAPS, 1))
    odometry = se2.compose(steps, se2.exp(_STEPS * rng.normal(size=steps.shape)))
    lap, n, truth = 4 * _SIDE, len(steps) + 1, _walked(steps)
    at = int(rng.integers(lap // 2, n - lap // 2))
    turned, far, side = rng.uniform(0.2, 1.6), rng.uniform(1.0, 3.0), rng.choice([-1.0, 1.0])
    slipped = {"none": [], "origin": list(range(at, at + 4))}.get(kind, [at])
    if kind in ("turn", "shift"):
        error = side * np.array([0.0, 0.0, turned] if kind == "turn" else [far, 0.0, 0.0])
        odometry[at] = se2.compose(odometry[at], error)
    elif slipped:
        told = _walked(odometry)
        told[at + 1 : at + 4] = 0.0
        lost = se2.between(told[:-1], told[1:])
        # A tracker that restarts takes where it is for the origin; one that is lost comes back.
        odometry[slipped] = lost[slipped]
    ends = np.column_stack([np.arange(n - 1), np.arange(1, n)])
    information = np.broadcast_to(np.diag(_STEPS**-2.0), (n - 1, 3, 3))
    graph = PoseGraph(n, ends, odometry, information, np.ones(n - 1, dtype=np.bool_))
    back = np.arange(0, n - lap, every)
    graph = _closed(graph, truth, np.column_stack([back, back + lap]), rng, np.zeros(3))
    loose = graph.information.copy()
    loose[slipped] *= _LOOSE
    world = _made(graph, len(graph.edges), truth)
    return replace(world, honest=replace(graph, information=loose))


def _walked(steps: Array) -> Array:
    """Return the poses ``(k + 1, 3)`` along ``steps`` ``(k, 3)``."""
    return np.array(list(accumulate(steps, se2.compose, initial=np.zeros(3))))


def misread(graph: PoseGraph, kind: str, poses: Array, rng: np.random.Generator) -> Made:
    """Return a public ``graph``, whose map are the ``poses``, with closures read wrongly."""
    closures = np.flatnonzero(~graph.is_odometry)
    right, count = len(graph.edges), max(3, round(_SPOILED * closures.size))
    groups = max(1, round(count / _STRETCH))
    if kind in ("none", "random"):
        return replace(_controlled(graph, kind, poses, count, rng), is_truth=False)
    if kind == "stretch":
        spoiled, _ = add_aliased_closures(graph, groups, rng, size=_STRETCH, poses=poses)
    elif kind == "mirrored":
        spoiled = _mirrored(graph, poses, groups, rng)
    elif kind == "neighbours":
        chosen = rng.choice(closures, size=count)
        pairs = graph.edges[chosen] + np.outer(rng.choice([-3, -2, 2, 3], size=count), [0, 1])
        fits = (pairs.max(axis=1) < graph.n) & (np.abs(np.diff(pairs)[:, 0]) > 1)
        chosen = chosen[fits & (pairs.min(axis=1) >= 0)]
        pairs = pairs[fits & (pairs.min(axis=1) >= 0)]
        spoiled = with_closures(graph, pairs, graph.measurement[chosen], graph.information[chosen])
    else:
        right += count
        again = rng.choice(closures, size=count)
        spoiled, _ = add_random_closures(_copied(graph, again), groups, rng, poses=poses)
        spoiled = _copied(spoiled, np.tile(np.arange(right, right + groups), 5))
    return _made(spoiled, right, poses, is_truth=False)


def _copied(graph: PoseGraph, edges: Indices) -> PoseGraph:
    """Return the graph with the ``edges`` ``(k,)`` once more, as closures."""
    return with_closures(
        graph, graph.edges[edges], graph.measurement[edges], graph.information[edges]
    )


def _mirrored(graph: PoseGraph, poses: Array, groups: int, rng: np.random.Generator) -> PoseGraph:
    """Return the graph where stretches count as others that are driven the other way."""
    group, typical = graph.group, np.median(graph.information[~graph.is_odometry], axis=0)
    about, along = group.exp(np.pi * np.eye(group.DOF)[-1]), np.arange(_STRETCH)
    for i, j in rng.integers(_STRETCH, graph.n - _STRETCH, size=(groups, 2)):
        moved = group.compose(poses[i], group.compose(about, group.inverse(poses[j])))
        pairs = np.column_stack([i + along, j - along])
        pairs = pairs[np.abs(pairs[:, 0] - pairs[:, 1]) > 1]
        seen = group.between(poses[pairs[:, 0]], group.compose(moved, poses[pairs[:, 1]]))
        graph = with_closures(graph, pairs, seen, typical)
    return graph
