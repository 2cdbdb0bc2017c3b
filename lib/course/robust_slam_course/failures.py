"""What each failing stage of a SLAM system does to the map of a small town: chapter 9.

A stage fails in the measurements (``FAULTS``), in place recognition, or in a part of the pipeline
that is left out or misled. Each outcome has the map, and the closures that every later stage left.
"""

import dataclasses
from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np
from robust_slam._arrays import Array, Indices, Mask
from robust_slam.certificates import Verdict, certify
from robust_slam.descent import start
from robust_slam.estimators import chi_square_threshold, gnc
from robust_slam.graphs import PoseGraph, add_random_closures, manhattan, pose_graph
from robust_slam.graphs.outliers import add_aliased_closures
from robust_slam.groups import se2
from robust_slam.problems import PoseGraphProblem

from robust_slam_course import pipeline

Fault = Callable[[Array, Indices], None]
"""Changes measurements ``(m, 3)`` of the town in place, given which are its odometry."""


STAGES = {
    "sensors": "Camera, IMU",
    "features": "Features, tracks",
    "views": "Two views",
    "places": "Place recognition",
    "ransac": "RANSAC",
    "odometry": "Odometry (VIO)",
    "pcm": "Consistency (PCM)",
    "solve": "Factor graph, robust solve",
    "certificate": "Certificate",
    "plan": "Trajectory",
    "control": "Control",
}
"""The name of every stage, in the order in which a picture comes through."""


class Outcome(NamedTuple):
    """A map and how it came about.

    ``passed``, ``left`` and ``kept`` are the edges ``(m,)`` that PCM passes, GNC leaves and the
    map uses; None where a stage was left out. ``verdict`` is that of the map's certificate.
    """

    graph: PoseGraph
    is_outlier: Mask
    poses: Array
    passed: Mask | None
    left: Mask | None
    kept: Mask
    verdict: Verdict


@cache
def town(seed: int = 3, kind: str = "random", count: int = 6) -> tuple[PoseGraph, Mask, Array]:
    """Return a town of 90 poses and 12 inliers, the mask of its ``count`` outliers, the truth.

    The outliers are random, or one consistent group for any other ``kind``.
    """
    rng = np.random.default_rng(seed)
    graph, truth = manhattan(90, rng, side=7, turn=0.25, closures=12)
    if kind == "random":
        return *add_random_closures(graph, count, rng, poses=truth), truth
    return *add_aliased_closures(graph, 1, rng, size=count, poses=truth), truth


def measured(change: Fault) -> tuple[PoseGraph, Mask]:
    """Return the town's graph after ``change`` worked on its measurements, and its outliers."""
    graph, is_outlier, _ = town()
    z = graph.measurement.copy()
    change(z, np.flatnonzero(graph.is_odometry))
    return dataclasses.replace(graph, measurement=z), is_outlier


def short_focal_length(z: Array, own: Indices) -> None:
    """Measure every turn 5 % too large, as a focal length that is 5 % too short does."""
    z[~town()[1], 2] *= 1.05


def noisier(z: Array, own: Indices, factor: float = 5.0) -> None:
    """Multiply the noise of the odometry, as slipping tracks do; the covariance is unchanged."""
    graph, _, truth = town()
    true = se2.between(truth[graph.edges[own, 0]], truth[graph.edges[own, 1]])
    error = se2.log(se2.between(true, z[own]))
    z[own] = se2.compose(true, se2.exp(factor * error))


def blur(z: Array, own: Indices) -> None:
    """Multiply the noise only where the robot turns sharply."""
    noisier(z, own[np.abs(z[own, 2]) > 0.5], factor=10.0)


def creep(z: Array, own: Indices) -> None:
    """Shrink the scale by 1 % a step."""
    z[own, :2] *= 0.99 ** np.arange(own.size)[:, None]


def bad_sample(z: Array, own: Indices) -> None:
    """Turn one step by 45° too much."""
    z[own[20], 2] += np.pi / 4


def gyro_bias(z: Array, own: Indices, bias: float = 0.04) -> None:
    """Turn every step by ``bias`` (rad) too much."""
    z[own, 2] += bias


FAULTS: dict[str, Fault] = {
    "sensors": short_focal_length,
    "features": noisier,
    "views": creep,
    "ransac": bad_sample,
    "odometry": gyro_bias,
    "control": blur,
}
"""What the stage of each key does to the measurements when it fails."""


@cache
def outcome(stage: str) -> Outcome:
    """Return what comes of the town where ``stage``, a key of ``STAGES``, fails.

    Any other name, such as "nothing", leaves all stages as they are.
    """
    graph, is_outlier, _ = town()
    if stage in FAULTS:
        return _by_pipeline(*measured(FAULTS[stage]))
    if stage == "places":
        return _by_pipeline(*town(kind="aliased", count=24)[:2])
    if stage == "solve":
        first = PoseGraphProblem(graph).initial()
        return _certified_by(graph, is_outlier, np.ones_like(is_outlier), first)
    if stage == "certificate":
        return turned(stage, 2.0)
    if stage == "plan":
        alone = pose_graph.select(graph, graph.is_odometry)
        return _by_pipeline(alone, is_outlier[graph.is_odometry])
    if stage == "pcm":
        left = gnc(PoseGraphProblem(graph, steps=5), chi_square_threshold(0.99, 3)).weights > 0.5
        first = start.chordal(pose_graph.select(graph, left))
        return _certified_by(graph, is_outlier, left, first)._replace(left=left)
    return _by_pipeline(graph, is_outlier)


@cache
def turned(stage: str, by: float) -> Outcome:
    """Return what comes of the town where ``stage`` fails by so much.

    "odometry" by a bias of the gyroscope (rad a step), "places" by closures that take one street
    for another, beside the random outliers, and "certificate" by turns too many in the headings
    from which the last descent starts.

    Raises:
        ValueError: ``stage`` is not one of the three.
    """
    graph, is_outlier, truth = town()
    if stage == "odometry":
        return _by_pipeline(*measured(lambda z, own: gyro_bias(z, own, by)))
    if stage == "certificate":
        wound = truth + np.outer(np.arange(90) / 90, [0, 0, 2.0 * np.pi * by])
        return _certified_by(graph, is_outlier, ~is_outlier, wound)
    if stage != "places":
        raise ValueError(f"stage: {stage!r}; use 'odometry', 'places' or 'certificate'.")
    other, is_one, _ = town(kind="aliased", count=24)
    mistaken = [getattr(other, name)[is_one][: int(by)] for name in pose_graph.ROWS[:3]]
    joined = pose_graph.with_closures(graph, *mistaken)
    return _by_pipeline(
        joined, np.arange(len(joined.edges)) >= len(graph.edges) - is_outlier.sum()
    )


def _by_pipeline(graph: PoseGraph, is_outlier: Mask) -> Outcome:
    answer = pipeline.solve(graph)
    passed = answer.consistency.kept
    left = passed.copy()
    left[passed] = answer.result.kept
    verdict = answer.certificate.verdict
    return Outcome(graph, is_outlier, answer.poses, passed, left, answer.kept, verdict)


def _certified_by(graph: PoseGraph, is_outlier: Mask, kept: Mask, first: Array) -> Outcome:
    poses, proof = certify(pose_graph.select(graph, kept), first)
    return Outcome(graph, is_outlier, poses, None, None, kept, proof.verdict)
