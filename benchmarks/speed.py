"""How fast is it? Gauss–Newton on the public graphs, ours and GTSAM's side by side.

Each figure is a ratio of CPU times, GTSAM's ÷ ours: above 1 we are faster. Wall clocks say little
on a shared machine; so both sides take turns in one run, each on one thread, and the median of
five times counts. Where one time exceeds twenty seconds, it stands alone.

The library solves in two ways, by numpy alone and by the compiled factorisation, and chooses by
the number of edges; here each way is measured on every graph, in a line `ratio gn/GRAPH VALUE
numpy VALUE compiled`. What it takes to load the compiled one is the figure `kernels`.

All begin at the chordal start and take the same number of steps, after which the cost falls by
less than a share of 1e-5. GTSAM's graph and values are made before the clock runs, as our
``PoseGraph`` is; its optimiser, which orders the poses, is made under it, as our problem is, which
finds its pattern. Of its orderings COLAMD and METIS the quicker one counts. GTSAM holds pose 0
with a prior, which is satisfied at the start, so it takes the same steps: the final costs agree
to 1e-8.

    python -m benchmarks.speed
    python -m benchmarks.speed --only gn/intel
"""

from __future__ import annotations

import argparse
import gc
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, partial
from statistics import median
from typing import Any

# It is read when numpy is first imported.
os.environ["OPENBLAS_NUM_THREADS"] = "1"

import gtsam
import numpy as np
from robust_slam._arrays import Array
from robust_slam.descent import gauss_newton, start
from robust_slam.descent.sparse.choice import COMPILED_FROM, LARGE, has_numba
from robust_slam.graphs import PoseGraph, gtsam_graph, pose_graph
from robust_slam.graphs.datasets import DatasetMissing, load
from robust_slam.graphs.generate import manhattan, sphere
from robust_slam.problems import PoseGraphProblem
from tqdm import tqdm

GRAPHS = ("CSAIL", "intel", "M3500", "city10000", "sphere2500", "torus3D", "parking-garage")
RUNS = 5
LONG = 20.0
"""Seconds; what takes longer runs once."""
_ONE_THREAD, _NOISE = 1.05, 0.01
ORDERINGS = ("COLAMD", "METIS")
FALL, AGREE = 1e-5, 1e-8
_NEVER = -1e300
"""A fall of the cost that stops no descent, whatever the rounding."""
EDGES = {"numpy": sys.maxsize, "compiled": 0}
"""From how many edges on the factorisation is the compiled one, for each way."""
_FIRST_USE = """
import time
from benchmarks import speed
before = time.process_time()
speed.use_kernels()
print(time.process_time() - before)
"""


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
    """Return what both sides spent on one graph, and below it the ratios.

    Raises:
        RuntimeError: the final costs do not agree.
    """
    graph = load(name)
    guess = start.chordal(graph)
    steps = steps_needed(graph, guess)
    mine = our_sides(
        lambda: PoseGraphProblem(graph, guess, steps=steps).solve(
            np.ones(len(graph.edges)), guess
        ),
        partial(pose_graph.cost, graph),
    )
    spent = in_turns([*mine, *(_gtsam_side(graph, guess, steps, each) for each in ORDERINGS)])
    costs = [each.answer for each in spent.values()]
    if max(costs) - min(costs) > AGREE * min(costs):
        raise RuntimeError(f"{name}: the final costs of {list(spent)} are {costs}")
    ours = {side.name: spent.pop(side.name) for side in mine}
    told = ", ".join(f"{side} {each}" for side, each in {**spent, **ours}.items())
    ratio = ratios(min(each.seconds for each in spent.values()), ours)
    return f"  {told}; {steps} steps, cost {costs[0]:.6f}\nratio gn/{name} {ratio}"


def ratios(other: float, ours: dict[str, Spent]) -> str:
    """Return the ``other`` side's seconds ÷ those of each of our ways."""
    return " ".join(f"{other / spent.seconds:.2f} {way}" for way, spent in ours.items())


def steps_needed(graph: PoseGraph, guess: Array) -> int:
    """Return after how many steps from ``guess`` the cost falls by less than ``FALL``."""
    ones = np.ones(len(graph.edges))
    one_step = PoseGraphProblem(graph, guess, steps=1)
    poses, steps, before, cost = guess, 0, np.inf, pose_graph.cost(graph, guess)
    while before - cost >= FALL * before:
        poses, steps, before = one_step.solve(ones, poses), steps + 1, cost
        cost = pose_graph.cost(graph, poses)
    return steps


def our_sides(run: Callable[[], Any], read: Callable[[Any], Any]) -> list[Side]:
    """Return a side for each way that there is: ``numpy``, and ``compiled`` with numba."""
    if has_numba():
        use_kernels()
    return [Side(way, by(way, run), read) for way in (EDGES if has_numba() else ["numpy"])]


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


def by(way: str, run: Callable[[], Any]) -> Callable[[], Any]:
    """Return a task that is done by one of the ways in ``EDGES``."""

    def chosen() -> Any:  # noqa: ANN401
        os.environ[COMPILED_FROM] = str(EDGES[way])
        try:
            return run()
        finally:
            del os.environ[COMPILED_FROM]

    return chosen


@cache
def use_kernels() -> None:
    """Use every kernel once, on small graphs in the plane and in space."""
    for make in (manhattan, sphere):
        graph, _ = make(50, np.random.default_rng(0), closures=20)
        by("compiled", lambda graph=graph: gauss_newton(graph, start.chordal(graph)))()


def kernels_figure() -> str:
    """Return the CPU seconds of the first use of the kernels, compiled anew and from disk."""
    if not has_numba():
        return "kernels none: numba is not installed"
    with tempfile.TemporaryDirectory() as folder:
        environment = {**os.environ, "NUMBA_CACHE_DIR": folder}
        command = [sys.executable, "-c", _FIRST_USE]
        first, later = (
            float(subprocess.run(command, env=environment, capture_output=True, check=True).stdout)
            for _ in range(2)
        )
    return (
        f"kernels are loaded in {later:.2f} s once per process, and compiled in {first:.1f} s "
        f"once per machine; used from {LARGE:,} edges"
    )


FIGURES: dict[str, Callable[[], str]] = {
    "kernels": kernels_figure,
    **{f"gn/{graph}": partial(gauss_newton_figure, graph) for graph in GRAPHS},
}


def show(figures: Mapping[str, Callable[[], str]], about: str | None) -> int:
    """Print the figures that the command line asks for; return 1 where one could not be had."""
    parser = argparse.ArgumentParser(
        description=about, formatter_class=argparse.RawDescriptionHelpFormatter
    )
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
