"""The methods that are compared on graphs with wrong closures, and the one way to score them.

All trust the odometry, take one Gauss–Newton step for each set of weights, and have the same
number of linear solves. Closures count as kept when their whitened residual at a method's map
is within the 99 % threshold, with deviations that are true: the same test for all.

To enter a method, write a function (problem, threshold, start) -> poses under ``@method`` with
its name. ``python -m benchmarks.sweep`` then runs it, and it alone, on every graph.
"""

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np
from robust_slam._arrays import Array, Mask
from robust_slam.certificates import Verdict
from robust_slam.consistency import pcm
from robust_slam.descent import covariance
from robust_slam.descent.minimise import damped, last
from robust_slam.descent.normal_equations import NormalEquations
from robust_slam.errors import NotConverged, Underdetermined
from robust_slam.estimators import chi_square_threshold, gnc, irls, kernels, max_mixture
from robust_slam.estimators.switches import joint_switchable
from robust_slam.files import gtsam_graph
from robust_slam.graphs import PoseGraph, ate, nees, pose_graph, precision_recall
from robust_slam.graphs.odometry import find_forest, poses_along
from robust_slam.problems import PoseGraphProblem
from robust_slam.solver import Support, solve
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
MATCHED = 100.0
"""Max-mixture whose mode changes at c: how much wider an outlier spreads."""
RTABMAP = 3.0
"""RTAB-Map: an error of so many deviations, of any edge, undoes the newest closures."""
KIMERA = 5.0
"""Kimera-RPGO: the threshold of a pair of closures, on the norm."""
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
    "matched mixture": MATCHED,
    "RTAB-Map": RTABMAP,
    "Kimera-RPGO": KIMERA,
}
"""What the results depend on besides the code."""


class Found(NamedTuple):
    """What a method that judges itself returns: a map, and what it says about it.

    ``graph`` has the deviations that the method found, ``kept`` ``(m,)`` marks the edges it
    used, ``certified`` tells whether it calls the map optimal, None if it never does, and
    ``flagged`` whether it warns.
    """

    poses: Array
    graph: PoseGraph
    kept: Mask
    certified: bool | None = None
    flagged: bool = False


@dataclass(frozen=True, eq=False)
class Made:
    """A world that methods answer for.

    ``graph`` is what a method gets, ``is_outlier`` ``(m,)`` marks its wrong closures, and
    ``reference`` are the poses to come to: the truth, or with ``is_truth`` False the optimum
    without outliers. ``honest`` is the graph with deviations that are true of every inlier and
    every odometry edge.
    """

    graph: PoseGraph
    is_outlier: Mask
    reference: Array
    honest: PoseGraph
    is_truth: bool


Descent = Callable[[PoseGraphProblem, float, Array], "Array | Found"]
Method = Callable[[PoseGraphProblem, float], "Array | Found"]


def _least_squares(problem: PoseGraphProblem) -> Array:
    """Return the poses that Levenberg–Marquardt reaches with all weights 1."""
    ones = np.ones(len(problem.graph.edges))
    here = NormalEquations(problem.graph).start(problem.guess, ones)
    return last(damped(here, START_TOL, START_SOLVES)).here.poses


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
"""What a method could do that knew the outliers."""
SOLVER, GNC = "rs.solve", "GNC-TLS from odometry"
"""The method that others are paired with, and the one whose CPU time is the unit."""
FIRST: list[str] = []
"""The methods that begin at the odometry, or at a start of their own."""
GTSAM: list[str] = []
"""The methods that need the package gtsam."""


@dataclass(frozen=True)
class Score:
    """What one run of one method was worth.

    ``ate`` is in metres, ``seconds`` are of CPU time, and ``solves`` counts linear solves for
    the poses; it is None for a method whose solves are not the library's. ``outliers`` are
    those of the ``wrong`` closures that were kept. ``nees`` is the squared error of the last
    pose in units of the covariance that the method's edges give it, for each degree of freedom,
    and None where the truth is not known. ``assured`` tells whether the method calls its map
    optimal and does not warn, ``flagged`` whether it warns; both are None for a method that
    says nothing.
    """

    precision: float
    recall: float
    ate: float
    seconds: float
    solves: int | None
    outliers: int = 0
    wrong: int = 0
    nees: float | None = None
    assured: bool | None = None
    flagged: bool | None = None


