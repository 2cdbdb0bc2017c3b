"""Cases on pose graphs: residuals, descents and the loop."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
from robust_slam.descent.damped import descend_damped
from robust_slam.descent.normal_equations import NormalEquations
from robust_slam.descent.undamped import descend_undamped
from robust_slam.graphs import add_random_closures, circle, manhattan, se2
from robust_slam.graphs import pose_graph as pg
from robust_slam.graphs.generate import Noise
from robust_slam.graphs.metrics import align, ate
from robust_slam.graphs.odometry import dead_reckoning
from robust_slam.graphs.pose_graph import PoseGraph
from robust_slam.problems import PoseGraphProblem

from tests.lib.course.parity_cases import Angles, Case, loop_case
from tests.lib.worlds import random_graph, shaken

C99 = 3.368214175218727


def as_given(graph: PoseGraph) -> dict[str, Any]:
    """A graph, as node is given it."""
    return {
        "poses": graph.n,
        "edges": graph.edges,
        "measurements": graph.measurement,
        "information": graph.information,
        "trusted": graph.is_odometry,
    }


def graph_cases(rng: np.random.Generator) -> Iterator[Case]:
    """Residuals and dead reckoning, at random poses and at half turns."""
    for k in range(60):
        graph, poses = _graph(rng, k)
        if k % 5 == 4:
            poses = poses.copy()
            poses[1:, 2] = rng.choice([np.pi, 0.0, -np.pi], size=graph.n - 1)
        complete = graph.odometry_joins_all
        yield Case(
            {"graph": as_given(graph), "poses": poses.ravel()},
            {
                "residuals": Angles(pg.residuals(graph, poses)),
                "norms": pg.residual_norms(graph, poses),
                "deadReckoning": Angles(dead_reckoning(graph)) if complete else None,
            },
        )


def metric_cases(rng: np.random.Generator) -> Iterator[Case]:
    """Errors of maps."""
    for k in range(30):
        n = 1 + k
        truth = rng.normal(size=(n, 3)) * [5.0, 5.0, 2.0]
        motion = rng.normal(size=3) * 3.0
        estimate = se2.compose(motion, se2.compose(truth, 0.2 * rng.normal(size=(n, 3))))
        yield Case(
            {"estimate": estimate.ravel(), "truth": truth.ravel()},
            {
                "aligned": Angles(align(estimate, truth)),
                "ate": ate(estimate, truth),
            },
        )


def descent_cases(rng: np.random.Generator) -> Iterator[Case]:
    """Both descents, with all weights and with some at 0, with many steps and with few."""
    for k in range(80):
        graph, poses = _graph(rng, k)
        start = shaken(se2, poses, float(rng.choice([0.0, 0.05, 0.5])), rng)
        weights = rng.choice([0.0, 0.3, 1.0], size=len(graph.edges))
        weights[graph.is_odometry | (k % 4 == 0)] = 1.0
        if pg.unreached(graph, weights > 0.0).size:
            continue
        method = ("undampedDescent", "dampedDescent")[k % 2]
        limit, tol = int(rng.choice([1, 4, 500])), float(rng.choice([1e-9, 1e-6]))
        run = descend_damped if k % 2 else descend_undamped
        found = run(NormalEquations(graph), start, weights, tol, limit)
        yield Case(
            {
                "graph": as_given(graph), "start": start.ravel(), "weights": weights,
                "method": method, "tol": tol, "limit": limit,
            },
            {
                "poses": Angles(found.poses), "cost": found.cost, "step": found.step,
                "converged": found.converged,
            },
        )  # fmt: skip


def loop_cases(rng: np.random.Generator) -> Iterator[Case]:
    """The loop on graphs of 2 to 100 poses."""
    for k in range(260):
        graph, poses = _graph(rng, k)
        trusted = graph.is_odometry if k % 10 < 8 else np.zeros(len(graph.edges), bool)
        guess = None if k % 5 else shaken(se2, poses, 0.3, rng)
        options = {"tol": 1e-6, "steps": int(rng.choice([1, 1, 5, 100]))}
        limit = int(rng.choice([3, 100, 300, 300]))
        yield graph_loop(graph, guess, trusted, options, _method(rng), limit)
    yield from special_loops(rng)


def special_loops(rng: np.random.Generator) -> Iterator[Case]:
    """All rejected, nothing to reject, no residuals, half turns, ties and heavy outliers."""
    exact = manhattan(12, rng, closures=4, noise=Noise(scale=0.0))[0]
    town, outlier = add_random_closures(manhattan(60, rng, closures=10)[0], 30, rng)
    loose = np.zeros(len(town.edges), bool)
    once = {"tol": 1e-6, "steps": 1}
    # A smaller c would compare it with residuals that are rounding alone.
    for graph, trusted, c in (
        (exact, exact.is_odometry, C99),
        (town, loose, 0.1),
        (town, loose, 1e6),
        (town, town.is_odometry, 0.1),
        (town, town.is_odometry, C99),
        (_two(), np.zeros(7, bool), 2.0),
        (_two(), np.zeros(7, bool), 0.01),
        (_half_turns(), np.arange(5) < 4, C99),
    ):
        for name, kind in (("gnc", "tls"), ("gnc", "gm"), ("irls", "tls"), ("irls", "cauchy")):
            method = {"name": name, "c": c, "kind": kind, "kernel": kind, "x0": "guess"}
            yield graph_loop(graph, None, trusted, once, method, 200)
    assert outlier.sum() == 30


def graph_loop(
    graph: PoseGraph,
    guess: np.ndarray | None,
    trusted: np.ndarray,
    options: dict[str, Any],
    method: dict[str, Any],
    limit: int,
) -> Case:
    """The case of a method on a pose graph."""
    problem = PoseGraphProblem(graph, guess, trusted, **options)
    given = {
        "kind": "graph",
        "graph": as_given(graph) | {"trusted": trusted},
        "guess": problem.guess.ravel(),
        "options": options,
    }
    return loop_case(given, problem, method, limit, tol=1e-6)


def _method(rng: np.random.Generator) -> dict[str, Any]:
    x0 = "guess" if rng.random() < 0.7 else None
    c = float(rng.choice([C99, C99, 1.0, 10.0]))
    name = str(rng.choice(["gnc", "gnc", "irls"]))
    if name == "gnc":
        kind = str(rng.choice(["tls", "tls", "gm"]))
        return {"name": name, "c": c, "kind": kind, "x0": x0}
    kernel = str(rng.choice(["huber", "cauchy", "geman-mcclure", "tls"]))
    return {"name": name, "kernel": kernel, "c": c, "x0": x0}


def _graph(rng: np.random.Generator, k: int) -> tuple[PoseGraph, np.ndarray]:
    """A graph and its true poses: a town, a circle or a tangle of 2 to 100 poses."""
    n = int(
        rng.choice([2, 3, 5, 10, 20, 40, 60, 100], p=[0.1, 0.1, 0.2, 0.2, 0.2, 0.1, 0.06, 0.04])
    )
    if k % 3 == 0 or n < 10:
        m = n - 1 + int(rng.integers(1, 2 + n // 2))
        residual = float(rng.choice([0.01, 0.1, 0.3]))
        poses, graph = random_graph(int(rng.integers(10**6)), n=n, m=m, residual=residual)
        return _spoiled(graph, rng), poses
    if k % 3 == 1:
        graph, poses = manhattan(n, rng, turn=0.3, closures=int(rng.integers(1, 2 + n // 8)))
    else:
        graph, poses = circle(n, rng, laps=2, closures=int(rng.integers(1, 2 + n // 4)))
    outliers = int(rng.integers(0, 1 + n // 4))
    return (add_random_closures(graph, outliers, rng)[0] if outliers else graph), poses


def _spoiled(graph: PoseGraph, rng: np.random.Generator) -> PoseGraph:
    """The graph with some closures that measure anything."""
    wrong = ~graph.is_odometry & (rng.random(len(graph.edges)) < rng.choice([0.0, 0.3]))
    measurement = graph.measurement.copy()
    measurement[wrong] = rng.normal(size=(int(wrong.sum()), 3)) * [6.0, 6.0, 2.0]
    return replace(graph, measurement=measurement)


def _two() -> PoseGraph:
    """Seven readings of one step, which GNC decides for a group of outliers."""
    z = np.outer([0, 0, 0, 0, 6, 6, 30.0], [1, 0, 0])
    sharp = np.broadcast_to(np.diag([1.0, 1.0, 1e4]), (7, 3, 3))
    return PoseGraph(2, [[0, 1]] * 7, z, sharp, np.zeros(7, bool))


def _half_turns() -> PoseGraph:
    """A ring of five poses whose closure contradicts the odometry by half a turn."""
    edges = [[0, 1], [1, 2], [2, 3], [3, 4], [4, 0]]
    z = [[1.0, 0.0, 0.0]] * 4 + [[-4.0, 0.0, np.pi]]
    return PoseGraph(5, edges, z, [np.eye(3)] * 5, np.arange(5) < 4)
