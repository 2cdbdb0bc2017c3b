"""The whole back-end in one function: pcm -> gnc -> certify.

Pairwise consistency maximisation removes closures that contradict most others, graduated
non-convexity classifies the rest while it solves, and the certificate tells whether the map
is globally optimal for the closures that were kept. It does not tell whether these are
inliers.

Source: SLAM Handbook 2026, chapter 3.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from robust_slam._arrays import Array, Indices, Mask
from robust_slam.certificates.optimality import MAX_SECONDS, Certificate, Verdict
from robust_slam.certificates.staircase import solve_certified
from robust_slam.consistency.bridges import Bridges, find_bridges
from robust_slam.consistency.pairwise import PcmResult, pcm
from robust_slam.descent import start
from robust_slam.estimators.graduation import Kind, check_kind, gnc
from robust_slam.estimators.result import KEPT, Result, Step, StopReason
from robust_slam.estimators.thresholds import chi_square_threshold
from robust_slam.graphs.odometry import accumulated_rotation, spanning_tree
from robust_slam.graphs.pose_graph import PoseGraph, check_graph, residual_norms, select, unreached
from robust_slam.problems import PoseGraphProblem
from robust_slam.progress import Progress, stages

_LOST = np.pi
"""The deviation (rad) of a rotation from which on it may be any."""
_TRIMS = 2
"""So many times the closures that fit worst are left out of the chordal map."""
_WORST = 3.0
"""A closure fits too badly if its residual is so many times the median."""


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Answer:
    """A map, the edges that were kept, and the result of each stage.

    ``kept`` ``(m,)`` marks the edges of the graph that were kept, odometry among them, and
    ``poses``, ``(n, 3)`` or ``(n, 3, 4)``, are a minimum of their chordal cost.
    ``consistency`` is the result of PCM over all edges, ``result`` that of GNC over the
    consistent ones, and ``certificate`` tells whether the minimum is global. ``bridges`` are
    the closures that were trusted to join sessions, where the odometry does not join all.
    """

    graph: PoseGraph
    poses: Array
    kept: Mask
    bridges: Bridges
    consistency: PcmResult
    result: Result[Array]
    certificate: Certificate

    @property
    def weights(self) -> Array:
        """The weight of each edge, ``(m,)``; 0 for closures that PCM removed."""
        weights = np.zeros(self.kept.size)
        weights[self.consistency.kept] = self.result.weights
        return weights

    @property
    def cost(self) -> float:
        """The chordal cost of the kept edges, which the certificate is about.

        It takes one precision for the position of an edge and one for its rotation. For a
        minimum with the whole information matrices continue with
        ``gauss_newton(select(graph, answer.kept), answer.poses)``.
        """
        return self.certificate.cost

    @property
    def stop(self) -> StopReason:
        """Why GNC stopped."""
        return self.result.stop

    @property
    def history(self) -> tuple[Step[Array], ...]:
        """The steps of GNC, over the consistent edges."""
        return self.result.history

    @property
    def rejected(self) -> Indices:
        """The edges that were not kept, ascending."""
        return np.flatnonzero(~self.kept)

    def __repr__(self) -> str:
        kept = f"{int(self.kept.sum()):,} of {self.kept.size:,} edges kept"
        return f"<Answer: {self.poses.shape[0]:,} poses, {kept}, {self.certificate.verdict.value}>"

    def summary(self) -> str:
        """Return what happened at each stage, a line each."""
        closures = ~self.graph.is_odometry
        agree, kept = (int(np.sum(mask & closures)) for mask in (self.consistency.kept, self.kept))
        steps = len(self.history) - 1
        proof = self.certificate
        rows = [
            ("read", f"{self.kept.size:,} edges, {int(closures.sum()):,} of them closures"),
            ("PCM", f"{agree:,} closures agree{self._about_pcm()}"),
            ("GNC", f"{kept:,} closures kept; {self.stop.value} after {steps} steps"),
            ("map", f"{len(self.poses):,} poses, chordal cost {self.cost:.6g}"),
            (
                "optimum",
                f"{proof.verdict.value}, the gap is at most {proof.bound:.3g}{_end(proof)}",
            ),
        ]
        return "\n".join([*(f"{name:<8} {text}" for name, text in rows), *self.notes()])

    def _about_pcm(self) -> str:
        if not self.consistency.complete:
            return ", compared in blocks along the drive as there are very many"
        return "" if self.consistency.clique.proven else ", maybe not the largest such set"

    def notes(self) -> list[str]:
        """Return a sentence for each thing that the map depends on and nothing confirms."""
        edges, support = self.bridges.edges, self.bridges.support
        if not edges.size:
            return []
        lines = [f"The odometry leaves {edges.size + 1:,} sessions, joined by trusted closures."]
        alone = edges[support == 1]
        if alone.size:
            named = ", ".join(map(str, alone[:5])) + (", …" if alone.size > 5 else "")
            lines.append(f"Nothing confirms {alone.size:,} of these closures (edges {named}).")
        return lines


def _end(proof: Certificate) -> str:
    """Return why the search for a certificate stopped without one."""
    if proof.verdict is Verdict.CERTIFIED or proof.stop is None:
        return ""
    return f"; the search stopped: {proof.stop.value}"


def solve(
    graph: PoseGraph,
    probability: float = 0.99,
    *,
    kind: Kind = "tls",
    progress: bool | Progress = False,
    max_seconds: float = MAX_SECONDS,
) -> Answer:
    """Return the map of ``graph`` without its outliers, and its certificate.

    The odometry is trusted. Where it has gaps, it leaves several sessions: a tree of closures
    that agree with most others joins them, and these are trusted too (``Answer.bridges``). An
    inlier passes each test with ``probability``. ``progress`` shows a bar, or is a function
    that is told each stage; stages are logged in any case. The search for the certificate
    ends after about ``max_seconds`` of CPU time with the best map so far.

    Raises:
        TypeError: ``graph`` is not a pose graph.
        ValueError: ``probability`` is not inside (0, 1), or ``kind`` is unknown.

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
    check_kind(kind)
    check_graph(graph)
    threshold = chi_square_threshold(probability, graph.group.DOF)
    with stages(progress) as tell:
        tell("PCM compares closures")
        consistency = pcm(graph, threshold)
        bridges = find_bridges(graph, consistency)
        trusted = graph.is_odometry | np.isin(np.arange(len(graph.edges)), bridges.edges)
        result = _classified(graph, consistency.kept, trusted, threshold, kind, tell)
        kept = consistency.kept.copy()
        kept[kept] = result.weights > KEPT
        tell("the certificate is computed")
        # Without outliers the chordal start is close to the optimum, while GNC may have ended
        # in a local minimum.
        inliers = select(graph, kept)
        poses, certificate = solve_certified(
            inliers, start.chordal(inliers), max_seconds=max_seconds
        )
    return Answer(
        graph=graph,
        poses=poses,
        kept=kept,
        bridges=bridges,
        consistency=consistency,
        result=result,
        certificate=certificate,
    )


def _classified(
    graph: PoseGraph, used: Mask, trusted: Mask, threshold: float, kind: Kind, tell: Progress
) -> Result[Array]:
    """Return the result of GNC over the ``used`` edges."""
    consistent = select(graph, used)
    first = _start(graph, consistent, trusted, threshold)
    problem = PoseGraphProblem(consistent, first, trusted[used], steps=1)

    def watch(step: Step[Array]) -> None:
        tell(f"GNC at mu = {step.mu:.3g}")

    return gnc(problem, threshold, kind, problem.guess, watch=watch)


def _start(graph: PoseGraph, consistent: PoseGraph, trusted: Mask, threshold: float) -> Array:
    """Return the poses from which GNC starts.

    That is odometry: remaining outliers distort the chordal map. Where the odometry loses its
    rotation, a chordal map without the worst closures may be closer; then the one of lower
    TLS cost is taken.
    """
    odometry = spanning_tree(graph, trusted.astype(float))
    if accumulated_rotation(graph, trusted) <= _LOST:
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
