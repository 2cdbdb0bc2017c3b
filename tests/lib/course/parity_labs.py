"""Cases of the labs: the runs that are certified, covariances, and switches with priors."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from robust_slam.descent import covariance
from robust_slam.estimators.loop import Stateless, reweight
from robust_slam.graphs.odometry import dead_reckoning
from robust_slam.problems import PoseGraphProblem
from robust_slam_course import labs

from tests.lib.course.parity_cases import Angles, Case
from tests.lib.course.parity_graphs import C99, as_given, graph_loop


def run_cases(rng: np.random.Generator) -> Iterator[Case]:
    """All runs of the picture: its certificates are those of the library's steps."""
    graph, *_ = labs.ring(0)
    for start in labs.starts(graph).values():
        for name, kind in (("gnc", "tls"), ("irls", "geman-mcclure")):
            method = {"name": name, "c": C99, "kind": kind, "kernel": kind, "x0": "guess"}
            yield graph_loop(graph, start, method, 100, tol=1e-9, steps=200)


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
