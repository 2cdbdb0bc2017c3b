"""The methods that are compared on graphs with wrong closures, and the one way to score them.

All trust the odometry, take one Gauss–Newton step for each set of weights, and have the same
number of linear solves. Closures count as kept when their whitened residual at a method's map
is within the 99 % threshold: the same test for all.

To enter a method, write a function (problem, threshold, start) -> poses under ``@method`` with
its name. ``python -m benchmarks.sweep`` then runs it, and it alone, on every graph.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial

import numpy as np
from robust_slam._arrays import Array, Mask
from robust_slam.descent.damped import descend_damped
from robust_slam.descent.normal_equations import NormalEquations
from robust_slam.errors import NotConverged
from robust_slam.estimators import chi_square_threshold, gnc, irls, kernels, max_mixture
from robust_slam.estimators.switches import joint_switchable
from robust_slam.graphs import PoseGraph, ate, gtsam_graph, pose_graph, precision_recall
from robust_slam.graphs.forest import find_forest, poses_along
from robust_slam.problems import PoseGraphProblem
from robust_slam.solver import solve
from robust_slam_course import pipeline

try:
    import gtsam
except ImportError:
    gtsam = None

PROBABILITY = 0.99
"""An inlier passes the threshold c with this probability: c² is a χ² quantile."""
STEPS = 1
"""Gauss–Newton steps for each set of weights; with more, GNC follows the outliers further."""
SOLVES = 500
"""Linear solves of a run, those of its start included; then its map is scored as it is."""
START_SOLVES = 200
"""So many of them at most for least squares, which outliers can make very slow."""
TOL = 1e-4
"""A map is at rest when no residual norm u changes by more than this, relative to 1 + u."""
START_TOL = 1e-6
"""Least squares is done when a step is this small, relative to the map."""
FACTOR = 1.4
"""By which GNC changes μ."""
CAUCHY = {1: 2.385, 3: 2.666, 6: 2.862}
"""Cauchy's constant by the dimension of a residual: 95 % efficiency on the norm."""
MIXTURE = (0.7, 1e4)
"""Max-mixture: the probability of an inlier, and how much wider an outlier spreads."""
PARAMETERS = {
    "probability": PROBABILITY,
    "steps": STEPS,
    "solves": SOLVES,
    "solves of the start": START_SOLVES,
    "tol": TOL,
    "factor": FACTOR,
    "cauchy": CAUCHY,
    "lambda, phi": "c^2",
    "mixture": MIXTURE,
}
"""What the results depend on besides the code."""

Descent = Callable[[PoseGraphProblem, float, Array], Array]
Method = Callable[[PoseGraphProblem, float], Array]


def _least_squares(problem: PoseGraphProblem) -> Array:
    """Return the poses that Levenberg–Marquardt reaches with all weights 1."""
    equations, ones = NormalEquations(problem.graph), np.ones(len(problem.graph.edges))
    return descend_damped(equations, problem.guess, ones, START_TOL, START_SOLVES).poses


def _tree(problem: PoseGraphProblem) -> Array:
    """Return the poses along a tree of fewest edges from pose 0, closures among them."""
    graph, every = problem.graph, np.ones(len(problem.graph.edges))
    return poses_along(graph, find_forest(graph, every > 0.0, every, np.array([0])))


STARTS: dict[str, Callable[[PoseGraphProblem], Array]] = {
    "odometry": lambda problem: problem.guess,
    "least squares": _least_squares,
    "spanning tree": _tree,
}
METHODS: dict[str, Method] = {}
ORACLE = "correct edges alone"
"""What a method could do that knew the outliers: where this map is bad, no map is good."""
GTSAM: list[str] = []
"""The methods that need the package gtsam."""


@dataclass(frozen=True)
class Score:
    """What one run of one method was worth.

    ``ate`` is in metres, ``seconds`` are of CPU time, and ``solves`` counts linear solves for
    the poses; it is None for a method whose solves are not the library's.
    """

    precision: float
    recall: float
    ate: float
    seconds: float
    solves: int | None


