"""Cases of distributed GNC: a few robots on one map."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from robust_slam.fleet import rounds
from robust_slam.graphs import add_random_closures, manhattan
from robust_slam.graphs.pose_graph import PoseGraph, select

from tests.lib.course.parity_cases import Angles, Case
from tests.lib.course.parity_graphs import C99, as_given


def fleet_cases(rng: np.random.Generator) -> Iterator[Case]:
    """Two or three robots in a town, with wrong closures, and every round."""
    for k in range(12):
        count = 2 + k % 2
        graph, labels = _fleet(rng, count, 8 + k)
        options: dict[str, Any] = {"factor": 2.0, "every": 1 + k % 3, "maxRounds": 40}
        outcome = rounds.solve(
            graph, labels, C99, factor=2.0, every=1 + k % 3, max_rounds=40, tol=1e-6
        )
        yield Case(
            {"graph": as_given(graph), "labels": labels, "c": C99, "options": options},
            {
                "stop": outcome.stop.value,
                "rounds": [
                    {
                        "poses": Angles(seen.poses), "weights": seen.weights, "mu": seen.mu,
                        "numbers": seen.numbers,
                    }
                    for seen in outcome.rounds
                ],
            },
        )  # fmt: skip


def _fleet(rng: np.random.Generator, count: int, each: int) -> tuple[PoseGraph, np.ndarray]:
    """Return a town without odometry between the robots, all of them joined by closures."""
    labels = np.arange(count * each) // each
    while True:
        graph, truth = manhattan(len(labels), rng, side=3, turn=0.3, closures=3 * count)
        parted = np.ptp(labels[graph.edges], axis=1) > 0
        met = set(map(tuple, labels[graph.edges[parted & ~graph.is_odometry]].tolist()))
        if len(met) >= count - 1:
            break
    graph = select(graph, ~(graph.is_odometry & parted))
    return add_random_closures(graph, count, rng, poses=truth)[0], labels
