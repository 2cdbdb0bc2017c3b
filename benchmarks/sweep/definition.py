"""The list of runs: which graphs, which outliers, how many, how often, in ten tiers.

A world is a graph with outliers; all methods answer for the same worlds. A generated graph is
drawn anew for each seed, and its truth is known. Of a public one a part of the closures is
drawn where all would be too many, and the optimum without outliers stands for the truth. The
rate counts outliers among all closures. Spoiled worlds replace this share of the closures by
wrong ones; all others add outliers, so that 90 % are nine for each correct closure.

- A: every kind, rate and seed. Methods may be tuned on it.
- B: the same with seeds that were sealed before the version was scored (``seal``).
- C: every ninth world of A, with deviations that are claimed wrongly.
- D: the same worlds with odometry that slips or has more noise than it claims.
- E: one group of aliased closures, of half to twice as many as there are inliers.
- F: large public graphs, and a town where a place recogniser confuses corners that look alike.
- G to J: contests about a part of the map (``contests``), for a few methods.
"""

import hashlib
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from functools import partial
from itertools import chain, islice
from typing import NamedTuple

import numpy as np
from robust_slam._arrays import Array, Mask
from robust_slam.descent import gauss_newton, start
from robust_slam.files import datasets
from robust_slam.graphs import (
    Noise,
    PoseGraph,
    add_local_closures,
    add_random_closures,
    manhattan,
    sphere,
    spoil_closures,
)
from robust_slam.graphs.outliers import add_aliased_closures, add_grouped_closures
from robust_slam.graphs.pose_graph import select
from robust_slam_course.recogniser import recognised

from benchmarks import methods
from benchmarks.methods import Made
from benchmarks.sweep import seal
from benchmarks.sweep.changes import CHANGES, changed
from benchmarks.sweep.contests import CONTESTS, contest, misread

VERSION = 3
"""Raise it when other code in this file gives the same world other measurements."""
CPU_LIMIT = 120
"""Seconds of CPU time after which a run is given up."""
GROUP = 5
"""Outliers of a group, and of a consistent group."""
LOST = 0.4
"""ATE (m) above which a map counts as lost."""
PERCENTS = (10, 30, 50, 70, 90)
KINDS = ("random", "local", "group", "consistent", "spoiled")
TIERS = ("A", "B", "C", "D", "E", "F", *CONTESTS)
EVERY = 9
"""Tiers C and D take every ninth world of A."""
ALIASED = {33: 10, 50: 20, 60: 30, 67: 40}
"""Tier E: percent of outliers, and the size of their one group beside 20 inliers."""
CONTEST_SEEDS = 1
"""Tiers G to J: worlds of each contest; constants may be chosen on seeds 0 to 99."""
_OWN = 49
"""Worlds of these tiers have nothing in common with those of the same seed in others."""
LOOK_ALIKE = (10, 30, 50)
"""Tier F: percent of the town's crossings that look like another one."""


@dataclass(frozen=True)
class Plan:
    """A graph of the sweep: its correct closures, and how many seeds.

    ``poses`` is None for a public graph, which has its own poses and noise, and ``closures`` is
    None where it keeps all of them.
    """

    closures: int | None
    seeds: int
    poses: int | None = None
    noise: Noise = field(default_factory=Noise)


PLANS = {
    "manhattan": Plan(45, 5, 200, Noise((0.05, 0.05))),
    "sphere": Plan(45, 5, 100),
    "intel": Plan(45, 3),
    "CSAIL": Plan(45, 3),
}
FEW = {name: Plan(20, 3, plan.poses, plan.noise) for name, plan in PLANS.items()} | {
    "sphere": Plan(20, 3, 150)
}
"""The graphs of tier E, with fewer inliers, so that one group can outnumber them."""
LARGE = {name: Plan(None, 1) for name in ("M3500", "city10000", "sphere2500", "parking-garage")}
LARGE_PERCENTS = (10, 50)
TOWN = Plan(None, 5, 300, Noise((0.05, 0.05)))
"""The town of the place recogniser, which chooses the closures itself."""
GENERATORS = {"manhattan": manhattan, "sphere": sphere}
GENERATED = (*GENERATORS, "town")
"""Graphs whose truth is known."""
GRAPHS = [*PLANS, "town", *LARGE, "smallGrid3D"]


class World(NamedTuple):
    """What names a world: all that is drawn in it follows from these six."""

    graph: str
    kind: str
    percent: int
    seed: int
    tier: str = "A"
    change: str = ""


def digest() -> str:
    """Return a name for what all runs have in common: those of another name do not compare."""
    plans = {**PLANS, **{f"few {name}": plan for name, plan in FEW.items()}, **LARGE, "town": TOWN}
    graphs = {name: (plan.closures, plan.poses, plan.noise) for name, plan in plans.items()}
    shared = (graphs, CPU_LIMIT, GROUP, ALIASED, sorted(methods.PARAMETERS.items()))
    return f"{VERSION}-{hashlib.sha256(repr(shared).encode()).hexdigest()[:8]}"


def worlds(tiers: Iterable[str] = TIERS) -> Iterator[World]:
    """List the worlds of the tiers, in each seed after seed: one cut short has some of all.

    Those of tier B are there once the sealed seeds are.
    """
    return chain.from_iterable(_TIERS[tier]() for tier in tiers)


