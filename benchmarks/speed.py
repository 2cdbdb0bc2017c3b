"""How fast is it? Gauss–Newton on the public graphs, ours and GTSAM's side by side.

Each figure is a ratio of CPU times, GTSAM's ÷ ours: above 1 we are faster. Wall clocks say little
on a shared machine; so both sides take turns in one run, each on one thread, and the median of
five times counts. Where one time exceeds twenty seconds, it stands alone.

All begin at the chordal start and take the same number of steps, after which the cost falls by
less than a share of 1e-5. GTSAM's graph and values are made before the clock runs, as our
``PoseGraph`` is; its optimiser, which orders the poses, is made under it, as our problem is, which
finds its pattern. Of its orderings COLAMD and METIS the quicker one counts. GTSAM holds pose 0
with a prior, which is satisfied at the start, so it takes the same steps: the final costs agree
to 1e-8.

    python -m benchmarks.speed
    python -m benchmarks.speed --only gn/intel
"""

import gc
import os
import sys
import time
from argparse import ArgumentParser, RawDescriptionHelpFormatter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from statistics import median
from typing import Any

# It is read when numpy is first imported.
os.environ["OPENBLAS_NUM_THREADS"] = "1"

import gtsam
import numpy as np
from robust_slam._arrays import Array
from robust_slam.descent import start
from robust_slam.files import gtsam_graph
from robust_slam.files.datasets import DatasetMissing, load
from robust_slam.graphs import PoseGraph, pose_graph
from robust_slam.problems import PoseGraphProblem
from tqdm import tqdm

GRAPHS = ("CSAIL", "intel", "M3500", "city10000", "sphere2500", "torus3D", "parking-garage")
RUNS = 5
LONG = 20.0
"""Seconds; what takes longer runs once."""
_ONE_THREAD, _NOISE = 1.05, 0.01
OURS, ORDERINGS = "ours", ("COLAMD", "METIS")
FALL, AGREE = 1e-5, 1e-8
_NEVER = -1e300
"""A fall of the cost that stops no descent, whatever the rounding."""


@dataclass(frozen=True)
class Side:
    """One way to do it.

    Attributes:
        name: what it is called.
        run: the task, under the clock.
        read: what is wanted of its answer; not under the clock.
    """

    name: str
    run: Callable[[], Any]
    read: Callable[[Any], Any]


@dataclass(frozen=True)
class Spent:
    """CPU seconds, the median of ``runs``, and what was wanted of the answer."""

    seconds: float
    answer: Any
    runs: int = 1

    def __str__(self) -> str:
        """Return the seconds for the reader, such as `41.2 ms` or `3.40 s (once)`."""
        short = self.seconds < 1.0
        number = f"{1e3 * self.seconds:.1f} ms" if short else f"{self.seconds:.2f} s"
        return number if self.runs > 1 else f"{number} (once)"


def spend(side: Side) -> Spent:
    """Run ``side`` once.

    Raises:
        RuntimeError: more than one thread was at work.
    """
    # What the last run left is not cleared away at this one's cost.
    gc.collect()
    all_threads, own = time.process_time(), time.thread_time()
    answer = side.run()
    all_threads, own = time.process_time() - all_threads, time.thread_time() - own
    if all_threads > _ONE_THREAD * own + _NOISE:
        raise RuntimeError(
            f"{side.name}: all threads took {all_threads:.3f} s, of which the first took "
            f"{own:.3f} s; let it run on one"
        )
    return Spent(all_threads, side.read(answer))


def in_turns(
    sides: Sequence[Side], measure: Callable[[Side], Spent] = spend, runs: int = RUNS
) -> dict[str, Spent]:
    """Return what each side takes, by its name: all run once, then all again, ``runs`` times.

    A side that takes longer than ``LONG`` seconds is not run again.
    """
    spent = {side.name: [measure(side)] for side in sides}
    for _ in range(runs - 1):
        for side in sides:
            if spent[side.name][0].seconds <= LONG:
                spent[side.name].append(measure(side))
    return {
        name: Spent(median(one.seconds for one in own), own[0].answer, len(own))
        for name, own in spent.items()
    }


def gauss_newton_figure(name: str) -> str:
    """Return what both sides spent on one graph, and below it the ratio.

    Raises:
        RuntimeError: the final costs do not agree.
    """
    graph = load(name)
    guess = start.chordal(graph)
    steps = steps_needed(graph, guess)
    theirs = (_gtsam_side(graph, guess, steps, each) for each in ORDERINGS)
    spent = in_turns([_our_side(graph, guess, steps), *theirs])
    costs = [each.answer for each in spent.values()]
    if max(costs) - min(costs) > AGREE * min(costs):
        raise RuntimeError(f"{name}: the final costs of {list(spent)} are {costs}")
    told = ", ".join(f"{side} {each}" for side, each in spent.items())
    return f"  {told}; {steps} steps, cost {costs[0]:.6f}\nratio gn/{name} {ratio(spent):.2f}"


def ratio(spent: Mapping[str, Spent]) -> float:
    """Return the seconds of the quickest of the other sides ÷ those of ``OURS``."""
    others = (own.seconds for side, own in spent.items() if side != OURS)
    return min(others) / spent[OURS].seconds


def steps_needed(graph: PoseGraph, guess: Array) -> int:
    """Return after how many steps from ``guess`` the cost falls by less than ``FALL``."""
    ones = np.ones(len(graph.edges))
    one_step = PoseGraphProblem(graph, guess, steps=1)
    poses, steps, before, cost = guess, 0, np.inf, pose_graph.cost(graph, guess)
    while before - cost >= FALL * before:
        poses, steps, before = one_step.solve(ones, poses), steps + 1, cost
        cost = pose_graph.cost(graph, poses)
    return steps


def _our_side(graph: PoseGraph, guess: Array, steps: int) -> Side:
    ones = np.ones(len(graph.edges))
    return Side(
        OURS,
        lambda: PoseGraphProblem(graph, guess, steps=steps).solve(ones, guess),
        partial(pose_graph.cost, graph),
    )


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


FIGURES: dict[str, Callable[[], str]] = {
    f"gn/{graph}": partial(gauss_newton_figure, graph) for graph in GRAPHS
}


def show(figures: Mapping[str, Callable[[], str]], about: str | None) -> int:
    """Print the figures that the command line asks for; return 1 where one could not be had."""
    parser = ArgumentParser(description=about, formatter_class=RawDescriptionHelpFormatter)
    known = sorted({*figures, *(name.partition("/")[0] for name in figures)})
    parser.add_argument("--only", nargs="+", default=known, choices=known, metavar="NAME")
    only = parser.parse_args().only
    names = [name for name in figures if {name, name.partition("/")[0]}.intersection(only)]
    missing = 0
    for name in tqdm(names, unit="figure"):
        try:
            told = figures[name]()
        except (RuntimeError, DatasetMissing) as error:
            told, missing = f"none for {name}: {error}", missing + 1
        tqdm.write(told)
        sys.stdout.flush()
    return 1 if missing else 0


if __name__ == "__main__":
    sys.exit(show(FIGURES, __doc__))
