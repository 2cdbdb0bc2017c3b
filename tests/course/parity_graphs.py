"""Cases on pose graphs: descents, covariances, the loop, switches with priors, and fleets."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
from robust_slam.descent import covariance
from robust_slam.descent.minimise import damped, last, undamped
from robust_slam.descent.normal_equations import NormalEquations
from robust_slam.estimators.loop import Stateless, reweight
from robust_slam.fleet import rounds
from robust_slam.graphs import add_random_closures, circle, manhattan
from robust_slam.graphs import pose_graph as pg
from robust_slam.graphs.generate import Noise
from robust_slam.graphs.odometry import dead_reckoning
from robust_slam.graphs.pose_graph import PoseGraph, select
from robust_slam.groups import se2
from robust_slam.problems import PoseGraphProblem
from robust_slam_course import labs

from lib.tests.worlds import random_graph, shaken
from tests.course.parity_cases import Angles, Case, loop_case, random_method

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
        here = NormalEquations(graph).start(start, weights)
        found = last(damped(here, tol, limit)) if k % 2 else undamped(here, tol, limit)
        given = {"graph": as_given(graph), "start": start.ravel(), "weights": weights}
        given |= {"method": method, "tol": tol, "limit": limit}
        numbers = {"cost": found.here.cost, "converged": found.converged}
        yield Case(given, {"poses": Angles(found.here.poses), **numbers})


def loop_cases(rng: np.random.Generator) -> Iterator[Case]:
    """The loop on graphs of 2 to 100 poses."""
    for k in range(80):
        graph, poses = _graph(rng, k)
        if k % 10 >= 8:
            graph = _loose(graph)
        guess = None if k % 5 else shaken(se2, poses, 0.3, rng)
        options = {"tol": 1e-6, "steps": int(rng.choice([1, 1, 5, 100]))}
        limit = int(rng.choice([3, 100, 300, 300]))
        method = random_method(rng, "guess", [C99, C99, 1.0, 10.0])
        yield graph_loop(graph, guess, method, limit, **options)
    yield from special_loops(rng)


def special_loops(rng: np.random.Generator) -> Iterator[Case]:
    """All rejected, nothing to reject, no residuals, half turns, ties and heavy outliers."""
    exact = manhattan(12, rng, closures=4, noise=Noise(scale=0.0))[0]
    town, _ = add_random_closures(manhattan(60, rng, closures=10)[0], 30, rng)
    # A smaller c would compare it with residuals that are rounding alone.
    for graph, c in (
        *((exact, C99), (_loose(town), 0.1), (_loose(town), 1e6), (town, 0.1), (town, C99)),
        *((_two(), 2.0), (_two(), 0.01), (_half_turns(), C99)),
    ):
        for name, kind in (("gnc", "tls"), ("gnc", "gm"), ("irls", "tls"), ("irls", "cauchy")):
            method = {"name": name, "c": c, "kind": kind, "kernel": kind, "x0": "guess"}
            yield graph_loop(graph, None, method, 200, tol=1e-6, steps=1)


def fleet_cases(rng: np.random.Generator) -> Iterator[Case]:
    """Two or three robots in a town, with wrong closures, and every round."""
    for k in range(6):
        count = 2 + k % 2
        graph, labels = _fleet(rng, count, 8 + k)
        options: dict[str, Any] = {"factor": 2.0, "every": 1 + k % 3, "tol": 1e-6}
        outcome = rounds.solve(graph, labels, C99, max_rounds=40, **options)
        options["maxRounds"] = 40
        seen = [
            {"poses": Angles(one.poses)}
            | {name: getattr(one, name) for name in ("weights", "mu", "numbers")}
            for one in outcome.rounds
        ]
        given = {"graph": as_given(graph), "labels": labels, "c": C99, "options": options}
        yield Case(given, {"stop": outcome.stop.value, "rounds": seen})


def covariance_cases(rng: np.random.Generator) -> Iterator[Case]:
    """Covariances of all poses of a town, some of whose edges weigh less."""
    graph, _ = labs.late_town()
    for _ in range(3):
        weights = np.where(graph.is_odometry, 1.0, rng.uniform(0.0, 1.0, len(graph.edges)))
        poses = PoseGraphProblem(graph, tol=1e-12).solve(weights, dead_reckoning(graph))
        numbers = list(range(1, graph.n))
        yield Case(
            {"graph": as_given(graph), "poses": poses.ravel(), "weights": weights}
            | {"numbers": numbers},
            {"all": covariance(graph, poses, numbers, weights)},
        )


class Switches(Stateless):
    """The closed form of switches that each have a λ ``lam`` ``(k,)``."""

    def __init__(self, lam: np.ndarray) -> None:
        self.lam = lam

    def weights(self, norms: np.ndarray, state: None) -> np.ndarray:
        return np.asarray((self.lam / (self.lam + norms**2)) ** 2)

    def cost(self, norms: np.ndarray) -> float:
        return float(np.sum(0.5 * self.lam * norms**2 / (self.lam + norms**2)))


def prior_cases(rng: np.random.Generator) -> Iterator[Case]:
    """The picture's town with claims that are equal, and with those of its scores."""
    town, scored = labs.scored_town()
    problem = PoseGraphProblem(town.graph, tol=1e-6, steps=1)
    for odds in (0.0 * scored, scored, scored - 7.0, scored + 20.0, 0.0 * scored + 45.0):
        rule = Switches(np.maximum(C99**2 + 2.0 * odds, 1e-6))
        found = reweight(problem, rule, problem.guess, tol=1e-9, max_iterations=300)
        yield Case(
            {"graph": as_given(town.graph), "lambda": C99**2, "logOdds": odds},
            {"x": Angles(found.x), "weights": found.weights, "cost": found.cost},
        )