def _tuning() -> Iterator[World]:
    for seed in range(max(plan.seeds for plan in PLANS.values())):
        yield from _of_seed(seed, seed)


def _of_seed(number: int, seed: int, tier: str = "A") -> Iterator[World]:
    """List the worlds of the ``number``-th ``seed``, of which public graphs have fewer."""
    for name, plan in PLANS.items():
        if number < plan.seeds:
            for kind in KINDS:
                yield from (World(name, kind, percent, seed, tier) for percent in PERCENTS)


def _sealed() -> Iterator[World]:
    for number, seed in enumerate(seal.seeds()):
        yield from _of_seed(number, seed, "B")


def _changed(tier: str) -> Iterator[World]:
    for world in islice(_tuning(), None, None, EVERY):
        yield from (world._replace(tier=tier, change=change) for change in CHANGES[tier])


def _aliased() -> Iterator[World]:
    for name, plan in FEW.items():
        for seed in range(plan.seeds):
            yield from (World(name, "aliased", percent, seed, "E") for percent in ALIASED)


def _large() -> Iterator[World]:
    for seed in range(TOWN.seeds):
        yield from (World("town", "recognised", percent, seed, "F") for percent in LOOK_ALIKE)
    for name in LARGE:
        yield from (World(name, "random", percent, 0, "F") for percent in LARGE_PERCENTS)


def _contested(tier: str) -> Iterator[World]:
    for seed in range(CONTEST_SEEDS):
        for graph in ("CSAIL", "smallGrid3D") if tier == "I" else ("manhattan",):
            yield from (World(graph, "contest", 0, seed, tier, it) for it in CONTESTS[tier])


_TIERS: dict[str, Callable[[], Iterator[World]]] = {
    "A": _tuning,
    "B": _sealed,
    "C": partial(_changed, "C"),
    "D": partial(_changed, "D"),
    "E": _aliased,
    "F": _large,
    **{tier: partial(_contested, tier) for tier in CONTESTS},
}


def entered(world: World) -> list[str]:
    """Return the methods of a world: starts other than odometry are a question of tier A."""
    if world.tier in CONTESTS:
        return list(methods.CONTESTED)
    return list(methods.METHODS) if world.tier == "A" else methods.FIRST


def make(world: World) -> Made:
    """Return the world with its graph, its outliers and the poses to come to.

    Raises:
        DatasetMissing: a public graph is not on this machine.
    """
    if world.tier in CONTESTS:
        return _contest(world)
    # The graph of a seed is the same for all kinds, rates and changes.
    of_graph, of_outliers, of_change = np.random.default_rng(world.seed).spawn(3)
    if world.graph == "town":
        assert TOWN.poses is not None
        town = recognised(TOWN.poses, world.percent, TOWN.noise, of_graph)
        graph, is_outlier, reference, _ = town
        return Made(graph, is_outlier, reference, graph, is_truth=True)
    correct, reference = _without_outliers(world, of_graph)
    spoiled, is_outlier = _with_outliers(correct, world, reference, of_outliers)
    graph, honest = changed(spoiled, world.change, of_change)
    return Made(graph, is_outlier, reference, honest, world.graph in GENERATED)


def _contest(world: World) -> Made:
    rng = np.random.default_rng([world.seed, _OWN])
    if world.tier != "I":
        return contest(world.tier, world.change, rng)
    graph = datasets.load(world.graph)
    return misread(graph, world.change, gauss_newton(graph, start.chordal(graph)), rng)


def _without_outliers(world: World, rng: np.random.Generator) -> tuple[PoseGraph, Array]:
    plan = {"E": FEW, "F": LARGE}.get(world.tier, PLANS)[world.graph]
    if plan.poses is not None:
        make_graph = GENERATORS[world.graph]
        return make_graph(plan.poses, rng, closures=plan.closures, noise=plan.noise)
    part = datasets.load(world.graph)
    if plan.closures is not None:
        closures = np.flatnonzero(~part.is_odometry)
        chosen = rng.choice(closures, size=plan.closures, replace=False)
        part = select(part, part.is_odometry | np.isin(np.arange(len(part.edges)), chosen))
    return part, gauss_newton(part, start.chordal(part))


def _with_outliers(
    graph: PoseGraph, world: World, reference: Array, rng: np.random.Generator
) -> tuple[PoseGraph, Mask]:
    share = world.percent / 100
    if world.kind == "spoiled":
        return spoil_closures(graph, share, rng, poses=reference)
    if world.kind == "aliased":
        size = ALIASED[world.percent]
        return add_aliased_closures(graph, 1, rng, size=size, poses=reference)
    count = round(int(np.sum(~graph.is_odometry)) * share / (1 - share))
    if world.kind == "random":
        return add_random_closures(graph, count, rng, poses=reference)
    if world.kind == "local":
        return add_local_closures(graph, count, rng, poses=reference)
    add = add_grouped_closures if world.kind == "group" else add_aliased_closures
    groups = max(1, round(count / GROUP))
    return add(graph, groups, rng, size=GROUP, poses=reference)
