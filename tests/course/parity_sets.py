"""Cases of sets of closures: those that agree on a mistake, pairwise consistency, cliques."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from robust_slam.consistency.cliques import max_clique
from robust_slam.consistency.pairwise import pairwise_distances, pcm
from robust_slam.graphs import add_random_closures, circle, manhattan
from robust_slam.graphs.outliers import add_aliased_closures, add_grouped_closures
from robust_slam.graphs.pose_graph import PoseGraph
from robust_slam_course.pictures.breaking import rules
from robust_slam_course.pictures.graphs import graph_data

from lib.tests.worlds import turned
from tests.course.parity_cases import Angles, Case
from tests.course.parity_graphs import C99, as_given


def clique_cases(rng: np.random.Generator) -> Iterator[Case]:
    """Random graphs of 1 to 30 vertices, empty and complete ones."""
    for _ in range(120):
        size = int(rng.integers(1, 31))
        density = float(rng.choice([0.0, 0.3, 0.5, 0.8, 0.95, 1.0]))
        upper = np.triu(rng.random((size, size)) < density, 1)
        adjacency = upper | upper.T
        largest = max_clique(adjacency).members.size
        given = {"adjacency": adjacency.ravel(), "k": size}
        yield Case(given, {"size": largest, "isClique": True})


def pcm_cases(rng: np.random.Generator) -> Iterator[Case]:
    """Towns and circles with outliers, and closures both ways round."""
    for k in range(60):
        graph = _world(rng, k)
        graph = turned(graph, ~graph.is_odometry & (rng.random(len(graph.edges)) < 0.3))
        gamma = float(rng.choice([C99, 1.0, 1e-6, 1e3]))
        result = pcm(graph, gamma)
        expected = {"closures": result.closures, "distances": pairwise_distances(graph)}
        expected |= {"adjacency": result.adjacency, "size": result.clique.members.size}
        given = {"graph": as_given(graph), "gamma": gamma}
        yield Case(given, expected | {"isClique": True, "keepsIt": True})


def attack_cases(rng: np.random.Generator, count: int = 100) -> Iterator[Case]:
    """Random scores of *Break the map*, in the data that the picture has."""
    data = {name: graph_data(*rules.town(name)[:2], 9) for name in rules.TOWNS}
    for _ in range(count):
        town, solver = (str(rng.choice(list(each))) for each in (rules.TOWNS, rules.SOLVERS))
        size = int(rng.integers(1, rules.MOST + 1))
        j = int(rng.integers(2, rules.TOWNS[town][1] - size + 1))
        i = int(rng.integers(j - 1))
        dx, dy = rng.integers(-rules.REACH, rules.REACH + 1, 2)
        score = f"{town}:{solver}:{i}-{j}:{dx},{dy if dx or dy else 1}:{size}"
        attack = rules.attack(score)
        state = {"solver": solver, "ends": [attack.i, attack.j], "count": size}
        yield Case(
            {"data": data[town], "state": state | {"offset": [attack.dx, attack.dy]}},
            {"bent": (bent := rules.bent(attack)), "fooled": bent > rules.BOUND},
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


def _world(rng: np.random.Generator, k: int) -> PoseGraph:
    n = int(rng.choice([8, 20, 48, 100]))
    if k % 2:
        graph = manhattan(n, rng, turn=0.35, closures=int(rng.integers(1, 2 + n // 8)))[0]
    else:
        graph = circle(n, rng, laps=2, closures=int(rng.integers(1, 2 + n // 8)))[0]
    graph = add_random_closures(graph, int(rng.integers(1, 4 + n // 12)), rng)[0]
    return add_grouped_closures(graph, 1, rng, size=3)[0] if n > 20 else graph
