"""Which estimator sees through wrong closures? One public graph, many seeds, one table.

Each seed adds random wrong closures to the graph until they are the asked share of all
closures. The reference is the optimum without them. ``methods`` says how each method runs and
how it is scored.

    python -m benchmarks.wrong_closures --graph intel --share 0.3 --seeds 10
"""

from __future__ import annotations

import argparse

import numpy as np
from robust_slam.descent import gauss_newton, start
from robust_slam.graphs import add_random_closures
from robust_slam.graphs.datasets import load
from tqdm import tqdm

from benchmarks.methods import STEPS, Score, available, run


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--graph", default="intel")
    parser.add_argument("--share", type=float, default=0.3)
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--steps", type=int, default=STEPS)
    wanted = parser.parse_args()
    graph = load(wanted.graph)
    reference = gauss_newton(graph, start.chordal(graph))
    correct = int(np.sum(~graph.is_odometry))
    count = round(correct * wanted.share / (1.0 - wanted.share))
    worlds = [
        add_random_closures(graph, count, np.random.default_rng(seed), poses=reference)
        for seed in range(wanted.seeds)
    ]
    scores: dict[str, list[Score]] = {name: [] for name in available()}
    jobs = [(name, *world) for world in worlds for name in scores]
    for name, spoiled, is_outlier in tqdm(jobs, unit="solve"):
        scores[name].append(run(name, spoiled, is_outlier, reference, wanted.steps))
    print(f"{wanted.graph}: {correct} correct and {count} wrong closures, {wanted.seeds} seeds")
    print("| method | precision | recall | ATE mean (m) | ATE worst (m) | CPU s |")
    print("|---|---|---|---|---|---|")
    for name, runs in scores.items():
        print(row(name, runs))


def row(name: str, runs: list[Score]) -> str:
    """Return a method's line of the table: means, and the worst trajectory error."""
    errors = [one.ate for one in runs]
    return (
        f"| {name} | {np.mean([one.precision for one in runs]):.4f} "
        f"| {np.mean([one.recall for one in runs]):.4f} | {np.mean(errors):.4f} "
        f"| {max(errors):.4f} | {np.median([one.seconds for one in runs]):.2f} |"
    )


if __name__ == "__main__":
    main()
