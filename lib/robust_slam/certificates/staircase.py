"""The Riemannian staircase on the chordal problem, a way out of local minima.

A stationary map without a certificate comes with a direction along which the cost falls at
the next rank, where the rotations have one more row. The staircase adds a row, steps along
the direction, descends, and rounds to a map. If the higher rank is not certified either, it
continues with the next rank. One or two ranks are usually enough.

Source: Boumal, Voroninski and Bandeira 2016, the staircase; Rosen et al. 2019, Algorithm 1
and Proposition 3, on pose graphs.
"""

import logging
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from robust_slam._arrays import Array
from robust_slam._deadline import Deadline
from robust_slam.certificates.chordal import ChordalProblem, lifted_cost, pose_blocks, project
from robust_slam.certificates.newton import Stop, descend
from robust_slam.certificates.optimality import MAX_SECONDS, Certificate, Verdict, certify, judge
from robust_slam.descent.step import ROUNDING
from robust_slam.graphs.pose_graph import PoseGraph, check_poses
from robust_slam.groups.rotations import nearest_stiefel

_log = logging.getLogger(__name__)
_NEAR = 1e-8
"""The stationarity tolerance at a higher rank; maps are polished further."""
_LEAST_DECREASE = 1e-12
"""A step at a higher rank that lowers the cost by a smaller share is the last."""
_HALVINGS = 40


def solve_certified(
    graph: PoseGraph,
    poses: ArrayLike,
    weights: ArrayLike | None = None,
    *,
    max_climbs: int = 5,
    max_seconds: float = MAX_SECONDS,
) -> tuple[Array, Certificate]:
    """Return the best map that the staircase finds from ``poses``, and its certificate.

    ``poses``, ``(n, 3)`` or ``(n, 3, 4)``, are the start, and pose 0 is fixed;
    ``weights`` ``(m,)`` multiply κ and τ and are 1 if None. The map is polished first. If
    it is not certified, the staircase climbs at most ``max_climbs`` ranks. The cost is never
    higher than that of the polished start. Where the relaxation is not tight the verdict is
    NOT_CERTIFIED, with the best ``lower_bound`` that was found.

    It ends after about ``max_seconds`` of CPU time with the best map so far. ``stop`` of the
    certificate gives the reason: of the last polish where the map is certified, otherwise
    LOOSE, ITERATION_LIMIT or TIME_LIMIT. Each rank is logged at the level INFO.

    The certificate is about the weighted edges, not about outliers: see ``certificate``.

    Raises:
        ValueError: ``poses`` or ``weights`` have the wrong shape or are not finite, a
            weight is negative, or ``max_climbs`` or ``max_seconds`` is below 0.
        Underdetermined: the edges with positive weight do not connect all poses.

    Source: Boumal, Voroninski and Bandeira 2016; Rosen et al. 2019, Algorithms 1 and 2.
    """
    if max_climbs < 0:
        raise ValueError(f"max_climbs is {max_climbs}; give at least 0")
    deadline = Deadline.after(max_seconds)
    found = certify(graph, check_poses("poses", poses, graph), weights, max_seconds=max_seconds)
    problem = ChordalProblem.of(graph, weights)
    blocks, relaxed = pose_blocks(found[0]), found[1]
    _report(problem.d, found[1])
    for _ in range(max_climbs):
        if found[1].verdict is Verdict.CERTIFIED:
            return found
        direction = relaxed.direction
        higher = None if direction is None else climb(problem, blocks, direction)
        if higher is None:
            return _stopped(found, Stop.LOOSE)
        descent = descend(
            problem, higher, _NEAR, least_decrease=_LEAST_DECREASE, max_seconds=deadline.left
        )
        blocks = descent.last.blocks
        relaxed = judge(problem, blocks)
        near = rounded(graph, blocks, found[0])
        new = certify(graph, near, weights, max_seconds=deadline.left)
        found = _better(found, new, relaxed)
        _report(blocks.shape[1], found[1])
        if deadline.passed and found[1].verdict is not Verdict.CERTIFIED:
            return _stopped(found, Stop.TIME_LIMIT)
    return (
        found if found[1].verdict is Verdict.CERTIFIED else _stopped(found, Stop.ITERATION_LIMIT)
    )


def _stopped(found: tuple[Array, Certificate], stop: Stop) -> tuple[Array, Certificate]:
    return found[0], replace(found[1], stop=stop)


def _report(rank: int, certificate: Certificate) -> None:
    _log.info(
        "rank %d: the best map costs %.9g, no map less than %.9g",
        rank,
        certificate.cost,
        certificate.lower_bound,
    )


def _better(
    old: tuple[Array, Certificate], new: tuple[Array, Certificate], relaxed: Certificate
) -> tuple[Array, Certificate]:
    """Return the cheaper map with the best lower bound; every lower bound holds for all maps."""
    best, certificate = new if new[1].cost <= old[1].cost * (1.0 + ROUNDING) else old
    floor = max(old[1].lower_bound, new[1].lower_bound, relaxed.lower_bound)
    return best, replace(certificate, lower_bound=floor)


def climb(problem: ChordalProblem, blocks: Array, direction: Array) -> Array | None:
    """Return ``blocks`` ``(n, r, d + 1)`` one rank higher, where the cost is lower.

    None if rounding hides every decrease: then ``blocks`` are at the relaxation's minimum.

    The new row is a multiple of ``direction`` ``(n, d + 1)``, halved until the cost falls.
    At a stationary point it does fall: the cost changes by the square of the multiple times
    tr(direction S directionᵀ) < 0, and by its fourth power.

    Source: Boumal, Voroninski and Bandeira 2016, the escape from a saddle one rank higher.
    """
    here = lifted_cost(problem, blocks)
    level = np.concatenate([blocks, np.zeros_like(blocks[:, :1])], axis=1)
    rotation = direction[:, : problem.d]
    row = direction / np.sqrt(np.max(np.sum(rotation**2, axis=1)))
    for halvings in range(_HALVINGS):
        moved = level.copy()
        moved[:, -1] = row * 0.5**halvings
        moved[..., : problem.d] = nearest_stiefel(moved[..., : problem.d])
        if lifted_cost(problem, moved) < here:
            return moved
    return None


def rounded(graph: PoseGraph, blocks: Array, like: Array) -> Array:
    """Return the map near ``blocks`` ``(n, r, d + 1)``, with pose 0 as in ``like``.

    ``like`` and the result are poses, ``(n, 3)`` or ``(n, 3, 4)``.

    Source: Rosen et al. 2019, Algorithm 2.
    """
    near = project(blocks)
    motion = graph.group.compose(like[0], graph.group.inverse(near[0]))
    poses = graph.group.compose(motion, near)
    poses[0] = like[0]
    return poses
