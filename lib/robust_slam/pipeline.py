"""The whole back-end in one function: pcm -> gnc -> certify.

Pairwise consistency throws out closures that contradict most others, graduated
non-convexity decides about the rest while it solves, and the certificate says whether
the map is the best one for the closures that were kept. It does not say that these are
true.
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
    """A map, the edges that it rests on, and what each stage said.

    ``kept`` ``(m,)`` marks the edges of the graph that were kept, odometry among them, and
    ``poses``, ``(n, 3)`` or ``(n, 3, 4)``, are a minimum of their chordal cost.
    ``consistency`` is PCM's answer over all edges, ``result`` that of GNC over the
    consistent ones, and ``certificate`` tells whether the minimum is the global one.
    """

    poses: Array
    kept: Mask
    consistency: PcmResult
    result: Result[Array]
    certificate: Certificate


def solve(graph: PoseGraph, probability: float = 0.99, *, kind: Kind = "tls") -> Answer:
    """Return the map of ``graph`` without the closures that do not fit, and its certificate.

    The odometry is trusted. An honest closure passes each test with ``probability``.

    Raises:
        ValueError: ``probability`` is not inside (0, 1), ``kind`` is unknown, or the
            odometry does not lead to every pose.
        NotConverged: the polish of the last map did not come to rest.

    Source: Mangelson et al. 2018 for PCM, Yang et al. 2020 for GNC, Rosen et al. 2019 for
    the certificate; in this order as in the SLAM Handbook 2026, chapter 3.
    """
    threshold = chi_square_threshold(probability, graph.group.DOF)
    consistency = pcm(graph, threshold)
    consistent = select(graph, consistency.kept)
    # Least squares is bent by the lies that are left; dead reckoning knows none of them.
    problem = PoseGraphProblem(consistent, steps=1)
    result = gnc(problem, threshold, kind, problem.guess)
    kept = consistency.kept.copy()
    kept[kept] = result.weights > 0.5
    # Without the lies a start that needs no first poses is near the optimum; the path
    # that graduation took among them may have ended in a local minimum. A few steps of
    # Gauss–Newton bring it nearer than the polish would.
    honest = select(graph, kept)
    first = start.chordal(honest)
    near = PoseGraphProblem(honest, first, steps=_STEPS).solve(np.ones(len(honest.edges)), first)
    poses, certificate = certify(honest, near)
    return Answer(poses, kept, consistency, result, certificate)
