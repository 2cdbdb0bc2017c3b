"""The whole back-end in one function: pcm -> gnc -> certify.

Pairwise consistency maximisation removes closures that contradict most others, graduated
non-convexity classifies the rest while it solves, and the certificate tells whether the map
is globally optimal for the closures that were kept. It does not tell whether these are
inliers.

Source: SLAM Handbook 2026, chapter 3.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robust_slam._arrays import Array, Mask
from robust_slam.certificates.optimality import Certificate, certify
from robust_slam.consistency.pairwise import PcmResult, pcm
from robust_slam.descent import start
from robust_slam.estimators.graduation import Kind, gnc
from robust_slam.estimators.result import Result
from robust_slam.estimators.thresholds import chi_square_threshold
from robust_slam.graphs.pose_graph import PoseGraph, select
from robust_slam.problems import PoseGraphProblem

_STEPS = 20


@dataclass(frozen=True, eq=False)
class Answer:
    """A map, the edges that were kept, and the result of each stage.

    ``kept`` ``(m,)`` marks the edges of the graph that were kept, odometry among them, and
    ``poses``, ``(n, 3)`` or ``(n, 3, 4)``, are a minimum of their chordal cost.
    ``consistency`` is the result of PCM over all edges, ``result`` that of GNC over the
    consistent ones, and ``certificate`` tells whether the minimum is global.
    """

    poses: Array
    kept: Mask
    consistency: PcmResult
    result: Result[Array]
    certificate: Certificate


def solve(graph: PoseGraph, probability: float = 0.99, *, kind: Kind = "tls") -> Answer:
    """Return the map of ``graph`` without its outliers, and its certificate.

    The odometry is trusted. An inlier passes each test with ``probability``.

    Raises:
        ValueError: ``probability`` is not inside (0, 1), ``kind`` is unknown, or the
            odometry does not lead to every pose.

    Source: Mangelson et al. 2018 for PCM, Yang et al. 2020 for GNC, Rosen et al. 2019 for
    the certificate; in this order as in the SLAM Handbook 2026, chapter 3.

    >>> import numpy as np
    >>> from robust_slam.graphs import add_random_closures, manhattan
    >>> rng = np.random.default_rng(0)
    >>> graph, is_outlier = add_random_closures(manhattan(60, rng, closures=15)[0], 8, rng)
    >>> answer = solve(graph)
    >>> answer.certificate.verdict.value, int(np.sum(answer.kept & is_outlier))
    ('certified', 0)
    """
    threshold = chi_square_threshold(probability, graph.group.DOF)
    consistency = pcm(graph, threshold)
    consistent = select(graph, consistency.kept)
    # Start at odometry: remaining outliers distort the least-squares map.
    problem = PoseGraphProblem(consistent, steps=1)
    result = gnc(problem, threshold, kind, problem.guess)
    kept = consistency.kept.copy()
    kept[kept] = result.weights > 0.5
    # Without outliers the chordal start is close to the optimum, while GNC may have ended in
    # a local minimum. Far from the optimum Gauss–Newton is faster than the polish.
    inliers = select(graph, kept)
    first = start.chordal(inliers)
    near = PoseGraphProblem(inliers, first, steps=_STEPS).solve(np.ones(len(inliers.edges)), first)
    poses, certificate = certify(inliers, near)
    return Answer(poses, kept, consistency, result, certificate)