def _fleet(rng: np.random.Generator, count: int, each: int) -> tuple[PoseGraph, np.ndarray]:
    """Return a town without odometry between the robots, all of them joined by closures."""
    labels = np.arange(count * each) // each
    while True:
        graph, truth = manhattan(len(labels), rng, side=3, turn=0.3, closures=3 * count)
        parted = np.ptp(labels[graph.edges], axis=1) > 0
        met = set(map(tuple, labels[graph.edges[parted & ~graph.is_odometry]].tolist()))
        if len(met) >= count - 1:
            break
    graph = select(graph, ~(graph.is_odometry & parted))
    return add_random_closures(graph, count, rng, poses=truth)[0], labels


def graph_loop(
    graph: PoseGraph, guess: np.ndarray | None, method: dict[str, Any], limit: int, **options: Any
) -> Case:
    problem = PoseGraphProblem(graph, guess, **options)
    given = {"kind": "graph", "graph": as_given(graph), "guess": problem.guess.ravel()}
    return loop_case(given | {"options": options}, problem, method, limit, tol=1e-6)


def _loose(graph: PoseGraph) -> PoseGraph:
    return replace(graph, is_odometry=np.zeros(len(graph.edges), bool))


def _graph(rng: np.random.Generator, k: int) -> tuple[PoseGraph, np.ndarray]:
    """A graph and its true poses: a town, a circle or a tangle of 2 to 100 poses."""
    sizes, shares = [2, 3, 5, 10, 20, 40, 60, 100], [0.1, 0.1, 0.2, 0.2, 0.2, 0.1, 0.06, 0.04]
    n = int(rng.choice(sizes, p=shares))
    if k % 3 == 0 or n < 10:
        m = n - 1 + int(rng.integers(1, 2 + n // 2))
        residual = float(rng.choice([0.01, 0.1, 0.3]))
        poses, graph = random_graph(int(rng.integers(10**6)), n=n, m=m, residual=residual)
        wrong = ~graph.is_odometry & (rng.random(len(graph.edges)) < rng.choice([0.0, 0.3]))
        z = graph.measurement.copy()
        z[wrong] = rng.normal(size=(int(wrong.sum()), 3)) * [6.0, 6.0, 2.0]
        return replace(graph, measurement=z), poses
    if k % 3 == 1:
        graph, poses = manhattan(n, rng, turn=0.3, closures=int(rng.integers(1, 2 + n // 8)))
    else:
        graph, poses = circle(n, rng, laps=2, closures=int(rng.integers(1, 2 + n // 4)))
    outliers = int(rng.integers(0, 1 + n // 4))
    return (add_random_closures(graph, outliers, rng)[0] if outliers else graph), poses


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
