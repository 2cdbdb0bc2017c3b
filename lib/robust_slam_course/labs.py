"""The towns of the labs: closures that arrive one at a time, and a ring that may be wound."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from robust_slam._arrays import Array, Indices, Mask
from robust_slam.graphs import Noise, PoseGraph, add_random_closures, circle, manhattan
from robust_slam.graphs.odometry import dead_reckoning
from robust_slam.graphs.pose_graph import with_closures

LOOK_ALIKE = (6, 17)
"""The poses that place recognition takes for one: two corners that are 1 m apart."""
_EDGE = ("edges", "measurement", "information", "is_odometry")


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
    return {name: getattr(graph, name)[[k]] for name in _EDGE}


def ring(seed: int) -> tuple[PoseGraph, Mask, Array]:
    """Return two rounds of 18 poses with 12 inliers and four outliers, their mask, the truth."""
    rng = np.random.default_rng(seed)
    noise = Noise(odometry=(0.1, 0.1))
    clean, truth = circle(36, rng, laps=2, closures=12, noise=noise)
    return *add_random_closures(clean, 4, rng, poses=truth), truth


def wound(graph: PoseGraph, turns: int) -> Array:
    """Return dead reckoning ``(n, 3)`` whose headings turn ``turns`` times more over the drive."""
    measurement = graph.measurement.copy()
    own = graph.is_odometry
    measurement[own, 2] += 2.0 * np.pi * turns / np.sum(own)
    return dead_reckoning(dataclasses.replace(graph, measurement=measurement))
