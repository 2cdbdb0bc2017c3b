"""The whole back-end in one function: pcm -> gnc -> certify.

Pairwise consistency maximisation removes closures that contradict most others, and graduated
non-convexity classifies the rest while it solves. Truncated least squares over all closures
takes back those that fit the map (``classification``). The certificate tells whether the map is
globally optimal for the closures that were kept. It does not tell whether these are inliers.

Source: SLAM Handbook 2026, chapter 3.
"""

from __future__ import annotations

from dataclasses import replace

from robust_slam._arrays import Array
from robust_slam._deadline import Deadline
from robust_slam.certificates.optimality import (
    MAX_SECONDS,
    Certificate,
    Verdict,
    certify,
    unproven,
)
from robust_slam.certificates.staircase import solve_certified
from robust_slam.descent import start
from robust_slam.estimators.graduation import Kind, check_kind
from robust_slam.estimators.thresholds import chi_square_threshold
from robust_slam.graphs.pose_graph import PoseGraph, check_graph, select
from robust_slam.pipeline.answer import Answer as Answer
from robust_slam.pipeline.classification import Classification, classify
from robust_slam.progress import Progress, stages

_LOOSE = 0.1
"""Where the noise is below this share of the claimed one, thresholds are scaled."""
_MARGIN = 6.0
"""A scaled threshold belongs to so many times the noise that was found."""
_LEAST = 1e-3
"""No noise below this share of the claimed one is assumed."""
_ROUNDS = 4
"""The closures are classified at most so many times."""


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
    inlier passes each test with ``probability``. ``kind`` is the kernel of GNC. ``progress``
    shows a bar, or is a function that is told each stage; stages are logged in any case.

    Where the information matrices claim far larger deviations than the measurements have,
    outliers hide in the difference: in parking-garage, where residuals are 0.007 of the claimed
    deviations, 14 of 100 random outliers fit a map that they bend. So closures are classified
    again with a threshold for six times the noise that was found if this is below 0.1 of the
    claimed one (``Answer.noise``). Many outliers that are kept hide this noise as well.

    After ``max_seconds`` of CPU time the best map so far is returned, with TIME_LIMIT as
    ``Answer.stop`` or as the ``stop`` of the certificate. Each stage takes at least one step.

    Raises:
        TypeError: ``graph`` is not a pose graph.
        ValueError: ``probability`` is not inside (0, 1), ``kind`` is unknown, or
            ``max_seconds`` is negative.

    Source: Mangelson et al. 2018 for PCM, Yang et al. 2020 for GNC, Rosen et al. 2019 for
    the certificate; in this order as in the SLAM Handbook 2026, chapter 3. Antonante et al.
    2022 estimate the noise in a similar way.

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
    deadline = Deadline.after(max_seconds)
    with stages(progress) as tell:
        found, noise, scale = _classified(graph, threshold, kind, tell, deadline)
        tell("the certificate is computed")
        poses, certificate = _certified(graph, found, deadline)
    return Answer(
        graph=graph,
        poses=poses,
        stages=found,
        noise=noise,
        threshold=scale * threshold,
        certificate=certificate,
    )


def _classified(
    graph: PoseGraph, threshold: float, kind: Kind, tell: Progress, deadline: Deadline
) -> tuple[Classification, float, float]:
    """Return the inliers, their noise, and the scale of the deviations they were tested with."""
    found = classify(graph, threshold, kind, tell, deadline)
    noise, scale = found.noise(graph), 1.0
    for _ in range(1, _ROUNDS):
        smaller = _MARGIN * max(noise, _LEAST)
        if noise >= _LOOSE or 2.0 * smaller > scale or deadline.passed:
            break
        tell(f"the noise is {noise:.2g} of the claimed one, so closures are tested again")
        scale = smaller
        precise = replace(graph, information=graph.information / scale**2)
        found = classify(precise, threshold, kind, tell, deadline)
        noise = found.noise(graph)
    return found, noise, scale


def _certified(
    graph: PoseGraph, found: Classification, deadline: Deadline
) -> tuple[Array, Certificate]:
    """Return a minimum of the chordal cost of the kept edges, and its certificate."""
    inliers = select(graph, found.final.kept)
    if deadline.passed:
        return found.final.x, unproven(inliers, found.final.x)
    direct = certify(inliers, found.final.x, max_seconds=deadline.left)
    if direct[1].verdict is Verdict.CERTIFIED or deadline.passed:
        return direct
    # That may be a local minimum. Without outliers the chordal start is close to the optimum.
    climbed = solve_certified(inliers, start.chordal(inliers), max_seconds=deadline.left)
    return min(climbed, direct, key=lambda solution: solution[1].cost)
