"""How long a map waits for each pose while it grows: ``rs.GrowingMap`` beside GTSAM's iSAM2.

The edges of M3500 arrive by their larger pose, and each pose is one call. iSAM2, which trusts all
closures, gets the graph as it is; ours gets it as it is and with a tenth of outliers, at their
places in time. Both sides run in one process on one thread; a time is the CPU time of one call.
iSAM2 factorises by QR, because with its default Cholesky it stops at pose 695.

    python -m benchmarks.incremental
    python -m benchmarks.incremental --every 250
"""

import os
import time
from argparse import ArgumentParser, RawDescriptionHelpFormatter
from collections.abc import Iterator

# It is read when numpy is first imported.
os.environ["OPENBLAS_NUM_THREADS"] = "1"

import gtsam
import numpy as np
from robust_slam import GrowingMap, PoseGraph, load, solve
from robust_slam._arrays import Array, Indices, Mask
from robust_slam.descent import gauss_newton, start
from robust_slam.files import gtsam_graph
from robust_slam.graphs import add_random_closures, dead_reckoning
from robust_slam.graphs.pose_graph import ROWS
from tqdm import tqdm

NAME = "M3500"
SHARE = 0.1
"""Outliers for each closure."""
SEED = 0
RELINEARISED = 0.1
"""iSAM2's default: the change of a variable, in m or rad, that linearises it again …"""
SKIPPED = 10
"""… looked for at every so many poses, its default too."""


def arrivals(graph: PoseGraph) -> list[Indices]:
    """Return the edges that arrive with each pose, from pose 1 on."""
    last = graph.edges.max(axis=1)
    order = np.argsort(last, kind="stable")
    return np.split(order, np.searchsorted(last[order], np.arange(2, graph.n)))


def grow(graph: PoseGraph) -> Iterator[tuple[int, float, GrowingMap]]:
    """Yield each pose from pose 2 on, the CPU seconds that it took, and the map so far."""

    def rows(chosen: Indices) -> dict[str, Array]:
        return {name: getattr(graph, name)[chosen] for name in ROWS}

    first, *others = arrivals(graph)
    growing = GrowingMap(PoseGraph(2, **rows(first)))
    for pose, chosen in enumerate(tqdm(others, desc="ours", leave=False, disable=None), 2):
        given = rows(chosen)
        began = time.process_time()
        growing.add(**given)
        yield pose, time.process_time() - began, growing


def isam2(graph: PoseGraph) -> Array:
    """Return the CPU seconds of each pose from pose 2 on, with the estimate of the newest."""
    factors, _ = gtsam_graph.to_gtsam(graph, dead_reckoning(graph))
    z = [gtsam.Pose2(*each) for each in graph.measurement.tolist()]
    parameters = gtsam.ISAM2Params()
    parameters.setFactorization("QR")
    parameters.setRelinearizeThreshold(RELINEARISED)
    parameters.relinearizeSkip = SKIPPED
    solver, seconds = gtsam.ISAM2(parameters), []
    before = gtsam.Pose2()
    for pose, chosen in enumerate(
        tqdm(arrivals(graph), desc="iSAM2", leave=False, disable=None), 1
    ):
        new, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
        if pose == 1:
            new.push_back(factors.at(len(graph.edges)))
            values.insert(0, before)
        for k in chosen.tolist():
            new.push_back(factors.at(k))
        step = next(k for k in chosen.tolist() if graph.is_odometry[k])
        values.insert(pose, before.compose(z[step]))
        began = time.process_time()
        solver.update(new, values)
        before = solver.calculateEstimatePose2(pose)
        seconds.append(time.process_time() - began)
    return np.array(seconds[1:])


def line(name: str, seconds: Array) -> str:
    """Return the times of a side in a line, in milliseconds a pose."""
    middle, late, most = np.percentile(seconds, [50, 95, 100])
    each = (("median", middle), ("mean", seconds.mean()), ("p95", late), ("most", most))
    told = ", ".join(f"{word} {1e3 * value:.2f}" for word, value in each)
    return f"incremental/{name} {told} ms a pose, {seconds.sum():.1f} s in all"


def ratios(ours: Array, theirs: Array) -> str:
    """Return iSAM2's times ÷ ours; below 1 we are slower."""
    words = ("median", np.median), ("mean", np.mean), ("most", np.max)
    return ", ".join(f"{word} {of(theirs) / of(ours):.2f}" for word, of in words)


def compared(growing: GrowingMap, pose: int, is_outlier: Mask) -> str:
    """Return how the growing map's decisions differ from the batch's."""
    wrong = growing.kept & is_outlier[: growing.kept.size]
    differ = int(np.sum(solve(growing.graph).kept != growing.kept))
    closures = int(np.sum(~growing.graph.is_odometry))
    return (
        f"pose {pose}: {differ} of {closures} decisions differ, {int(wrong.sum())} outliers kept"
    )


def main() -> None:
    """Measure both sides and print parameters, times and ratios."""
    parser = ArgumentParser(description=__doc__, formatter_class=RawDescriptionHelpFormatter)
    parser.add_argument(
        "--every", type=int, default=0, help="compare with rs.solve at every so many poses, too"
    )
    every = parser.parse_args().every
    clean = load(NAME)
    count = round(SHARE * np.sum(~clean.is_odometry))
    truth = gauss_newton(clean, start.chordal(clean))
    spoiled, is_outlier = add_random_closures(clean, count, SEED, poses=truth)
    print(
        f"{NAME}: {clean.n} poses, {int(np.sum(~clean.is_odometry))} closures; {count} outliers "
        f"with seed {SEED}; iSAM2 by QR, relinearised above {RELINEARISED} at every "
        f"{SKIPPED} poses"
    )
    theirs = isam2(clean)
    ours = np.array([seconds for _, seconds, _ in grow(clean)])
    is_outlier = is_outlier[np.concatenate(arrivals(spoiled))]
    spent, told = [], []
    for pose, seconds, growing in grow(spoiled):
        spent.append(seconds)
        if every and (pose % every == 0 or pose == clean.n - 1):
            told.append(compared(growing, pose, is_outlier))
    robust = np.array(spent)
    for name, times in (("iSAM2", theirs), ("ours", ours), ("ours with outliers", robust)):
        print(line(name, times))
    print(f"ratio incremental/clean {ratios(ours, theirs)}")
    print(f"ratio incremental/outliers {ratios(robust, theirs)}")
    print(*told, sep="\n", end="\n" if told else "")
    began = time.process_time()
    answer = growing.answer()
    differ = int(np.sum(answer.kept != growing.kept))
    wrong = int(np.sum(answer.kept & is_outlier))
    print(
        f"answer() takes {time.process_time() - began:.1f} s and changes {differ} decisions; "
        f"{wrong} outliers kept"
    )


if __name__ == "__main__":
    main()