def method(name: str, starts: Sequence[str] = ()) -> Callable[[Descent], Descent]:
    """Enter a function (problem, threshold, start) -> poses into the table.

    The start is dead reckoning. With ``starts``, keys of ``STARTS``, the function is entered
    once for each of them, as "name from start".
    """

    def enter(descend: Descent) -> Descent:
        for start in starts:
            METHODS[f"{name} from {start}"] = partial(_from, start, descend)
        if not starts:
            METHODS[name] = partial(_from, "odometry", descend)
        return descend

    return enter


def _from(start: str, descend: Descent, problem: PoseGraphProblem, c: float) -> Array:
    return descend(problem, c, STARTS[start](problem))


@method(ORACLE)
def correct_edges(problem: PoseGraphProblem, c: float, x0: Array) -> Array:
    """Solve by least squares; ``run`` gives this method the graph without its outliers."""
    return _least_squares(problem)


@method("dead reckoning")
def dead_reckoning(problem: PoseGraphProblem, c: float, x0: Array) -> Array:
    """Use no closure."""
    return x0


@method("least squares")
def least_squares(problem: PoseGraphProblem, c: float, x0: Array) -> Array:
    """Trust all closures."""
    return _least_squares(problem)


@method("IRLS-GM", tuple(STARTS))
def irls_gm(problem: PoseGraphProblem, c: float, x0: Array) -> Array:
    """Minimise Geman–McClure without graduation: closed-form switches with λ = c²."""
    return irls(problem, kernels.geman_mcclure(c), x0, tol=TOL, max_iterations=SOLVES).x


@method("GNC-GM", tuple(STARTS))
def gnc_gm(problem: PoseGraphProblem, c: float, x0: Array) -> Array:
    """Minimise Geman–McClure with graduation, then without: its last step is not at a minimum."""
    return irls_gm(problem, c, gnc(problem, c, "gm", x0, factor=FACTOR, tol=TOL).x)


@method("IRLS-TLS", tuple(STARTS))
def irls_tls(problem: PoseGraphProblem, c: float, x0: Array) -> Array:
    """Minimise TLS without graduation."""
    return irls(problem, kernels.tls(c), x0, tol=TOL, max_iterations=SOLVES).x


@method("GNC-TLS", tuple(STARTS))
def gnc_tls(problem: PoseGraphProblem, c: float, x0: Array) -> Array:
    """Minimise TLS with graduation."""
    return gnc(problem, c, "tls", x0, factor=FACTOR, tol=TOL).x


@method("IRLS-Cauchy", ("odometry", "least squares"))
def irls_cauchy(problem: PoseGraphProblem, c: float, x0: Array) -> Array:
    """Minimise Cauchy's cost, with a constant of its own."""
    kernel = kernels.cauchy(CAUCHY[problem.graph.group.DOF])
    return irls(problem, kernel, x0, tol=TOL, max_iterations=SOLVES).x


@method("SC, jointly")
def sc_jointly(problem: PoseGraphProblem, c: float, x0: Array) -> Array:
    """Move poses and switches together, as the paper does, λ = c²."""
    return joint_switchable(problem, c**2, x0, tol=TOL, max_iterations=SOLVES).x


@method("DCS")
def dcs(problem: PoseGraphProblem, c: float, x0: Array) -> Array:
    """Reweight with the squared scaling, Φ = c²."""
    return irls(problem, kernels.dcs(c), x0, tol=TOL, max_iterations=SOLVES).x


@method("max-mixture")
def mixture(problem: PoseGraphProblem, c: float, x0: Array) -> Array:
    """Let a null hypothesis, wide enough for any outlier on the map, stand beside each closure."""
    return max_mixture(problem, *MIXTURE, x0=x0, tol=TOL, max_iterations=SOLVES).x


