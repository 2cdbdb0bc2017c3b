"""Which closures are inliers: PCM, GNC, and truncated least squares over all closures.

A closure is compared with many others, so PCM also rejects inliers: 103 of the 1,954 closures
of the graph M3500. Their residuals at the map of GNC are small. Truncated least squares (TLS)
over all closures, from that map, therefore decides in the end: a closure is kept if its
residual is at most the threshold, whatever the stages before said.

An outlier that fits the map by less than the threshold returns as well. On intel, whose
deviations are claimed seven times too large, with nine outliers for each inlier and all of
them between poses at most 20 steps apart, precision falls from 0.93 to 0.88.

Source: Mangelson et al. 2018 for PCM, Yang et al. 2020 for GNC; that TLS decides about all
closures is derived here.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from robust_slam._arrays import Array, Mask
from robust_slam._deadline import Deadline
from robust_slam.consistency.bridges import Bridges, find_bridges
from robust_slam.consistency.pairwise import PcmResult, pcm
from robust_slam.descent import start
from robust_slam.estimators import kernels
from robust_slam.estimators.graduation import Kind, gnc, start_mu
from robust_slam.estimators.result import Result, Step, StopReason
from robust_slam.estimators.reweighting import irls
from robust_slam.graphs.odometry import accumulated_rotation, spanning_tree
from robust_slam.graphs.pose_graph import PoseGraph, residual_norms, select, unreached
from robust_slam.problems import PoseGraphProblem
from robust_slam.progress import Progress

_REACH = 5.0
"""A rejected closure may return if its residual is at most so many thresholds."""
_ROUGH = 1e-3
"""The ``tol`` of stages whose result another one takes on."""
_LOST = np.pi
"""The deviation (rad) of a rotation from which on it may be any."""
_TRIMS = 2
"""So many times the closures that fit worst are left out of the chordal map."""
_WORST = 3.0
"""A closure fits too badly if its residual is so many times the median."""
_FREEDOM = 30
"""The least number of degrees of freedom that tell the noise to about 13 %."""


@dataclass(frozen=True, eq=False)
class Classification:
    """What each stage says about the closures.

    ``consistency`` is the result of PCM, ``bridges`` are the closures that are trusted to join
    sessions, ``result`` is that of GNC over the consistent edges, and ``final`` that of
    truncated least squares over all edges, which decides.
    """

    consistency: PcmResult
    bridges: Bridges
    result: Result[Array]
    final: Result[Array]

    def noise(self, graph: PoseGraph) -> float:
        """Return the deviations that the kept edges have, in units of those they claim.

        It is 1 where too few closures are kept to tell, or where the time did not suffice.

        Source: Helmert 1907, the a posteriori variance of unit weight.
        """
        kept = self.final.kept
        freedom = graph.group.DOF * (int(kept.sum()) - graph.n + 1)
        if freedom < _FREEDOM or self.final.stop is StopReason.TIME_LIMIT:
            return 1.0
        squares = residual_norms(graph, self.final.x)[kept] ** 2
        return float(np.sqrt(np.sum(squares) / freedom))


def classify(
    graph: PoseGraph, threshold: float, kind: Kind, tell: Progress, deadline: Deadline
) -> Classification:
    """Return which closures are inliers, as far as the ``deadline`` allows.

    Each stage is computed to some end: where no time is left, PCM does not compare the
    remaining pairs, and the others take one step.
    """
    tell("PCM compares closures")
    consistency = pcm(graph, threshold, max_seconds=deadline.left)
    bridges = find_bridges(graph, consistency)
    trusted = graph.is_odometry | np.isin(np.arange(len(graph.edges)), bridges.edges)
    result = _graduated(graph, consistency.kept, trusted, threshold, kind, tell, deadline)
    tell("truncated least squares looks at all closures")
    everything = PoseGraphProblem(graph, result.x, trusted, steps=1)
    final = _decided(everything, threshold, deadline)
    return Classification(consistency, bridges, result, final)


def _graduated(
    graph: PoseGraph,
    used: Mask,
    trusted: Mask,
    threshold: float,
    kind: Kind,
    tell: Progress,
    deadline: Deadline,
) -> Result[Array]:
    """Return the result of GNC over the ``used`` edges."""
    consistent = select(graph, used)
    first = _start(graph, consistent, trusted, threshold, deadline)
    problem = PoseGraphProblem(consistent, first, trusted[used], steps=1)

    def watch(step: Step[Array]) -> None:
        tell(f"GNC at mu = {step.mu:.3g}")

    left = deadline.left
    return gnc(problem, threshold, kind, problem.guess, tol=_ROUGH, watch=watch, max_seconds=left)


def _decided(problem: PoseGraphProblem, threshold: float, deadline: Deadline) -> Result[Array]:
    """Return the result of truncated least squares over all edges, from the guess.

    Inliers that were rejected pull on the map only when they return, so at first closures
    count up to ``_REACH`` thresholds. Where that does not lower the cost, the guess remains.

    Source: Yang et al. 2020 for the surrogate and, Remark 5, its first μ; its use to take
    closures back is derived here.
    """
    norms = problem.residual_norms(problem.guess)
    near = ~problem.trusted & (norms > threshold) & (norms < _REACH * threshold)
    maps = [problem.guess]
    if np.any(near) and not deadline.passed:
        # Weights are above 0 up to _REACH thresholds, or to √2 of the largest norm if less.
        widest = start_mu(float(np.max(norms[near])), threshold)
        mu, left = max(1.0 / (_REACH**2 - 1.0), widest), deadline.left
        x0 = problem.guess
        again = gnc(problem, threshold, x0=x0, mu0=mu, tol=_ROUGH, max_seconds=left)
        maps.append(again.x)

    def cost(poses: Array) -> float:
        norms = problem.residual_norms(poses)
        return float(np.sum(np.where(problem.trusted, norms, np.minimum(norms, threshold)) ** 2))

    first, kernel = min(maps, key=cost), kernels.tls(threshold)
    return irls(problem, kernel, first, tol=_ROUGH, max_seconds=deadline.left)


def _start(
    graph: PoseGraph, consistent: PoseGraph, trusted: Mask, threshold: float, deadline: Deadline
) -> Array:
    """Return the poses from which GNC starts.

    That is odometry: remaining outliers distort the chordal map. Where the odometry loses its
    rotation, a chordal map without the worst closures may be closer; then the one of lower
    TLS cost is taken.
    """
    odometry = spanning_tree(graph, trusted.astype(float))
    if accumulated_rotation(graph, trusted) <= _LOST or deadline.passed:
        return odometry

    def truncated(poses: Array) -> float:
        return float(np.sum(np.minimum(residual_norms(consistent, poses), threshold) ** 2))

    return min((odometry, *_trimmed(consistent)), key=truncated)


def _trimmed(graph: PoseGraph) -> Iterator[Array]:
    """Yield chordal maps, each without the closures that fit the one before worst."""
    used = np.ones(len(graph.edges), dtype=np.bool_)
    for _ in range(_TRIMS + 1):
        poses = start.chordal(select(graph, used))
        yield poses
        norms = residual_norms(graph, poses)
        before = used
        used = graph.is_odometry | (norms <= _WORST * np.median(norms[~graph.is_odometry]))
        if np.array_equal(used, before) or unreached(graph, used).size:
            return
