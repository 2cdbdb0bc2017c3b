"""What is wrong with a world besides its outliers: claims of deviations, and odometry.

Source: the families of wrong claims and of odometry are derived here; outliers of odometry as in
Latif, Cadena and Neira 2013 are slips.
"""

from dataclasses import replace

import numpy as np
from robust_slam._arrays import Array
from robust_slam.graphs import PoseGraph
from robust_slam.solver.noise import rescaled

FACTORS = {"x 0.1": 0.1, "x 0.33": 1 / 3, "x 3": 3.0, "x 10": 10.0}
"""Claimed deviations beside the true ones."""
CLAIMS = {
    "all": np.array([1, 1, 1, 1], dtype=bool),
    "rotations": np.array([0, 1, 0, 1], dtype=bool),
    "odometry": np.array([1, 1, 0, 0], dtype=bool),
}
"""Which deviations are claimed wrongly: positions, rotations of odometry, then of closures."""
SLIPS = 3
TURNED, SHIFTED = (0.35, 1.05), (1.0, 3.0)
"""A slip turns the robot by so many radians, and moves it by so many steps."""
NOISY, WIDER = 0.1, 5.0
"""This share of the odometry has deviations so many times as large as claimed."""
ODOMETRY = ("slips", "noisy steps")
CHANGES = {"C": tuple(f"{kind} {factor}" for kind in CLAIMS for factor in FACTORS), "D": ODOMETRY}
"""The changes of the tiers that have some."""


def changed(
    graph: PoseGraph, change: str, rng: np.random.Generator
) -> tuple[PoseGraph, PoseGraph]:
    """Return ``graph`` with a change, and the same measurements with true deviations.

    Raises:
        KeyError: there is no such change.
    """
    if not change:
        return graph, graph
    if change not in ODOMETRY:
        kind, _, factor = change.partition(" ")
        return rescaled(graph, np.where(CLAIMS[kind], FACTORS[factor], 1.0)), graph
    odometry = np.flatnonzero(graph.is_odometry)
    count = SLIPS if change == "slips" else round(NOISY * odometry.size)
    chosen = np.sort(rng.choice(odometry, size=count, replace=False))
    errors = _slips(graph, count, rng) if change == "slips" else _noise(graph, chosen, rng)
    measurement = graph.measurement.copy()
    measurement[chosen] = graph.group.compose(measurement[chosen], graph.group.exp(errors))
    moved = replace(graph, measurement=measurement)
    information = graph.information.copy()
    if change == "slips":
        # So wide that the step tells nothing, and the graph stays joined.
        information[chosen] = np.eye(graph.group.DOF) / (10.0 * _typical(graph)) ** 2
    else:
        information[chosen] /= WIDER**2
    return moved, replace(moved, information=information)


def _slips(graph: PoseGraph, count: int, rng: np.random.Generator) -> Array:
    """Return the errors ``(count, D)`` of slips: a turn about the last axis, and a move."""
    d, size = graph.group.DIMENSION, graph.group.DOF
    errors = np.zeros((count, size))
    direction = rng.normal(size=(count, d))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    errors[:, :d] = direction * (_typical(graph) * rng.uniform(*SHIFTED, size=count))[:, None]
    errors[:, -1] = rng.uniform(*TURNED, size=count) * rng.choice([-1.0, 1.0], size=count)
    return errors


def _noise(graph: PoseGraph, chosen: Array, rng: np.random.Generator) -> Array:
    """Return noise ``(k, D)`` that makes the deviations of the ``chosen`` edges ``WIDER``."""
    root = np.linalg.cholesky(np.linalg.inv(graph.information[chosen]))
    white = rng.normal(size=(len(chosen), graph.group.DOF, 1))
    return np.asarray(np.sqrt(WIDER**2 - 1.0) * (root @ white)[..., 0])


def _typical(graph: PoseGraph) -> float:
    """Return the median length (m) of an odometry step."""
    return float(np.median(np.linalg.norm(graph.translation[graph.is_odometry], axis=1)))
