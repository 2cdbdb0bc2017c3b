"""What the expressions of the tables may name beside what a page defines."""
# ruff: noqa: F401  the tables name what is imported here

from collections.abc import Callable
from dataclasses import replace
from math import comb, cos, degrees, e, exp, log, pi, radians, sqrt
from types import SimpleNamespace

import numpy as np
from robust_slam.certificates.optimality import certificate, certify
from robust_slam.consistency.cliques import max_clique
from robust_slam.consistency.pairwise import pcm
from robust_slam.descent import start as start_poses
from robust_slam.estimators import NullHypothesis, kernels
from robust_slam.estimators.graduation import gnc, start_mu, tls_surrogate
from robust_slam.estimators.reweighting import irls
from robust_slam.estimators.thresholds import chi_square_threshold
from robust_slam.fleet.robot import Message
from robust_slam.fleet.rounds import Fleet
from robust_slam.graphs import pose_graph
from robust_slam.graphs.metrics import ate
from robust_slam.graphs.odometry import dead_reckoning, spanning_tree
from robust_slam.groups import se3
from robust_slam.problems import LinearProblem, LocationProblem, PoseGraphProblem, chain
from robust_slam_course import pipeline
from robust_slam_course.failures import FAULTS, measured
from robust_slam_course.plots import opening
from robust_slam_course.results import read_results
from scipy.optimize import brentq, least_squares, minimize_scalar
from scipy.stats import chi2, norm

from tests.book.prose import CHAPTERS
from tests.book.samples import READINGS, gm_weight, listing, three_poses, tls_weight
from tests.book.samples import efficiency as efficiency_by_stein

robustness = read_results(CHAPTERS / "data" / "robustness.csv")

TIMES = {
    "manhattan": 0.268 / 0.080, "city": 1.670 / 1.576, "csail": 0.029 / 0.010,
    "intel": 0.120 / 0.071, "ais2klinik": 12.472 / 1.981, "sphere": 0.704 / 0.580,
    "torus": 1.963 / 0.284, "grid": 46.343 / 1.717, "garage": 0.415 / 0.468,
    "cubicle": 2.456 / 0.754, "rim": 6.803 / 2.256,
}  # fmt: skip
"""Seconds of the dog-leg over those of SE-Sync, from the tables of its paper."""


def inliers_kept(graph: pose_graph.PoseGraph, kept: np.ndarray, wrong: np.ndarray) -> int:
    """Return how many correct closures a mask keeps."""
    return int(np.sum(kept & ~graph.is_odometry & ~wrong))


def maps_of_robots(
    graph: pose_graph.PoseGraph, walker: np.ndarray, weights: np.ndarray, *, held: bool = False
) -> list[np.ndarray]:
    """Return the map after each round from when robots have just met, with these weights.

    ``held`` fixes pose 0: the edge that holds it counts always, and outweighs all others.
    """
    fleet = Fleet(graph, walker)
    fleet.meet()
    fleet.record(None)
    for robot in fleet.robots:
        robot.weights = weights[robot.number].copy()
    first = fleet.robots[0]

    def hold(tol: float) -> list[Message]:
        block, poses = first.block()
        information = block.information.copy()
        information[-1] *= 1e10
        stiff = PoseGraphProblem(replace(block, information=information), poses, steps=1)
        first.poses = stiff.solve(np.append(first.weights, 1.0), poses)[1:]
        return first.tell()

    if held:
        first.improve = hold
    fleet.descend(None, 1e-6, 100)
    return [seen.poses for seen in fleet.rounds]


def steps_at_one_place(
    graph: pose_graph.PoseGraph, weights: np.ndarray, poses: np.ndarray
) -> list[np.ndarray]:
    """Return the maps of seven Gauss–Newton steps on the whole graph, the first one included."""
    problem, maps = PoseGraphProblem(graph, steps=1), [poses]
    for _ in range(6):
        maps.append(problem.solve(weights, maps[-1]))
    return maps


def biweight(c: float) -> SimpleNamespace:
    """Return Tukey's biweight, as far as an efficiency needs it."""
    return SimpleNamespace(scale=c, psi=lambda u: u * max(1 - (u / c) ** 2, 0.0) ** 2)


def cost_with_penalty(
    make: Callable[[float], kernels.Kernel], penalty: Callable[[float], float]
) -> bool:
    """Tell whether a cost is the lowest sum of a weighted square and its penalty on the weight."""
    kernel, scale = make(1.7), 1.7**2 / 2
    for u in (0.5, 1.5, 2.5, 7.0):

        def cost(w: float, u: float = u) -> float:
            return w * u**2 / 2 + scale * penalty(w)

        best = minimize_scalar(cost, bounds=(1e-12, 1), options={"xatol": 1e-12})
        if abs(best.fun - kernel.rho(u)) > 1e-6 or abs(best.x - kernel.weight(u)) > 1e-4:
            return False
    return True
