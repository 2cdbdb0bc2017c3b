"""The list of runs: which graphs, which outliers, how many, how often.

A world is a graph with outliers; all methods answer for the same worlds. A generated graph is
drawn anew for each seed, and its truth is known. Of a public one a part of the closures is
drawn where all would be too many, and the optimum without outliers stands for the truth. The
rate counts outliers among all closures. Spoiled worlds replace this share of the closures by
wrong ones; all others add outliers, so that 90 % are nine for each correct closure.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from robust_slam._arrays import Array, Mask
from robust_slam.descent import gauss_newton, start
from robust_slam.graphs import (
    Noise,
    PoseGraph,
    add_local_closures,
    add_random_closures,
    datasets,
    manhattan,
    sphere,
    spoil_closures,
)
from robust_slam.graphs.outliers import add_aliased_closures, add_grouped_closures
from robust_slam.graphs.pose_graph import select

from benchmarks import methods

VERSION = 2
"""Raise it when other code in this file gives the same world other measurements."""
CPU_LIMIT = 120
"""Seconds of CPU time after which a run is given up."""
GROUP = 5
"""Outliers of a group, and of a consistent group."""
LOST = 0.4
"""ATE (m) above which a map counts as lost."""
PERCENTS = (10, 30, 50, 70, 90)
KINDS = ("random", "local", "group", "consistent", "spoiled")


@dataclass(frozen=True)
class Plan:
    """A graph of the sweep: its correct closures, and how many seeds.

    ``poses`` is None for a public graph, which has its own poses and noise.
    """

    closures: int
    seeds: int
    poses: int | None = None
    noise: Noise = field(default_factory=Noise)


PLANS = {
    "manhattan": Plan(45, 5, 200, Noise((0.05, 0.05))),
    "sphere": Plan(45, 5, 100),
    "intel": Plan(45, 3),
    "CSAIL": Plan(45, 3),
}
GENERATORS = {"manhattan": manhattan, "sphere": sphere}


class World(NamedTuple):
    """What names a world: all that is drawn in it follows from these four."""

    graph: str
    kind: str
    percent: int
    seed: int


def digest() -> str:
    """Return a name for what all runs have in common: those of another name do not compare."""
    graphs = {name: (plan.closures, plan.poses, plan.noise) for name, plan in PLANS.items()}
    shared = (graphs, CPU_LIMIT, GROUP, sorted(methods.PARAMETERS.items()))
    return f"{VERSION}-{hashlib.sha256(repr(shared).encode()).hexdigest()[:8]}"


def worlds() -> Iterator[World]:
    """List all worlds, seed after seed: a sweep that is cut short has some of everything."""
    for seed in range(max(plan.seeds for plan in PLANS.values())):
        for name, plan in PLANS.items():
            if seed < plan.seeds:
                for kind in KINDS:
                    yield from (World(name, kind, percent, seed) for percent in PERCENTS)


def make(world: World) -> tuple[PoseGraph, Mask, Array]:
    """Return the spoiled graph, the mask ``(m,)`` of its outliers, and the poses to come to.

    Raises:
        DatasetMissing: a public graph is not on this machine.
    """
    # The graph of a seed is the same for all kinds and rates.
    of_graph, of_outliers = np.random.default_rng(world.seed).spawn(2)
    correct, reference = _without_outliers(world.graph, of_graph)
    return *_with_outliers(correct, world, reference, of_outliers), reference


def _without_outliers(name: str, rng: np.random.Generator) -> tuple[PoseGraph, Array]:
    plan = PLANS[name]
    if plan.poses is not None:
        return GENERATORS[name](plan.poses, rng, closures=plan.closures, noise=plan.noise)
    graph = datasets.load(name)
    closures = np.flatnonzero(~graph.is_odometry)
    chosen = rng.choice(closures, size=plan.closures, replace=False)
    part = select(graph, graph.is_odometry | np.isin(np.arange(len(graph.edges)), chosen))
    return part, gauss_newton(part, start.chordal(part))


def _with_outliers(
    graph: PoseGraph, world: World, reference: Array, rng: np.random.Generator
) -> tuple[PoseGraph, Mask]:
    share = world.percent / 100
    if world.kind == "spoiled":
        return spoil_closures(graph, share, rng, poses=reference)
    count = round(PLANS[world.graph].closures * share / (1 - share))
    if world.kind == "random":
        return add_random_closures(graph, count, rng, poses=reference)
    if world.kind == "local":
        return add_local_closures(graph, count, rng, poses=reference)
    add = add_grouped_closures if world.kind == "group" else add_aliased_closures
    groups = max(1, round(count / GROUP))
    return add(graph, groups, rng, size=GROUP, poses=reference)
