"""The whole back-end in one function: maps from several starts, the best of them, its certificate.

No robust method is best on all graphs, and the deviations that a file claims are often wrong.
``candidates`` therefore descends from odometry in several ways and at several scales of the noise,
``noise`` finds the scale that each map shows, and ``evidence`` chooses among the maps. The
certificate tells whether the map is optimal for the closures that were kept, and ``support``
whether the measurements single these out.

Source: the SLAM Handbook 2026, chapter 3, for the parts; their combination is derived here.
"""

from dataclasses import replace
from typing import Never

import numpy as np
from numpy.typing import ArrayLike

from robust_slam._arrays import Array, Mask, finite, positive
from robust_slam._deadline import Deadline
from robust_slam.certificates.optimality import (
    MAX_SECONDS,
    Certificate,
    Verdict,
    certify,
    unproven,
)
from robust_slam.certificates.staircase import solve_certified
from robust_slam.consistency.bridges import find_bridges
from robust_slam.consistency.pairwise import pcm
from robust_slam.descent import start
from robust_slam.estimators.result import StopReason
from robust_slam.estimators.thresholds import chi_square_threshold
from robust_slam.graphs.odometry import spanning_tree
from robust_slam.graphs.pose_graph import PoseGraph, check_graph, check_poses, select, unreached
from robust_slam.progress import Progress, stages
from robust_slam.solver.answer import Answer as Answer
from robust_slam.solver.candidates import Candidate, Search
from robust_slam.solver.evidence import outlier_entropy
from robust_slam.solver.noise import originals, rescaled
from robust_slam.solver.rivals import compared, contests, unbeaten
from robust_slam.solver.slips import find_slips
from robust_slam.solver.support import Support as Support
from robust_slam.solver.support import judge_support

_REACH = 1e6
"""Edges so many times as long as all poses in a row are beyond what double precision solves."""
_SEARCH = 0.7
"""This share of the time at most is spent before the certificate."""
_UNKNOWN = "solve() got an unexpected keyword argument '{}'"
_GONE = {
    "quick": "; one descent alone lost right closures: leave it out, or take "
    "rs.estimators.gnc where a map without a search and a proof is enough"
}


def solve(
    graph: PoseGraph,
    probability: float = 0.99,
    *,
    start: ArrayLike | None = None,
    threshold: float | None = None,
    prior: ArrayLike | None = None,
    find_noise: bool = True,
    progress: bool | Progress = False,
    max_seconds: float = MAX_SECONDS,
    **others: Never,
) -> Answer:
    """Return the map of ``graph`` without its outliers, its certificate and its support.

    DCS, Geman–McClure and GNC descend from odometry, over all closures, and GNC over those that
    PCM finds consistent as well. Truncated least squares then decides about all
    closures, and the map of the largest evidence is returned. Where most closures agree on the
    first map and no other is near it, or where DCS and Geman–McClure agree with much evidence, the
    others are left out.

    Parameters
    ----------
    graph
        Its odometry is trusted, except for steps that slipped (``Answer.slips``): they measured
        what other steps did not, or many closures contradict them, and without them the map has
        much more evidence. Where the odometry has gaps, it leaves several sessions: a tree of
        closures that agree with most others joins them, and these are trusted too
        (``Answer.bridges``).
    probability
        An inlier passes each test with it.
    start
        Poses ``(n, 3)`` or ``(n, 3, 4)`` from which all descend, in place of odometry.
    threshold
        The largest norm of an inlier, in place of the one that ``probability`` gives.
    prior
        What you know of each edge ``(m,)`` besides: 1 is right and never rejected, 0 is wrong and
        never kept, and of the others, ½, the measurements tell. No number between is taken,
        because the search keeps or rejects an edge as a whole and weighs no probabilities: a
        score of your recogniser has to become one of the three by a threshold of yours.
    find_noise
        The deviations that the file claims are a first guess only: those of odometry and
        closures, positions and rotations, are found from the kept edges (``Answer.noise``), and
        used for thresholds, weights and the certificate. If False the claims hold.
    progress
        True shows a bar, and a function is told each stage; stages are logged in any case.
    max_seconds
        After so much CPU time (s) the best map so far is returned, with TIME_LIMIT as
        ``Answer.stop`` or as the ``stop`` of the certificate. Each stage takes one step at least.

    Raises
    ------
    TypeError
        ``graph`` is not a pose graph, or there are ``others`` among the options.
    ValueError
        ``probability`` is not inside (0, 1), or ``max_seconds`` is negative, or a step of the
        odometry is so long beside the others that no map holds both; ``start``, ``threshold`` or
        ``prior`` does not fit, a prior is another number, or they leave poses that no edge joins.

    Source
    ------
    Geman and McClure 1985, Agarwal et al. 2013, Yang et al. 2020 and Mangelson et al. 2018 for
    the descents, Rosen et al. 2019 for the certificate.

    Examples
    --------
    >>> import numpy as np
    >>> from robust_slam.graphs import add_random_closures, manhattan
    >>> rng = np.random.default_rng(0)
    >>> graph, is_outlier = add_random_closures(manhattan(60, rng, closures=15)[0], 8, rng)
    >>> answer = solve(graph)
    >>> answer.certificate.verdict.value, int(np.sum(answer.kept & is_outlier))
    ('certified', 0)
    """
    check_graph(graph)
    for name in others:
        raise TypeError(_UNKNOWN.format(name) + _GONE.get(name, ""))
    known = _checked_prior(prior, graph)
    own = (originals(graph) == np.arange(len(graph.edges))) & ~_beyond_reach(graph) & (known > 0)
    if not np.all(own):
        part = solve(
            select(graph, own),
            probability,
            start=start,
            threshold=threshold,
            prior=known[own],
            find_noise=find_noise,
            progress=progress,
            max_seconds=max_seconds,
        )
        return part.about(graph, np.flatnonzero(own))
    if threshold is None:
        threshold = chi_square_threshold(probability, graph.group.DOF)
    threshold = positive("threshold", threshold)
    deadline = Deadline.after(max_seconds)
    with stages(progress) as tell:
        given = graph.is_odometry | (known == 1.0)
        trusted = given | _bridging(graph, threshold, tell, deadline)
        if start is None:
            x0 = spanning_tree(graph, trusted.astype(np.float64))
        else:
            poses = check_poses("start", start, graph)
            x0 = graph.group.between(poses[0], poses)
        entropy = outlier_entropy(graph)
        until = Deadline.after(_SEARCH * deadline.left)
        none = np.zeros(len(graph.edges), dtype=np.bool_)
        search = Search(
            graph, x0, given, trusted, threshold, find_noise, tell, until, entropy, none
        )
        candidates = search.candidates()
        first = best = search.refined(max(candidates, key=lambda one: one.evidence))
        tell("slips of the odometry are looked for")
        agreement = compared(search, best)
        search, best = find_slips(search, best, agreement)
        if best is not first:
            candidates.append(best)
            best = search.refined(best)
            agreement = compared(search, best)
        tell("rivals are looked for")
        found = list(contests(search, best, agreement))
        search, best, found = unbeaten(search, best, found)
        candidates.extend([best] if best.name == "rival" else [])
        judgement = judge_support(search, best, found)
        if until.passed:
            best = replace(best, stop=StopReason.TIME_LIMIT)
            judgement = replace(judgement, support=Support.WEAK, rival=None)
        tell("the certificate is computed")
        poses, certificate = _certified(rescaled(graph, best.found), best, deadline)
    return Answer(
        graph=graph,
        poses=poses,
        best=best,
        candidates=tuple(candidates),
        bridges=find_bridges(graph, search.trusted),
        threshold=threshold,
        certificate=certificate,
        support=judgement.support,
        rival=judgement.rival,
        misfit=judgement.misfit,
        lone=judgement.lone,
    )


