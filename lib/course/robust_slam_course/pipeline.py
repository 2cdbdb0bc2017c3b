"""The pipeline that chapter 8 takes apart: pcm -> gnc -> truncated least squares -> certify.

Pairwise consistency maximisation removes closures that contradict most others, and graduated
non-convexity classifies the rest while it solves. A closure is compared with many others, so PCM
also rejects inliers: 103 of the 1,954 closures of the graph M3500. Their residuals at the map of
GNC are small. Truncated least squares (TLS) over all closures, from that map, therefore decides
in the end: a closure is kept if its residual is at most the threshold, whatever the stages before
said. An outlier that fits the map by less than the threshold returns as well.

``robust_slam.solve`` makes more good maps: PCM is one of its starts, and not a filter.

Source: Mangelson et al. 2018 for PCM, Yang et al. 2020 for GNC, Rosen et al. 2019 for the
certificate; in this order as in the SLAM Handbook 2026, chapter 3; that TLS decides about all
closures is derived here.
"""

from dataclasses import dataclass

import numpy as np
from robust_slam._arrays import Array, Indices, Mask
from robust_slam.certificates import Certificate, certify
from robust_slam.consistency import pcm
from robust_slam.consistency.pairwise import PcmResult
from robust_slam.estimators import chi_square_threshold, gnc, irls, kernels
from robust_slam.estimators.result import Result
from robust_slam.graphs import PoseGraph, dead_reckoning
from robust_slam.graphs.pose_graph import select
from robust_slam.problems import PoseGraphProblem
from robust_slam.solver.candidates import readmitted

_ROUGH = 1e-3
"""The ``tol`` of stages whose result another one takes on."""


@dataclass(frozen=True, eq=False)
class Solved:
    """What each stage says about the closures, and the map of the last one.

    ``consistency`` is the result of PCM, ``result`` that of GNC over the consistent edges, and
    ``kept`` ``(m,)`` marks the edges that truncated least squares keeps, odometry among them.
    ``poses``, ``(n, 3)`` or ``(n, 3, 4)``, are a minimum of their chordal cost, and
    ``certificate`` tells whether it is global.
    """

    consistency: PcmResult
    result: Result[Array]
    kept: Mask
    poses: Array
    certificate: Certificate

    @property
    def returned(self) -> Indices:
        """The edges that PCM or GNC rejected and that were kept in the end, ascending."""
        classified = self.consistency.kept.copy()
        classified[classified] = self.result.kept
        return np.flatnonzero(self.kept & ~classified)


def solve(graph: PoseGraph, probability: float = 0.99) -> Solved:
    """Return the map of ``graph`` that the pipeline makes, and what its stages did.

    The odometry is trusted and has to join all poses. An inlier passes each test with
    ``probability``.

    Raises:
        ValueError: ``probability`` is not inside (0, 1), or the odometry leaves a pose loose.

    Source: Mangelson et al. 2018, Yang et al. 2020 and Rosen et al. 2019.
    """
    threshold = chi_square_threshold(probability, graph.group.DOF)
    consistency = pcm(graph, threshold)
    consistent = PoseGraphProblem(select(graph, consistency.kept), dead_reckoning(graph), steps=1)
    result = gnc(consistent, threshold, x0=consistent.guess, tol=_ROUGH)
    decided = _decided(PoseGraphProblem(graph, result.x, steps=1), threshold)
    poses, certificate = certify(select(graph, decided.kept), decided.x)
    return Solved(consistency, result, decided.kept, poses, certificate)


def _decided(problem: PoseGraphProblem, threshold: float) -> Result[Array]:
    """Return the result of truncated least squares over all edges, from the guess.

    Rejected closures near it return first. Where that does not lower the cost, the guess remains.
    """
    maps = problem.guess, readmitted(problem, problem.guess, threshold)

    def cost(poses: Array) -> float:
        norms = problem.residual_norms(poses)
        return float(np.sum(np.where(problem.trusted, norms, np.minimum(norms, threshold)) ** 2))

    return irls(problem, kernels.tls(threshold), min(maps, key=cost), tol=_ROUGH)
