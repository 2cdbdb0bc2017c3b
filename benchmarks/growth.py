"""How the cost of a Gauss–Newton step grows with the map: seconds and memory against poses.

Each size is a walk through a town with as many correct closures as poses, and has a process of its
own, so that the largest memory is its own. The time of a step is the median of five at the
chordal start, the pattern known; the set-up, which finds it, and that start stand beside it.

    python -m benchmarks.growth
    python -m benchmarks.growth --out chapters/data/growth.csv
"""

import multiprocessing
import os
import time
from argparse import ArgumentParser, RawDescriptionHelpFormatter
from collections.abc import Iterator, Sequence
from dataclasses import astuple, dataclass, fields
from pathlib import Path
from statistics import median

# It is read when numpy is first imported.
os.environ["OPENBLAS_NUM_THREADS"] = "1"

import numpy as np
from robust_slam.descent import gauss_newton, start
from robust_slam.graphs import manhattan
from robust_slam.problems import PoseGraphProblem
from tqdm import tqdm

SIZES = (1_000, 3_000, 10_000, 30_000, 100_000)
SEED = 0
STEPS = 5


@dataclass(frozen=True)
class Size:
    """What one map costs.

    Attributes:
        poses: how many there are.
        closures: how many there are.
        start: CPU seconds of the chordal start.
        setup: CPU seconds of the first step, the pattern found for it, less ``step``.
        step: CPU seconds of a Gauss–Newton step.
        memory: the largest memory of the process, in MB.
        base: of it what Python, its modules and the solver take for a tiny map, in MB.
    """

    poses: int
    closures: int
    start: float
    setup: float
    step: float
    memory: float
    base: float


def measure(poses: int) -> Size:
    """Return what a map of so many poses costs; the memory is that of this process."""
    tiny, guess = manhattan(20, np.random.default_rng(SEED), closures=20)
    gauss_newton(tiny, guess)
    base = _largest_memory()
    graph, _ = manhattan(poses, np.random.default_rng(SEED), closures=poses)
    ones = np.ones(len(graph.edges))
    began = time.process_time()
    first = start.chordal(graph)
    started = time.process_time()
    problem = PoseGraphProblem(graph, first, steps=1)
    problem.solve(ones, first)
    ready = time.process_time()
    steps = []
    for _ in range(STEPS):
        before = time.process_time()
        problem.solve(ones, first)
        steps.append(time.process_time() - before)
    step = median(steps)
    setup = max(0.0, ready - started - step)
    return Size(poses, poses, started - began, setup, step, _largest_memory(), base)


def _largest_memory() -> float:
    """Return the most that this process has held so far, in MB.

    Linux tells: what ``getrusage`` says of a child begins with what its parent held.
    """
    status = Path("/proc/self/status").read_text(encoding="ascii")
    kilobytes = next(line.split()[1] for line in status.splitlines() if line.startswith("VmHWM"))
    return int(kilobytes) * 1024 / 1e6


def measured(sizes: Sequence[int]) -> Iterator[Size]:
    """Yield what each map costs, measured in a process of its own."""
    with multiprocessing.get_context("spawn").Pool(1, maxtasksperchild=1) as pool:
        yield from pool.imap(measure, sizes)


def table(sizes: Sequence[Size]) -> str:
    """Return the sizes as CSV, with a header of comments."""
    lines = [
        "# What a Gauss-Newton step costs on generated Manhattan graphs: CPU seconds and MB",
        "# python -m benchmarks.growth --out chapters/data/growth.csv",
        f"# numpy's default_rng({SEED}) for each graph, as many closures as poses",
        f"# {', '.join(field.name for field in fields(Size))}",
    ]
    rows = [", ".join(_number(value) for value in astuple(size)) for size in sizes]
    return "\n".join([*lines, *rows]) + "\n"


def _number(value: float) -> str:
    return str(value) if isinstance(value, int) else f"{value:.4g}"


def main() -> None:
    """Measure every size, and write the table if asked to."""
    parser = ArgumentParser(description=__doc__, formatter_class=RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, help="write the table to this file")
    wanted = parser.parse_args()
    sizes = []
    for size in tqdm(measured(SIZES), total=len(SIZES), unit="size"):
        sizes.append(size)
        tqdm.write(
            f"growth/{size.poses} start {size.start:.3g} s, set-up {size.setup:.3g} s, "
            f"step {size.step:.3g} s, memory {size.memory:.0f} MB"
        )
    if wanted.out is not None:
        wanted.out.write_text(table(sizes), encoding="utf-8")


if __name__ == "__main__":
    main()