@method("PCM + GNC-TLS")
def pcm_gnc(problem: PoseGraphProblem, c: float, x0: Array) -> Array:
    """Run the pipeline of chapter 8, certificate included; it begins at dead reckoning."""
    return pipeline.solve(problem.graph, PROBABILITY).poses


@method("rs.solve")
def whole(problem: PoseGraphProblem, c: float, x0: Array) -> Array:
    """Run the library's back-end: several starts, the noise that is found, and a certificate."""
    return solve(problem.graph, PROBABILITY).poses


def _gtsam(loss: str, problem: PoseGraphProblem, c: float, x0: Array) -> Array:
    """Run GTSAM's optimiser with its defaults, the odometry and the prior known inliers."""
    factors, values = gtsam_graph.to_gtsam(problem.graph, x0)
    prior = len(problem.graph.edges)
    known = [*np.flatnonzero(problem.trusted).tolist(), prior]
    parameters = gtsam.GncGaussNewtonParams(gtsam.GaussNewtonParams())
    parameters.setLossType(getattr(gtsam.GncLossType, loss))
    parameters.setKnownInliers(known)
    optimiser = gtsam.GncGaussNewtonOptimizer(factors, values, parameters)
    try:
        return gtsam_graph.poses_from_gtsam(optimiser.optimize(), problem.graph)
    except RuntimeError as error:
        raise NotConverged(str(error)) from None


for _loss in ("TLS", "GM"):
    GTSAM.append(f"GTSAM's GNC-{_loss}")
    method(GTSAM[-1])(partial(_gtsam, _loss))


def available() -> list[str]:
    """Return the names of the methods that run on this machine."""
    return [name for name in METHODS if name not in GTSAM or gtsam is not None]


def run(name: str, spoiled: PoseGraph, is_outlier: Mask, reference: Array, steps: int) -> Score:
    """Return the score of one method on one spoiled graph.

    ``is_outlier`` ``(m,)`` marks the wrong closures; ``reference`` are the poses to come to.

    Raises:
        NotConverged: the method did not come to rest.
        Underdetermined: its weights left a pose loose.
    """
    c = chi_square_threshold(PROBABILITY, spoiled.group.DOF)
    with counted() as count:
        given = pose_graph.select(spoiled, ~is_outlier) if name == ORACLE else spoiled
        problem = Budgeted(given, count, steps)
        began = time.process_time()
        poses = METHODS[name](problem, c)
        seconds = time.process_time() - began
    kept = pose_graph.residual_norms(spoiled, poses) <= c
    closures = ~spoiled.is_odometry
    precision, recall = precision_recall(kept[closures], ~is_outlier[closures])
    solves = None if name in GTSAM else count.solves
    return Score(precision, recall, ate(poses, reference), seconds, solves)


@dataclass
class Count:
    """How many linear systems for the poses have been solved."""

    solves: int = 0


@contextmanager
def counted() -> Iterator[Count]:
    """Count the linear solves of the library while the context lasts."""
    count, original = Count(), NormalEquations.minimise

    def minimise(self: NormalEquations, *arguments: Array | None) -> Array:
        count.solves += 1
        return original(self, *arguments)  # type: ignore[arg-type]

    NormalEquations.minimise = minimise  # type: ignore[method-assign, assignment]
    try:
        yield count
    finally:
        NormalEquations.minimise = original  # type: ignore[method-assign]


class Budgeted(PoseGraphProblem):
    """A problem that moves no pose any more once ``SOLVES`` linear solves are spent.

    A loop that reweights is then at rest.
    """

    def __init__(self, graph: PoseGraph, count: Count, steps: int = STEPS) -> None:
        super().__init__(graph, steps=steps)
        self._count = count

    def solve(self, weights: Array, x: Array) -> Array:
        """Return the poses of the next Gauss–Newton step, or ``x`` if the budget is spent."""
        return x if self._count.solves >= SOLVES else super().solve(weights, x)
