"""Cases of sets of closures: those that agree on a mistake, pairwise consistency, cliques."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
from robust_slam.consistency.cliques import max_clique
from robust_slam.consistency.pairwise import pairwise_distances, pcm
from robust_slam.graphs import add_random_closures, circle, manhattan, se2
from robust_slam.graphs.outliers import add_aliased_closures, add_grouped_closures
from robust_slam.graphs.pose_graph import PoseGraph

from tests.lib.course.parity_cases import Angles, Case, CliqueOf
from tests.lib.course.parity_graphs import C99, as_given


def clique_cases(rng: np.random.Generator) -> Iterator[Case]:
    """Random graphs of 1 to 30 vertices, empty and complete ones, some members fixed."""
    for k in range(120):
        size = int(rng.integers(1, 31))
        density = float(rng.choice([0.0, 0.3, 0.5, 0.8, 0.95, 1.0]))
        upper = np.triu(rng.random((size, size)) < density, 1)
        adjacency = upper | upper.T
        fixed = [int(rng.integers(size))] if k % 3 == 0 else []
        yield Case(
            {"adjacency": adjacency.ravel(), "k": size, "fixed": fixed},
            {"members": clique_of(adjacency, fixed)},
        )


def pcm_cases(rng: np.random.Generator) -> Iterator[Case]:
    """Towns and circles with outliers, closures both ways round, and gaps in the odometry."""
    for k in range(60):
        graph = _flipped(_world(rng, k), rng)
        if k % 6 == 5:
            graph = _with_gaps(graph, rng)
        gamma = float(rng.choice([C99, 1.0, 1e-6, 1e3]))
        shared = bool(k % 2)
        closures = np.flatnonzero(~graph.is_odometry)
        trusted = np.zeros(len(graph.edges), bool)
        trusted[closures[: k % 2]] = True
        result = pcm(graph, gamma, trusted=trusted, shared_odometry=shared)
        fixed = list(range(k % 2))
        yield Case(
            {
                "graph": as_given(graph),
                "gamma": gamma,
                "options": {"sharedOdometry": shared, "trusted": trusted},
            },
            {
                "closures": result.closures,
                "distances": pairwise_distances(graph, shared_odometry=shared),
                "adjacency": result.adjacency,
                "clique": clique_of(result.adjacency, fixed),
                **_kept(result.kept, clique_of(result.adjacency, fixed)),
            },
        )


def alias_cases(rng: np.random.Generator) -> Iterator[Case]:
    """Closures that agree on one displacement, from the library with next to no noise."""
    for k in range(40):
        graph, truth = manhattan(60, rng, turn=0.35, closures=5)
        sure = replace(graph, information=1e24 * graph.information)
        size = 1 + k % 10
        misled, is_outlier = add_aliased_closures(sure, 1, rng, size=size, poses=truth)
        edges = misled.edges[is_outlier]
        yield Case(
            {"truth": truth.ravel(), "ends": edges[0], "size": size},
            {"edges": edges, "measurements": Angles(misled.measurement[is_outlier])},
        )


def clique_of(adjacency: np.ndarray, fixed: list[int]) -> CliqueOf:
    """What every answer must be, and which one it must be where the library's is the only one."""
    members = max_clique(adjacency, fixed=fixed).members
    others = [v for v in members if v not in fixed]
    only = all(_without(adjacency, int(v), fixed) < members.size for v in others)
    return CliqueOf(adjacency, members.size, fixed, members.tolist() if only else None)


def _without(adjacency: np.ndarray, v: int, fixed: list[int]) -> int:
    """The size of a largest clique that does not contain ``v``."""
    left = np.delete(np.delete(adjacency, v, 0), v, 1)
    return int(max_clique(left, fixed=[u - (u > v) for u in fixed]).members.size)


def _kept(kept: np.ndarray, clique: CliqueOf) -> dict[str, Any]:
    return {} if clique.members is None else {"kept": kept}


def _world(rng: np.random.Generator, k: int) -> PoseGraph:
    n = int(rng.choice([8, 20, 48, 100]))
    if k % 2:
        graph = manhattan(n, rng, turn=0.35, closures=int(rng.integers(1, 2 + n // 8)))[0]
    else:
        graph = circle(n, rng, laps=2, closures=int(rng.integers(1, 2 + n // 8)))[0]
    graph = add_random_closures(graph, int(rng.integers(1, 4 + n // 12)), rng)[0]
    return add_grouped_closures(graph, 1, rng, size=3)[0] if n > 20 else graph


def _flipped(graph: PoseGraph, rng: np.random.Generator) -> PoseGraph:
    """The graph with some edges written from j to i."""
    back = rng.random(len(graph.edges)) < 0.3
    edges, z = graph.edges.copy(), graph.measurement.copy()
    edges[back] = edges[back][:, ::-1]
    z[back] = se2.inverse(z[back])
    return replace(graph, edges=edges, measurement=z)


def _with_gaps(graph: PoseGraph, rng: np.random.Generator) -> PoseGraph:
    """The graph with one or two odometry edges called closures: several sessions."""
    odometry = graph.is_odometry.copy()
    odometry[rng.choice(np.flatnonzero(odometry), size=int(rng.integers(1, 3)))] = False
    return replace(graph, is_odometry=odometry)