def _checked_prior(prior: ArrayLike | None, graph: PoseGraph) -> Array:
    m = len(graph.edges)
    known = np.full(m, 0.5) if prior is None else finite("prior", prior, (m,))
    other = ~np.isin(known, (0.0, 0.5, 1.0))
    if np.any(other):
        k = int(np.argmax(other))
        raise ValueError(f"prior: edge {k} has {known[k]:g}; give 0, 0.5 or 1, from a threshold")
    return known


def _beyond_reach(graph: PoseGraph) -> Mask:
    """Return the closures ``(m,)`` that are too long for any map of such steps.

    Raises:
        ValueError: a step of the odometry, or what alone joins poses, is so long.
    """
    length = np.linalg.norm(graph.translation, axis=1)
    limit = _REACH * graph.n * float(np.median(length))
    far = (length > limit) & (limit > 0.0)
    if np.any(far & graph.is_odometry) or unreached(graph, ~far).size:
        k = int(np.flatnonzero(far)[np.argmax(graph.is_odometry[far])])
        i, j = graph.edges[k]
        raise ValueError(
            f"edge {k}, which joins poses {i} and {j}, measures {length[k]:.3g} m, and half of "
            f"all edges at most {np.median(length):.3g} m; correct it, or leave out what is "
            "behind it"
        )
    return np.asarray(far)


def _bridging(graph: PoseGraph, threshold: float, tell: Progress, deadline: Deadline) -> Mask:
    """Return the closures ``(m,)`` that join the sessions that the odometry leaves."""
    if graph.odometry_joins_all:
        return np.zeros(len(graph.edges), dtype=np.bool_)
    tell("PCM compares closures, for those that join sessions")
    bridges = find_bridges(graph, pcm(graph, threshold, max_seconds=deadline.left).kept)
    return np.isin(np.arange(len(graph.edges)), bridges.edges)


def _certified(graph: PoseGraph, best: Candidate, deadline: Deadline) -> tuple[Array, Certificate]:
    """Return a minimum of the chordal cost of the kept edges, and its certificate."""
    inliers = select(graph, best.kept)
    if deadline.passed:
        return best.poses, unproven(inliers, best.poses)
    direct = certify(inliers, best.poses, max_seconds=deadline.left)
    if direct[1].verdict is Verdict.CERTIFIED or deadline.passed:
        return direct
    # That may be a local minimum. Without outliers the chordal start is close to the optimum.
    climbed = solve_certified(inliers, start.chordal(inliers), max_seconds=deadline.left)
    return min(climbed, direct, key=lambda solution: solution[1].cost)
