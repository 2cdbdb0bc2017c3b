"""The methods that are compared on graphs with wrong closures, and the one way to score them.

Every method starts from the same poses, dead reckoning, trusts the odometry, and takes at most
``steps`` Gauss–Newton steps for each set of weights. Closures count as kept when their whitened
residual at a method's answer is within the 99 % threshold: the same question to all.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from robust_slam._arrays import Array, Mask
from robust_slam.errors import NotConverged
from robust_slam.estimators import chi_square_threshold, gnc, irls, max_mixture, switchable
from robust_slam.estimators.kernels import cauchy, dcs
from robust_slam.estimators.switches import joint_switchable
from robust_slam.graphs import PoseGraph, ate, gtsam_graph, pose_graph, precision_recall
from robust_slam.pipeline import solve
from robust_slam.problems import PoseGraphProblem

try:
    import gtsam
except ImportError:
    gtsam = None

TOL, LIMIT = 1e-4, 500
"""When reweighting has settled, and after how many solves it is given up."""
STEPS = 1
"""Gauss–Newton steps for each set of weights; with more, GNC follows the outliers further."""
GTSAM = "GTSAM's GNC-TLS"
"""The one method that needs the package gtsam."""

Method = Callable[[PoseGraphProblem, float], Array]
METHODS: dict[str, Method] = {}


@dataclass(frozen=True)
class Score:
    """What one run of one method was worth; ``seconds`` are of CPU time."""

    precision: float
    recall: float
    ate: float
    seconds: float


def method(name: str) -> Callable[[Method], Method]:
    """Enter a function (problem, threshold) -> poses into the table."""

    def enter(function: Method) -> Method:
        METHODS[name] = function
        return function

    return enter


@method("least squares")
def least_squares(problem: PoseGraphProblem, c: float) -> Array:
    """Trust everything."""
    return problem.initial()


@method("IRLS, Cauchy")
def irls_cauchy(problem: PoseGraphProblem, c: float) -> Array:
    """Start at the guess, as every method does that is a descent."""
    return irls(problem, cauchy(1.0), problem.guess, tol=TOL, max_iterations=LIMIT).x


@method("GNC-TLS")
def gnc_tls(problem: PoseGraphProblem, c: float) -> Array:
    """Start at least squares, as graduation does."""
    return gnc(problem, c).x


@method("GNC-TLS, odom.")
def gnc_from_odometry(problem: PoseGraphProblem, c: float) -> Array:
    """Start at dead reckoning, where no outlier has bent the map, as GTSAM does."""
    return gnc(problem, c, x0=problem.guess).x


@method("GNC-GM")
def gnc_gm(problem: PoseGraphProblem, c: float) -> Array:
    """Start at least squares, as graduation does."""
    return gnc(problem, c, "gm").x


@method("SC, closed form")
def sc(problem: PoseGraphProblem, c: float) -> Array:
    """Set the switches, solve, set the switches."""
    return switchable(problem, c**2, problem.guess, tol=TOL, max_iterations=LIMIT).x


@method("SC, jointly")
def sc_jointly(problem: PoseGraphProblem, c: float) -> Array:
    """Move poses and switches together, as the paper does."""
    return joint_switchable(problem, c**2, problem.guess, tol=TOL).x


@method("DCS")
def dcs_weights(problem: PoseGraphProblem, c: float) -> Array:
    """Reweight with the squared scaling, Φ = c²."""
    return irls(problem, dcs(c), problem.guess, tol=TOL, max_iterations=LIMIT).x


@method("max-mixture")
def mixture(problem: PoseGraphProblem, c: float) -> Array:
    """Let a null hypothesis, wide enough for any outlier on the map, stand beside each closure."""
    dof = problem.graph.group.DOF
    return max_mixture(problem, 0.7, 1e4, dof, problem.guess, tol=TOL, max_iterations=LIMIT).x


@method("PCM + GNC-TLS")
def pcm_gnc(problem: PoseGraphProblem, c: float) -> Array:
    """Run the pipeline, certificate included."""
    return solve(problem.graph).poses


@method(GTSAM)
def gtsam_gnc(problem: PoseGraphProblem, c: float) -> Array:
    """Run GTSAM's optimiser with its defaults, the odometry and the prior known inliers."""
    factors, values = gtsam_graph.to_gtsam(problem.graph, problem.guess)
    prior = len(problem.graph.edges)
    known = [*np.flatnonzero(problem.trusted).tolist(), prior]
    parameters = gtsam.GncGaussNewtonParams(gtsam.GaussNewtonParams())
    parameters.setLossType(gtsam.GncLossType.TLS)
    parameters.setKnownInliers(known)
    optimiser = gtsam.GncGaussNewtonOptimizer(factors, values, parameters)
    try:
        return gtsam_graph.poses_from_gtsam(optimiser.optimize(), problem.graph)
    except RuntimeError as error:
        raise NotConverged(str(error)) from None


def available() -> list[str]:
    """Return the names of the methods that run on this machine."""
    return [name for name in METHODS if name != GTSAM or gtsam is not None]


def run(name: str, spoiled: PoseGraph, is_outlier: Mask, reference: Array, steps: int) -> Score:
    """Return the score of one method on one spoiled graph.

    ``is_outlier`` ``(m,)`` marks the wrong closures; ``reference`` are the poses to come to.

    Raises:
        NotConverged: the method did not come to rest.
        Underdetermined: its weights left a pose loose.
    """
    c = chi_square_threshold(0.99, spoiled.group.DOF)
    problem = PoseGraphProblem(spoiled, steps=steps)
    began = time.process_time()
    poses = METHODS[name](problem, c)
    seconds = time.process_time() - began
    kept = pose_graph.residual_norms(spoiled, poses) <= c
    closures = ~spoiled.is_odometry
    precision, recall = precision_recall(kept[closures], ~is_outlier[closures])
    return Score(precision, recall, ate(poses, reference), seconds)