def method(name: str, starts: Sequence[str] = ()) -> Callable[[Descent], Descent]:
    """Enter a function (problem, threshold, start) -> poses into the table.

    The start is dead reckoning. With ``starts``, keys of ``STARTS``, the function is entered
    once for each of them, as "name from start".
    """

    def enter(descend: Descent) -> Descent:
        for start in starts:
            METHODS[f"{name} from {start}"] = partial(_from, start, descend)
        FIRST.append(f"{name} from odometry" if starts else name)
        if not starts:
            METHODS[name] = partial(_from, "odometry", descend)
        return descend

    return enter


def _from(start: str, descend: Descent, problem: PoseGraphProblem, c: float) -> Array | Found:
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


@method("max-mixture, matched")
def matched_mixture(problem: PoseGraphProblem, c: float, x0: Array) -> Array:
    """Choose the probability of an inlier such that the mode changes at c, as for the others."""
    offset = 0.5 * c**2 * (1.0 - MATCHED**-2)
    odds = np.exp(offset - problem.graph.group.DOF * np.log(MATCHED))
    probability = float(odds / (1.0 + odds))
    return max_mixture(problem, probability, MATCHED, x0=x0, tol=TOL, max_iterations=SOLVES).x


@method("DCS, then TLS")
def dcs_tls(problem: PoseGraphProblem, c: float, x0: Array) -> Array:
    """Let truncated least squares decide from where DCS comes to rest."""
    return irls_tls(problem, c, dcs(problem, c, x0))


@method("RTAB-Map's rule")
def rtabmap(problem: PoseGraphProblem, c: float, x0: Array) -> Array:
    """Add closure after closure, and undo it if an error of any edge exceeds three deviations.

    Source: RTAB-Map's parameter for the largest error of a graph, by its documentation.
    """
    graph, used, poses = problem.graph, problem.graph.is_odometry.copy(), x0
    deviations = 1.0 / np.sqrt(np.diagonal(graph.information, axis1=1, axis2=2))
    closures = np.flatnonzero(~graph.is_odometry)
    equations = NormalEquations(graph)
    for k in closures[np.argsort(graph.edges[closures].max(axis=1), kind="stable")]:
        used[k] = True
        here = equations.start(poses, used.astype(float))
        tried = last(damped(here, START_TOL, _EACH)).here.poses
        worst = np.abs(pose_graph.residuals(graph, tried)) / deviations
        if worst[used].max() > RTABMAP:
            used[k] = False
        else:
            poses = tried
    return poses


_EACH = 3
"""Solves after each closure of RTAB-Map's rule, which has a map close by."""


@method("Kimera-RPGO")
def kimera(problem: PoseGraphProblem, c: float, x0: Array) -> Array:
    """Keep a largest set of closures that agree in pairs, then solve by least squares.

    Source: the default of its parameter lc_threshold. Its set is found by a heuristic, and here
    exactly; it also tests each closure against the odometry, with twice the threshold.
    """
    kept = pcm(problem.graph, KIMERA).kept
    return _least_squares(PoseGraphProblem(pose_graph.select(problem.graph, kept), x0))


@method("PCM + GNC-TLS")
def pcm_gnc(problem: PoseGraphProblem, c: float, x0: Array) -> Found:
    """Run the pipeline of chapter 8, certificate included; it begins at dead reckoning."""
    solved = pipeline.solve(problem.graph, PROBABILITY)
    certified = solved.certificate.verdict is Verdict.CERTIFIED
    return Found(solved.poses, problem.graph, solved.kept, certified, flagged=False)


@method(SOLVER)
def whole(problem: PoseGraphProblem, c: float, x0: Array) -> Found:
    """Run the library's back-end: several starts, the noise that is found, and a certificate."""
    answer = solve(problem.graph, PROBABILITY)
    certified = answer.certificate.verdict is Verdict.CERTIFIED
    flagged = answer.support is not Support.UNIQUE
    return Found(answer.poses, answer.precise, answer.kept, certified, flagged)


def _gtsam(loss: str, scheduler: str, problem: PoseGraphProblem, c: float, x0: Array) -> Array:
    """Run GTSAM's optimiser with its defaults, the odometry and the prior known inliers."""
    factors, values = gtsam_graph.to_gtsam(problem.graph, x0)
    prior = len(problem.graph.edges)
    known = [*np.flatnonzero(problem.trusted).tolist(), prior]
    parameters = gtsam.GncGaussNewtonParams(gtsam.GaussNewtonParams())
    parameters.setLossType(getattr(gtsam.GncLossType, loss))
    parameters.setScheduler(getattr(gtsam.GncScheduler, scheduler))
    parameters.setKnownInliers(known)
    optimiser = gtsam.GncGaussNewtonOptimizer(factors, values, parameters)
    try:
        return gtsam_graph.poses_from_gtsam(optimiser.optimize(), problem.graph)
    except RuntimeError as error:
        raise NotConverged(str(error)) from None


