"""Gauss–Newton on the public graphs, against GTSAM's.

Both begin at the chordal start and take the same number of steps, after which the cost falls
by less than a share of 1e-5. GTSAM's graph and values are made before the clock runs, as our
``PoseGraph`` is; its optimiser, which orders the poses, is made under it, as our problem is,
which finds its pattern. Of its orderings COLAMD and METIS the quicker one counts.

GTSAM holds pose 0 with a prior, which is satisfied at the start, so it takes the same steps:
the final costs agree to 1e-8.
"""

from __future__ import annotations

import gtsam
import numpy as np
from robust_slam._arrays import Array
from robust_slam.descent import start
from robust_slam.graphs import PoseGraph, gtsam_graph, pose_graph
from robust_slam.graphs.datasets import load
from robust_slam.problems import PoseGraphProblem

from benchmarks.speed.clock import Figure, Side, in_turns
from benchmarks.speed.ways import our_sides

ORDERINGS = ("COLAMD", "METIS")
FALL = 1e-5
AGREE = 1e-8
_NEVER = -1e300
"""A fall of the cost that stops no descent, whatever the rounding."""


def measure(name: str) -> Figure:
    """Return the figure of one graph.

    Raises:
        RuntimeError: the final costs do not agree.
    """
    graph = load(name)
    guess = start.chordal(graph)
    steps = steps_needed(graph, guess)
    mine = _our_sides(graph, guess, steps)
    spent = in_turns([*mine, *(_gtsam_side(graph, guess, steps, each) for each in ORDERINGS)])
    costs = [each.answer for each in spent.values()]
    if max(costs) - min(costs) > AGREE * min(costs):
        raise RuntimeError(f"{name}: the final costs of {list(spent)} are {costs}")
    ours = {side.name: spent.pop(side.name) for side in mine}
    told = ", ".join(f"{side} {each}" for side, each in {**spent, **ours}.items())
    other = min(spent.values(), key=lambda each: each.seconds)
    return Figure(other, ours, f"{told}; {steps} steps, cost {costs[0]:.6f}")


def steps_needed(graph: PoseGraph, guess: Array) -> int:
    """Return after how many steps from ``guess`` the cost falls by less than ``FALL``."""
    ones = np.ones(len(graph.edges))
    one_step = PoseGraphProblem(graph, guess, steps=1)
    poses, steps, before, cost = guess, 0, np.inf, pose_graph.cost(graph, guess)
    while before - cost >= FALL * before:
        poses, steps, before = one_step.solve(ones, poses), steps + 1, cost
        cost = pose_graph.cost(graph, poses)
    return steps


def _our_sides(graph: PoseGraph, guess: Array, steps: int) -> list[Side]:
    def run() -> Array:
        ones = np.ones(len(graph.edges))
        return PoseGraphProblem(graph, guess, steps=steps).solve(ones, guess)

    return our_sides(run, lambda poses: pose_graph.cost(graph, poses))


def _gtsam_side(graph: PoseGraph, guess: Array, steps: int, ordering: str) -> Side:
    factors, values = gtsam_graph.to_gtsam(graph, guess)

    def run() -> gtsam.Values:
        parameters = gtsam.GaussNewtonParams()
        parameters.setOrderingType(ordering)
        parameters.setMaxIterations(steps)
        parameters.setRelativeErrorTol(_NEVER)
        parameters.setAbsoluteErrorTol(_NEVER)
        return gtsam.GaussNewtonOptimizer(factors, values, parameters).optimize()

    return Side(f"GTSAM {ordering}", run, factors.error)
