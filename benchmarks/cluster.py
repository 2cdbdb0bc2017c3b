"""How many submissions an hour, on one process, on several, and on a Dask cluster's workers?

The sample class is graded each way in one run, on this machine, hidden tests included. A cluster
grades it once and then, started anew, twice: the second time its workers are warm. Its CPU is the
difference of both runs. From its seconds follows how many cores grade ten thousand submissions
in a night.

    python -m benchmarks.cluster
"""

from __future__ import annotations

import argparse
import math
import os
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

from robust_slam_autograder import cli
from robust_slam_autograder.sandbox import BACK_ENDS

from benchmarks.cost import Cost, measure
from tests import sample_class

ROOT = Path(__file__).parents[1]
SOLUTIONS = ROOT / "solutions"
WORKERS = 2
PLANNED = 10_000
"""Submissions in a night."""
NIGHT_HOURS = 8.0
SECONDS_NAME = "seconds"
LIMIT_SECONDS = 120.0
"""What a submission may take at most, as most assignments have it."""


def grade(folders: Sequence[Path], *options: str) -> list[str]:
    """Return the grader's arguments for a class."""
    return ["--solutions", str(SOLUTIONS), "grade", *map(str, folders), "--seed", "1", *options]


def on_dask(rounds: int, out: Path, arguments: Sequence[str]) -> int:
    """Start a cluster, grade a class on it so many times, and note what the last time took."""
    from distributed import LocalCluster

    with LocalCluster(n_workers=WORKERS, threads_per_worker=1, dashboard_address=":0") as cluster:
        cluster.wait_for_workers(WORKERS)
        place = ["--scheduler", cluster.scheduler_address, "--out"]
        for n in range(rounds):
            start = time.perf_counter()
            status = cli.main([*arguments, *place, str(out / str(n))])
            (out / SECONDS_NAME).write_text(str(time.perf_counter() - start))
            if status != 0:
                return status
    return 0


def compare(root: Path, wall: str) -> None:
    """Measure all ways, one after the other, and print the table and the plan."""
    release = root / "release"
    _run("-m", "robust_slam_autograder.cli", "release", "--out", str(release))
    folders = sample_class.write(release, root / "submitted")
    print(f"{len(folders)} submissions, {wall}; load average before: {os.getloadavg()[0]:.1f}")
    print(f"{'':<32} {'seconds':>8} {'each':>8} {'each, CPU':>10} {'an hour':>8}", flush=True)
    for jobs in (1, WORKERS):
        out = root / f"local-{jobs}"
        command = grade(folders, "--sandbox", wall, "--jobs", str(jobs), "--out", str(out))
        name = f"{jobs} local process{'es' if jobs > 1 else ''}"
        tell(name, _run("-m", "robust_slam_autograder.cli", *command), len(folders))
    command = grade(folders, "--sandbox", wall)
    once, twice = (
        _run("-m", "benchmarks.cluster", "--dask", str(n), str(root / f"dask-{n}"), *command)
        for n in (1, 2)
    )
    tell(f"{WORKERS} Dask workers, first class", once, len(folders))
    seconds = float((root / "dask-2" / SECONDS_NAME).read_text())
    cost = Cost(seconds, twice.cpu and once.cpu and twice.cpu - once.cpu)
    tell(f"{WORKERS} Dask workers, next class", cost, len(folders))
    print(plan(WORKERS * cost.wall / len(folders)))


def _run(*arguments: str) -> Cost:
    return measure([sys.executable, *arguments], cwd=ROOT, env={"OPENBLAS_NUM_THREADS": "1"})


def tell(name: str, cost: Cost, submissions: int) -> None:
    """Print a line of the table."""
    cpu = "–" if cost.cpu is None else f"{cost.cpu / submissions:.2f}"
    each = cost.wall / submissions
    print(f"{name:<32} {cost.wall:8.1f} {each:8.2f} {cpu:>10} {3600 / each:8.0f}", flush=True)


def plan(seconds: float) -> str:
    """Say how many cores a night needs.

    Args:
        seconds: what a submission takes a worker.
    """
    cores = math.ceil(PLANNED * seconds / (NIGHT_HOURS * 3600))
    wanted = f"{cores} core{'s' * (cores > 1)} of this kind"
    hours = 100 * LIMIT_SECONDS / 3600
    return (
        f"{PLANNED:,} submissions like these, {seconds:.2f} s of a worker each: "
        f"{PLANNED * seconds / 3600:.1f} hours of one core, so {wanted} for a night of "
        f"{NIGHT_HOURS:.0f} hours.\n"
        f"Those that run into a limit are graded once more, one at a time on each machine: a "
        f"hundred that hang for {LIMIT_SECONDS:.0f} s take one machine {hours:.1f} hours more."
    )


def main() -> int:
    """Read the arguments; with ``--dask`` this is the process that is measured."""
    if sys.argv[1:2] == ["--dask"]:
        return on_dask(int(sys.argv[2]), Path(sys.argv[3]), sys.argv[4:])
    argparse.ArgumentParser(description="Throughput of the grader, and a plan.").parse_args()
    walls = [name for name, wall in BACK_ENDS.items() if wall.problem() is None]
    if not walls:
        sys.exit("No sandbox works here: see `autograder doctor`.")
    with tempfile.TemporaryDirectory(prefix="benchmark-") as folder:
        compare(Path(folder), walls[0])
    return 0


if __name__ == "__main__":
    sys.exit(main())
