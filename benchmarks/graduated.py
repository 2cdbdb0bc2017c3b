"""How fast is GNC? GNC-TLS on public graphs with spoiled closures, ours and GTSAM's side by side.

A share of the closures measures another place than it says. Both sides trust the odometry, begin
at dead reckoning, because a start from all closures is torn by the outliers, and take the 99 %
quantile of χ² for c²; GTSAM halves it, as it halves its costs.

Ours takes one Gauss–Newton step for each μ and goes on from there, by the adaptive schedule of
``gnc``, until the weights are 0 or 1 and the map is at rest. GTSAM's ``GncGaussNewtonOptimizer``
runs with its defaults: for each μ to the end, from the first poses again. Ratios are as in
``benchmarks.speed``, CPU times of GTSAM ÷ ours. Precision and recall are of the closures that are
kept, the ATE is against the optimum of the graph without outliers.

    python -m benchmarks.graduated
    python -m benchmarks.graduated --only M3500/30
"""

import os
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

# It is read when numpy is first imported.
os.environ["OPENBLAS_NUM_THREADS"] = "1"

import gtsam
import numpy as np
from robust_slam._arrays import Array, Mask
from robust_slam.descent import gauss_newton, start
from robust_slam.estimators import Result, chi_square_threshold, gnc
from robust_slam.files import gtsam_graph
from robust_slam.files.datasets import load
from robust_slam.graphs import PoseGraph, ate, precision_recall, spanning_tree, spoil_closures
from robust_slam.problems import PoseGraphProblem

from benchmarks.speed import OURS, Side, in_turns, ratio, show

SPOILED = ("intel", "M3500", "sphere2500")
PERCENT = (10, 30, 50)
SEED = 0
STEPS = 1
TOL = 1e-5
"""When a map is at rest: GTSAM's own number, for the relative fall of its cost."""


@dataclass(frozen=True, eq=False)
class World:
    """A spoiled graph, its outliers, the first poses, the scale, the map without outliers."""

    graph: PoseGraph
    is_outlier: Mask
    guess: Array
    c: float
    reference: Array


Found = tuple[Array, Mask]
"""The poses of a run, and the edges ``(m,)`` that it kept."""


def spoiled(name: str, percent: int) -> World:
    """Return a public graph with ``percent`` of its closures spoiled."""
    correct = load(name)
    reference = gauss_newton(correct, start.chordal(correct))
    rng = np.random.default_rng(SEED)
    graph, is_outlier = spoil_closures(correct, percent / 100.0, rng, poses=reference)
    c = chi_square_threshold(0.99, graph.group.DOF)
    return World(graph, is_outlier, spanning_tree(graph), c, reference)


def figure(name: str, percent: int) -> str:
    """Return what both sides spent on one world and found, and below it the ratio."""
    world = spoiled(name, percent)
    spent = in_turns([our_gnc(world), gtsam_gnc(world)])
    told = "; ".join(f"{side} {own} ({_score(world, own.answer)})" for side, own in spent.items())
    return f"  {told}\nratio gnc/{name}/{percent} {ratio(spent):.2f}"


def our_gnc(world: World) -> Side:
    """Return our side, with ``STEPS`` Gauss–Newton steps for each μ."""

    def run() -> Result[Array]:
        problem = PoseGraphProblem(world.graph, world.guess, steps=STEPS)
        return gnc(problem, world.c, x0=problem.guess, adaptive=True, tol=TOL)

    return Side(OURS, run, lambda result: (result.x, result.weights > 0.5))


def gtsam_gnc(world: World) -> Side:
    """Return GTSAM's side, with its defaults.

    Raises:
        RuntimeError: its thresholds are not c²/2, so that the sides would differ in c.
    """
    factors, values = gtsam_graph.to_gtsam(world.graph, world.guess)
    prior = len(world.graph.edges)
    known = [*np.flatnonzero(world.graph.is_odometry).tolist(), prior]

    def run() -> tuple[gtsam.GncGaussNewtonOptimizer, gtsam.Values]:
        parameters = gtsam.GncGaussNewtonParams(gtsam.GaussNewtonParams())
        parameters.setLossType(gtsam.GncLossType.TLS)
        parameters.setKnownInliers(known)
        optimiser = gtsam.GncGaussNewtonOptimizer(factors, values, parameters)
        return optimiser, optimiser.optimize()

    def read(answer: tuple[gtsam.GncGaussNewtonOptimizer, gtsam.Values]) -> Found:
        optimiser, last = answer
        if not np.allclose(optimiser.getInlierCostThresholds(), 0.5 * world.c**2):
            raise RuntimeError("GTSAM's thresholds are not c²/2")
        kept = np.asarray(optimiser.getWeights())[:prior] > 0.5
        return gtsam_graph.poses_from_gtsam(last, world.graph), kept

    return Side("GTSAM's GNC", run, read)


def _score(world: World, found: Found) -> str:
    (poses, kept), closures = found, ~world.graph.is_odometry
    precision, recall = precision_recall(kept[closures], ~world.is_outlier[closures])
    error = ate(poses, world.reference)
    return f"precision {precision:.4f}, recall {recall:.4f}, ATE {error:.3f} m"


FIGURES: dict[str, Callable[[], str]] = {
    f"{graph}/{percent}": partial(figure, graph, percent)
    for graph in SPOILED
    for percent in PERCENT
}

if __name__ == "__main__":
    sys.exit(show(FIGURES, __doc__))