for _loss, _scheduler in (("TLS", "Linear"), ("GM", "Linear"), ("TLS", "SuperLinear")):
    _suffix = "" if _scheduler == "Linear" else f", {_scheduler}"
    GTSAM.append(f"GTSAM's GNC-{_loss}{_suffix}")
    method(GTSAM[-1])(partial(_gtsam, _loss, _scheduler))


CONTESTED = (ORACLE, GNC, "DCS, then TLS", "Kimera-RPGO", SOLVER, GTSAM[0])
"""The methods that answer for the worlds of tiers G to J."""


def available() -> list[str]:
    """Return the names of the methods that run on this machine."""
    return [name for name in METHODS if name not in GTSAM or gtsam is not None]


def run(name: str, world: Made) -> Score:
    """Return the score of one method on one spoiled graph.

    Raises:
        NotConverged: the method did not come to rest.
        Underdetermined: its weights left a pose loose.
    """
    c = chi_square_threshold(PROBABILITY, world.graph.group.DOF)
    with counted() as count:
        correct = pose_graph.select(world.honest, ~world.is_outlier)
        problem = Budgeted(correct if name == ORACLE else world.graph, count)
        began = time.process_time()
        found = METHODS[name](problem, c)
        seconds = time.process_time() - began
        solves = None if name in GTSAM else count.solves
    return score(world, judged(found, problem.graph, c), seconds, solves)


def score(world: Made, found: Found, seconds: float, solves: int | None = None) -> Score:
    """Return what a map is worth that took ``seconds`` of CPU time and ``solves``."""
    c = chi_square_threshold(PROBABILITY, world.graph.group.DOF)
    kept = pose_graph.residual_norms(world.honest, found.poses) <= c
    closures = ~world.graph.is_odometry
    precision, recall = precision_recall(kept[closures], ~world.is_outlier[closures])
    judges = found.certified is not None
    return Score(
        precision,
        recall,
        ate(found.poses, world.reference),
        seconds,
        solves,
        outliers=int(np.sum(kept & closures & world.is_outlier)),
        wrong=int(world.is_outlier.sum()),
        nees=last_nees(found, world.reference) if world.is_truth else None,
        assured=bool(found.certified and not found.flagged) if judges else None,
        flagged=found.flagged if judges else None,
    )


def judged(found: Array | Found, graph: PoseGraph, c: float) -> Found:
    """Return what a method found; one that returns poses alone keeps closures up to ``c``."""
    if isinstance(found, Found):
        return found
    kept = graph.is_odometry | (pose_graph.residual_norms(graph, found) <= c)
    return Found(found, graph, kept)


def last_nees(found: Found, truth: Array) -> float | None:
    """Return the NEES of the last pose for each degree of freedom, with the whole map ``truth``.

    It is None where the kept edges do not determine the map.

    Source: Bar-Shalom, Li and Kirubarajan 2001, section 5.4.
    """
    last = len(truth) - 1
    try:
        spread = covariance(found.graph, found.poses, last, found.kept.astype(np.float64))
    except Underdetermined:
        return None
    return float(nees(found.poses, truth, last, spread)) / found.graph.group.DOF


@dataclass
class Count:
    """How many linear systems for the poses have been solved."""

    solves: int = 0


@contextmanager
def counted() -> Iterator[Count]:
    """Count the linear solves of the library while the context lasts."""
    count, original = Count(), NormalEquations.damped_step

    def step(
        self: NormalEquations, hessian: Array, gradient: Array, damping: float
    ) -> tuple[Array, float]:
        count.solves += 1
        return original(self, hessian, gradient, damping)

    NormalEquations.damped_step = step  # type: ignore[assignment, method-assign]
    try:
        yield count
    finally:
        NormalEquations.damped_step = original  # type: ignore[method-assign]


class Budgeted(PoseGraphProblem):
    """A problem that moves no pose any more once ``SOLVES`` linear solves are spent.

    A loop that reweights is then at rest.
    """

    def __init__(self, graph: PoseGraph, count: Count) -> None:
        super().__init__(graph, steps=STEPS)
        self._count = count

    def solve(self, weights: Array, x: Array) -> Array:
        """Return the poses of the next Gauss–Newton step, or ``x`` if the budget is spent."""
        return x if self._count.solves >= SOLVES else super().solve(weights, x)
