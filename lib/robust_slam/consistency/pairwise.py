"""Pairwise consistency maximisation: closures that agree with each other, two by two.

Two closures z_p: i_p → j_p and z_q: i_q → j_q and the odometry O between their ends make
a cycle. Its error e = Log(z_p ∘ O(j_p→j_q) ∘ z_q⁻¹ ∘ O(i_q→i_p)) is zero for exact
measurements, and a pair is consistent when √(eᵀ Σ⁻¹ e) is at most γ, with Σ the covariance
of e to first order. PCM keeps a largest set of closures that are consistent two by two:
a maximum clique.

What it does not say:

- Consistent two by two is not consistent all together: three closures may pass pair by
  pair and contradict each other as a whole (Forsgren et al. 2022).
- The largest set wins. A larger group of lies that agree with each other beats the truth,
  and a single closure agrees with itself.
- Σ grows with the odometry in the cycle, so a long cycle passes too easily. Let all
  closures point the same way, from the earlier pose to the later one: between two that
  point against each other the cycle goes the long way round.

How it is computed (derived here). With x the poses by dead reckoning, a closure says that
the world behind it should be moved by G = x_i ∘ z ∘ x_j⁻¹. The cycle, conjugated, is
G_q⁻¹ ∘ G_p: two closures agree when they ask for the same move. Let each part be perturbed
on the right and carried to the world's frame, where odometry step k, from pose k to k + 1
with covariance Σ_k, adds Ad(x_{k+1}) Σ_k Ad(x_{k+1})ᵀ. The odometry between a and b then
has P(a, b) = S_max(a,b) − S_min(a,b), S the sums of these from pose 0, and a closure has
Q = Ad(x_j) Σ_z Ad(x_j)ᵀ. With A_q = Ad(G_q⁻¹) the cycle has the covariance

    Q_p + Q_q + P(j_p, j_q) + A_q P(i_p, i_q) A_qᵀ

while its four parts are independent. Both odometry parts may run over the same steps,
though: with W the P of the steps in both, ± (W A_qᵀ + A_q W) is missing, + where both run
the same way. The distance is the same in every frame, and the derivative of Log drops out
of it, since Jr(e) e = e.

Source: Mangelson, Dominic, Eustice and Vasudevan 2018.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from robust_slam._arrays import Array, Indices, Mask, mask, positive
from robust_slam.consistency.cliques import BUDGET, Clique, max_clique
from robust_slam.estimators.thresholds import chi_square_threshold
from robust_slam.graphs.odometry import dead_reckoning
from robust_slam.graphs.pose_graph import PoseGraph

_CHUNK = 20_000
"""Pairs that are computed at a time: their 6×6 matrices stay in the cache."""


@dataclass(frozen=True, eq=False)
class PcmResult:
    """What PCM keeps, and what it decided from.

    ``kept`` ``(M,)`` marks edges of the graph: every edge that was not compared, and the
    clique. ``closures`` ``(m,)`` are the edges that were compared, ``adjacency`` ``(m, m)``
    which of them are consistent, and ``clique`` the set that was found: its members count
    within ``closures``, and it says whether it is proven to be a largest one.
    """

    kept: Mask
    closures: Indices
    adjacency: Mask
    clique: Clique


@dataclass(frozen=True, eq=False)
class _Votes:
    """Each of m closures in the world's frame; D is 3 in SE(2) and 6 in SE(3).

    ``ends`` ``(m, 2)``; ``move`` ``(m, …)`` is G; ``adjoint`` ``(m, D, D)`` Ad(G⁻¹);
    ``own`` ``(m, D, D)`` Q; ``walked`` ``(n, D, D)`` the sums S at every pose.
    """

    ends: Indices
    move: Array
    adjoint: Array
    own: Array
    walked: Array


def pairwise_distances(
    graph: PoseGraph, closures: ArrayLike | None = None, *, shared_odometry: bool = False
) -> Array:
    """Return how far each two closures disagree, √(eᵀ Σ⁻¹ e) ``(m, m)``, without a unit.

    ``closures`` is a mask ``(M,)`` of the edges to compare, by default all that are not
    odometry; row p is the p-th of them. For p < q the cycle begins with z_p: where edges
    stand in another order, its error is the inverse one, and as Σ is of first order the
    distance differs a little. An honest pair's square is χ² with 3 degrees of freedom in
    SE(2) and 6 in SE(3), to first order. The matrix is symmetric, its diagonal zero.
    ``shared_odometry`` counts steps that both odometry parts run over as the same steps,
    which is exact to first order; the paper takes the parts as independent.

    Raises:
        ValueError: the mask does not fit or marks odometry, or no odometry edge (k, k + 1)
            leads to some pose k + 1.

    Source: Mangelson et al. 2018; the shared odometry is derived here, see the module.
    """
    chosen = _chosen(graph, closures)
    distances = np.zeros((chosen.size, chosen.size))
    for p, q, distance in _pairs(graph, chosen, shared_odometry):
        distances[p, q] = distances[q, p] = distance
    return distances


def pairwise_consistent(
    graph: PoseGraph,
    gamma: float,
    closures: ArrayLike | None = None,
    *,
    shared_odometry: bool = False,
) -> Mask:
    """Return which closures are consistent two by two, ``(m, m)``, the diagonal True.

    ``gamma`` is compared with the norm, not with its square: see
    ``thresholds.chi_square_threshold``. The rest is as in ``pairwise_distances``; here
    the distances are not stored.

    Raises:
        ValueError: ``gamma`` is not above 0, or as ``pairwise_distances``.

    Source: Mangelson et al. 2018.
    """
    gamma = positive("gamma", gamma)
    return _adjacency(graph, _chosen(graph, closures), gamma, shared_odometry)


def pcm(
    graph: PoseGraph,
    gamma: float | None = None,
    *,
    probability: float = 0.99,
    trusted: ArrayLike | None = None,
    shared_odometry: bool = False,
    budget: int = BUDGET,
) -> PcmResult:
    """Return a largest set of closures of ``graph`` that are consistent two by two.

    ``gamma`` is the largest distance of a consistent pair, by default the one that an
    honest pair keeps with ``probability``. ``trusted`` ``(M,)`` marks closures that must
    be in the set. ``budget`` limits the search as in ``max_clique``: when it is used up,
    the best set found so far comes back, and ``clique.proven`` is False.

    It is no test of a closure against the odometry alone, and no joint test of the set;
    a larger group of lies that agree wins. See the module.

    Raises:
        ValueError: ``gamma`` is not above 0, ``probability`` is not inside (0, 1),
            ``budget`` is below 1, trusted closures contradict each other, or no odometry
            edge (k, k + 1) leads to some pose k + 1.

    Source: Mangelson et al. 2018.
    """
    limit = chi_square_threshold(probability, graph.group.DOF)
    limit = limit if gamma is None else positive("gamma", gamma)
    closures = _chosen(graph, None)
    held = mask("trusted", trusted, len(graph.edges))[closures]
    adjacency = _adjacency(graph, closures, limit, shared_odometry)
    _refuse_contradiction(closures[held], adjacency[np.ix_(held, held)])
    clique = max_clique(adjacency, fixed=np.flatnonzero(held), budget=budget)
    kept = graph.is_odometry.copy()
    kept[closures[clique.members]] = True
    return PcmResult(kept, closures, adjacency, clique)


def _chosen(graph: PoseGraph, closures: ArrayLike | None) -> Indices:
    m = len(graph.edges)
    chosen = ~graph.is_odometry if closures is None else mask("closures", closures, m)
    if np.any(chosen & graph.is_odometry):
        k = int(np.argmax(chosen & graph.is_odometry))
        raise ValueError(f"closures: edge {k} is odometry; mark loop closures alone")
    return np.flatnonzero(chosen)


def _refuse_contradiction(trusted: Indices, consistent: Mask) -> None:
    if not np.all(consistent):
        p, q = trusted[np.argwhere(~consistent)[0]]
        raise ValueError(
            f"trusted: the closures of edges {p} and {q} contradict each other; trust only "
            "one of them or raise gamma"
        )


def _adjacency(graph: PoseGraph, chosen: Indices, gamma: float, shared: bool) -> Mask:
    consistent = np.eye(chosen.size, dtype=np.bool_)
    for p, q, distance in _pairs(graph, chosen, shared):
        consistent[p, q] = consistent[q, p] = distance <= gamma
    return consistent


def _pairs(
    graph: PoseGraph, chosen: Indices, shared: bool
) -> Iterator[tuple[Indices, Indices, Array]]:
    """Yield p, q and the distance of every pair p < q, a bounded number at a time."""
    votes = _votes(graph, chosen)
    rows = 1 + _CHUNK // (chosen.size + 1)
    for first in range(0, chosen.size, rows):
        block = np.arange(first, min(first + rows, chosen.size))
        q, p = np.nonzero(np.arange(chosen.size) < block[:, None])
        q += first
        yield p, q, _distances(graph, votes, p, q, shared)


def _votes(graph: PoseGraph, chosen: Indices) -> _Votes:
    group = graph.group
    poses, walked = _walk(graph)
    ends = graph.edges[chosen]
    start, end = poses[ends[:, 0]], poses[ends[:, 1]]
    move = group.compose(group.compose(start, graph.measurement[chosen]), group.inverse(end))
    own = _carried(group.adjoint(end), _covariances(graph, chosen))
    return _Votes(ends, move, group.adjoint(group.inverse(move)), own, walked)


def _walk(graph: PoseGraph) -> tuple[Array, Array]:
    """Return the poses by dead reckoning around their middle, and the sums S ``(n, D, D)``.

    Any world frame gives the same distances; entries grow with the square of how far poses
    are from its origin, and digits are lost with them, so that is put in the middle.
    """
    group = graph.group
    poses = dead_reckoning(graph)
    middle = group.translation(poses).mean(axis=0)
    turn = group.rotation(group.identity())
    poses = group.compose(group.from_parts(turn, -middle), poses)
    covariance = _covariances(graph, _steps(graph))
    walked = np.zeros((graph.n, group.DOF, group.DOF))
    walked[1:] = np.cumsum(_carried(group.adjoint(poses[1:]), covariance), axis=0)
    return poses, walked


def _steps(graph: PoseGraph) -> Indices:
    """Return the odometry edges ``(n − 1,)`` that lead to poses 1, 2, …; the first of each."""
    i, j = graph.edges.T
    steps = np.flatnonzero(graph.is_odometry & (j == i + 1))
    _, first = np.unique(j[steps], return_index=True)
    return steps[first]


def _covariances(graph: PoseGraph, edges: Indices) -> Array:
    return np.asarray(np.linalg.inv(graph.information[edges]), dtype=np.float64)


def _distances(graph: PoseGraph, votes: _Votes, p: Indices, q: Indices, shared: bool) -> Array:
    group = graph.group
    error = group.log(group.between(votes.move[q], votes.move[p]))
    covariance = votes.own[p] + votes.own[q] + _odometry(votes, p, q, shared)
    pull = np.linalg.solve(covariance, error[..., None])[..., 0]
    squares: Array = np.sum(error * pull, axis=-1)
    return np.sqrt(np.maximum(squares, 0.0))


def _odometry(votes: _Votes, p: Indices, q: Indices, shared: bool) -> Array:
    """Return the covariance of the two odometry parts of each cycle, ``(…, D, D)``."""
    low, high = np.minimum(votes.ends[p], votes.ends[q]), np.maximum(votes.ends[p], votes.ends[q])
    by_i, by_j = _between(votes.walked, low, high)
    a = votes.adjoint[q]
    if not shared:
        return by_j + _carried(a, by_i)
    first, last = low.max(axis=1), np.maximum(high.min(axis=1), low.max(axis=1))
    both = votes.walked[last] - votes.walked[first]
    # O(j_p→j_q) and O(i_q→i_p) run the same way when one closure's ends enclose the other's.
    forward = votes.ends[p] < votes.ends[q]
    sign = np.where(forward[:, 0] == forward[:, 1], -1.0, 1.0)[:, None, None]
    unit = np.eye(a.shape[-1])
    apart: Array = by_j - both + _carried(a, by_i - both)
    return apart + _carried(unit + sign * a, both)


def _between(walked: Array, low: Indices, high: Indices) -> tuple[Array, Array]:
    by_i, by_j = (walked[high[:, end]] - walked[low[:, end]] for end in (0, 1))
    return by_i, by_j


def _carried(adjoint: Array, covariance: Array) -> Array:
    """Return Ad Σ Adᵀ."""
    return np.asarray(adjoint @ covariance @ np.swapaxes(adjoint, -1, -2))
