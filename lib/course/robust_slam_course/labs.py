"""The maps of the labs: closures that arrive one at a time, a ring, towns with look-alikes."""

import dataclasses
from collections.abc import Iterable
from functools import cache
from typing import Any

import numpy as np
from robust_slam._arrays import Array, Indices, Mask
from robust_slam.graphs import (
    Noise,
    PoseGraph,
    add_local_closures,
    add_random_closures,
    circle,
    manhattan,
)
from robust_slam.graphs.odometry import dead_reckoning
from robust_slam.graphs.outliers import add_aliased_closures
from robust_slam.graphs.pose_graph import ROWS, select, with_closures
from robust_slam.problems import PoseGraphProblem

from robust_slam_course.recogniser import Recognised, recognised

LOOK_ALIKE = (6, 17)
"""The poses that place recognition takes for one: two corners that are 1 m apart."""
ARRIVALS = range(17, 32)
"""The poses at which the outlier may arrive."""
KINDS = ("random", "local", "agreeing")
"""Of outliers: between any poses, near the truth, and in groups of 15 with one cause."""
PERCENTS = range(0, 100, 10)
"""The shares of outliers among the closures."""
_NEWTON = 20


def late_town() -> tuple[PoseGraph, Array]:
    """Return a drive of 44 poses with eight inliers and, as the last edge, one outlier.

    The outlier joins ``LOOK_ALIKE``. The true poses ``(44, 3)`` come with the graph.
    """
    noise = Noise(odometry=(0.1, 0.05))
    clean, truth = manhattan(44, 13, side=6, turn=0.3, closures=8, noise=noise)
    precise = clean.information[-1:]
    return with_closures(clean, [LOOK_ALIKE], np.zeros((1, 3)), precise), truth


def in_order(graph: PoseGraph, arrives: int) -> Indices:
    """Return the edges ``(m,)`` as they arrive: each at its later pose, odometry first.

    The last edge arrives when the robot is at pose ``arrives``, after the others of that pose.
    """
    later = graph.edges.max(axis=1) + 0.5 * ~graph.is_odometry
    later[-1] = arrives + 0.75
    return np.argsort(later, kind="stable")


def edge(graph: PoseGraph, k: int) -> dict[str, Any]:
    """Return edge ``k`` of ``graph`` by its names, as ``GrowingMap.add`` takes it."""
    return {name: getattr(graph, name)[[k]] for name in ROWS}


def ring(seed: int) -> tuple[PoseGraph, Mask, Array]:
    """Return two rounds of 18 poses with 12 inliers and four outliers, their mask, the truth.

    Poses that an outlier joins are at least 4.5 m from each other. By default it would be the
    radius, 5 m, to which the distances over a sixth of a round are equal, up to rounding.
    """
    rng = np.random.default_rng(seed)
    noise = Noise(odometry=(0.1, 0.1))
    clean, truth = circle(36, rng, laps=2, closures=12, noise=noise)
    return *add_random_closures(clean, 4, rng, poses=truth, apart=4.5), truth


def wound(graph: PoseGraph, turns: float) -> Array:
    """Return dead reckoning ``(n, 3)`` whose headings turn ``turns`` times more over the drive."""
    measurement = graph.measurement.copy()
    own = graph.is_odometry
    measurement[own, 2] += 2.0 * np.pi * turns / np.sum(own)
    return dead_reckoning(dataclasses.replace(graph, measurement=measurement))


TURNS = tuple(np.arange(0.0, 3.25, 0.25).tolist())
"""By how many turns the start of a certified run is wound."""
UNIT = 0.05
"""Metres in which poses of a certified run are stored, about a pixel."""
GOOD = 0.1
"""The largest distance (m) of a good map from that of the inliers."""


@cache
def best_of_ring() -> Array:
    """Return the map ``(n, 3)`` of the inliers of the first ring."""
    graph, is_outlier, _ = ring(0)
    return PoseGraphProblem(select(graph, ~is_outlier)).initial()


def towns(percent: int, seeds: Iterable[int], poses: int = 60) -> list[Recognised]:
    """Return towns of so many ``poses``, of whose crossings ``percent`` look like others."""
    return [recognised(poses, percent, Noise(odometry=(0.1, 0.1)), seed) for seed in seeds]


def scores(sample: Iterable[Recognised]) -> tuple[Array, Mask]:
    """Return the scores ``(k,)`` of the closures of all towns, and which are inliers."""
    chosen = list(sample)
    inlier = [~town.is_false[~town.graph.is_odometry] for town in chosen]
    return np.concatenate([town.scores for town in chosen]), np.concatenate(inlier)


def logistic(score: Array, inlier: Mask) -> tuple[float, float]:
    """Return the slope and the offset of the log-odds that a closure is an inlier.

    They maximise the likelihood of the masks ``inlier`` ``(k,)`` at the scores ``score`` ``(k,)``,
    by Newton's method; if all are inliers there is no maximum, and the steps go on to infinity.
    """
    columns, fit = np.column_stack([score, np.ones_like(score)]), np.zeros(2)
    for _ in range(_NEWTON):
        p = 1.0 / (1.0 + np.exp(-columns @ fit))
        hessian = columns.T @ (columns * (p * (1.0 - p))[:, None])
        fit = fit + np.linalg.solve(hessian, columns.T @ (inlier - p))
    return float(fit[0]), float(fit[1])


def scored_town() -> tuple[Recognised, Array]:
    """Return the town of the third lab's picture, and its closures' log-odds ``(k,)``."""
    slope, offset = logistic(*scores(towns(75, range(1000, 1020))))
    (town,) = towns(75, [8], poses=40)
    return town, slope * town.scores + offset


def spoiled(kind: str, percent: int) -> tuple[PoseGraph, Mask, Array]:
    """Return a town of 60 poses and ten inliers with outliers of a kind, their mask, the truth.

    They are ``percent`` of the closures, and those of a smaller share are among them.
    """
    rng = np.random.default_rng(4)
    noise = Noise(odometry=(0.1, 0.1))
    clean, truth = manhattan(60, rng, side=6, turn=0.3, closures=10, noise=noise)
    if kind == "random":
        whole, is_outlier = add_random_closures(clean, 90, rng, poses=truth)
    elif kind == "local":
        whole, is_outlier = add_local_closures(clean, 90, rng, poses=truth)
    else:
        whole, is_outlier = add_aliased_closures(clean, 6, rng, size=15, poses=truth)
    count = round(10 * percent / (100 - percent))
    used = np.cumsum(is_outlier) <= count
    return select(whole, used), is_outlier[used], truth
