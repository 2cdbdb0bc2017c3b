"""Pairwise consistency maximisation: a largest set of mutually consistent closures.

Two closures z_p: i_p → j_p and z_q: i_q → j_q and the odometry O between their ends make
a cycle. Its error e = Log(z_p ∘ O(j_p→j_q) ∘ z_q⁻¹ ∘ O(i_q→i_p)) is zero for exact
measurements, and a pair is consistent when √(eᵀ Σ⁻¹ e) is at most γ, with Σ the covariance
of e to first order. PCM keeps a largest set of pairwise consistent closures: a maximum
clique.

Limitations:

- Pairwise consistent closures may be inconsistent as a group: three closures may pass in
  pairs and contradict each other together (Forsgren et al. 2022).
- The largest set is kept. A large group of mutually consistent outliers can be larger than
  the set of inliers, and a single closure is consistent with itself.
- Σ grows with the odometry in the cycle, so a long cycle passes too easily. All closures
  should have the same direction, from the earlier pose to the later one: with opposite
  directions the cycle contains more odometry.

Computation (derived here). With x the poses from dead reckoning, a closure displaces the
world behind it by G = x_i ∘ z ∘ x_j⁻¹. The cycle, conjugated, is G_q⁻¹ ∘ G_p: two closures
are consistent when their displacements are equal. Each part is perturbed on the right and
transformed to the world frame, where odometry step k, from pose k to k + 1 with covariance
Σ_k, contributes Ad(x_{k+1}) Σ_k Ad(x_{k+1})ᵀ. With S the sums of these from pose 0, the
odometry between a and b has the covariance P(a, b) = S_max(a,b) − S_min(a,b), and a closure
has Q = Ad(x_j) Σ_z Ad(x_j)ᵀ. With A_q = Ad(G_q⁻¹) the cycle has the covariance

    Q_p + Q_q + P(j_p, j_q) + A_q P(i_p, i_q) A_qᵀ

if its four parts are independent. Both odometry parts may contain the same steps, though:
with W the covariance of the common steps, the term ± (W A_qᵀ + A_q W) is missing, + where
both have the same direction. The distance is the same in every frame, and the Jacobian of
Log cancels, since Jr(e) e = e.

Source: Mangelson, Dominic, Eustice and Vasudevan 2018; SLAM Handbook 2026, (3.6) to (3.8).
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
    """The closures that PCM keeps, and the consistency graph.

    ``kept`` ``(M,)`` marks edges of the graph: every edge that was not compared, and the
    clique. ``closures`` ``(m,)`` are the edges that were compared, ``adjacency`` ``(m, m)``
    which of them are consistent, and ``clique`` the set that was found. Its members are
    indices into ``closures``, and ``clique.proven`` tells whether it is proven optimal.
    """

    kept: Mask
    closures: Indices
    adjacency: Mask
    clique: Clique


@dataclass(frozen=True, eq=False)
class _Displacements:
    """The displacements of m closures in the world frame; D is 3 in SE(2) and 6 in SE(3).

    ``ends`` ``(m, 2)``; ``move`` ``(m, …)`` is G; ``adjoint`` ``(m, D, D)`` Ad(G⁻¹);
    ``own`` ``(m, D, D)`` Q; ``accumulated`` ``(n, D, D)`` the sums S at every pose.
    """

    ends: Indices
    move: Array
    adjoint: Array
    own: Array
    accumulated: Array


def pairwise_distances(
    graph: PoseGraph, closures: ArrayLike | None = None, *, shared_odometry: bool = False
) -> Array:
    """Return the Mahalanobis distance √(eᵀ Σ⁻¹ e) of each pair, ``(m, m)``, without a unit.

    ``closures`` is a mask ``(M,)`` of the edges to compare, by default all that are not
    odometry; row p is the p-th of them. For p < q the cycle begins with z_p: where edges
    stand in another order, its error is the inverse one, and as Σ is of first order the
    distance differs a little. For a pair of inliers the square is χ² with 3 degrees of freedom
    in SE(2) and 6 in SE(3), to first order. The matrix is symmetric with a zero diagonal.
    ``shared_odometry`` accounts for odometry steps in both parts of the cycle, which is exact
    to first order; the paper assumes that the parts are independent.

    Raises:
        ValueError: the mask does not fit or marks odometry, or no odometry edge (k, k + 1)
            leads to some pose k + 1.

    Source: Mangelson et al. 2018; SLAM Handbook 2026, (3.6) to (3.8); the shared odometry is
    derived here, see the module.
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
    """Return which pairs of closures are consistent, ``(m, m)``, the diagonal True.

    ``gamma`` is compared with the norm, not with its square: see
    ``thresholds.chi_square_threshold``. The other arguments are those of
    ``pairwise_distances``; here the distances are not stored.

    Raises:
        ValueError: ``gamma`` is not above 0, or as ``pairwise_distances``.

    Source: Mangelson et al. 2018; SLAM Handbook 2026, (3.6) to (3.8).
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
    """Return a largest set of pairwise consistent closures of ``graph``.

    ``gamma`` is the largest distance of a consistent pair, by default the one that a pair of
    inliers does not exceed with ``probability``. ``trusted`` ``(M,)`` marks closures that
    must be in the set. ``budget`` limits the search as in ``max_clique``: when it is used up,
    the best set found so far is returned, and ``clique.proven`` is False.

    It does not test a closure against the odometry alone, nor the set jointly, and it
    prefers a larger group of consistent outliers. See the module.

    Raises:
        ValueError: ``gamma`` is not above 0, ``probability`` is not inside (0, 1),
            ``budget`` is below 1, trusted closures contradict each other, or no odometry
            edge (k, k + 1) leads to some pose k + 1.

    Source: Mangelson et al. 2018; SLAM Handbook 2026, (3.6) to (3.8).

    >>> from robust_slam.graphs import add_random_closures, manhattan
    >>> rng = np.random.default_rng(0)
    >>> graph, is_outlier = add_random_closures(manhattan(60, rng, closures=15)[0], 8, rng)
    >>> result = pcm(graph)
    >>> int(result.kept[is_outlier].sum()), result.clique.proven
    (0, True)
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
    world = _displacements(graph, chosen)
    rows = 1 + _CHUNK // (chosen.size + 1)
    for first in range(0, chosen.size, rows):
        block = np.arange(first, min(first + rows, chosen.size))
        q, p = np.nonzero(np.arange(chosen.size) < block[:, None])
        q += first
        yield p, q, _distances(graph, world, p, q, shared)


def _displacements(graph: PoseGraph, chosen: Indices) -> _Displacements:
    group = graph.group
    poses, accumulated = _accumulate(graph)
    ends = graph.edges[chosen]
    start, end = poses[ends[:, 0]], poses[ends[:, 1]]
    move = group.compose(group.compose(start, graph.measurement[chosen]), group.inverse(end))
    own = _transformed(group.adjoint(end), _covariances(graph, chosen))
    return _Displacements(ends, move, group.adjoint(group.inverse(move)), own, accumulated)


def _accumulate(graph: PoseGraph) -> tuple[Array, Array]:
    """Return the centred poses from dead reckoning, and the sums S ``(n, D, D)``.

    The distances do not depend on the world frame, but entries grow with the square of the
    distance to its origin. The origin is placed at the mean position to limit rounding.
    """
    group = graph.group
    poses = dead_reckoning(graph)
    centre = group.translation(poses).mean(axis=0)
    unrotated = group.rotation(group.identity())
    poses = group.compose(group.from_parts(unrotated, -centre), poses)
    covariance = _covariances(graph, _steps(graph))
    accumulated = np.zeros((graph.n, group.DOF, group.DOF))
    accumulated[1:] = np.cumsum(_transformed(group.adjoint(poses[1:]), covariance), axis=0)
    return poses, accumulated


def _steps(graph: PoseGraph) -> Indices:
    """Return the odometry edges ``(n − 1,)`` that lead to poses 1, 2, …; the first of each."""
    i, j = graph.edges.T
    steps = np.flatnonzero(graph.is_odometry & (j == i + 1))
    _, first = np.unique(j[steps], return_index=True)
    return steps[first]


def _covariances(graph: PoseGraph, edges: Indices) -> Array:
    return np.asarray(np.linalg.inv(graph.information[edges]), dtype=np.float64)


def _distances(
    graph: PoseGraph, world: _Displacements, p: Indices, q: Indices, shared: bool
) -> Array:
    group = graph.group
    error = group.log(group.between(world.move[q], world.move[p]))
    covariance = world.own[p] + world.own[q] + _odometry(world, p, q, shared)
    weighted = np.linalg.solve(covariance, error[..., None])[..., 0]
    squared: Array = np.sum(error * weighted, axis=-1)
    return np.sqrt(np.maximum(squared, 0.0))


def _odometry(world: _Displacements, p: Indices, q: Indices, shared: bool) -> Array:
    """Return the covariance of the two odometry parts of each cycle, ``(…, D, D)``."""
    low, high = np.minimum(world.ends[p], world.ends[q]), np.maximum(world.ends[p], world.ends[q])
    by_i, by_j = _between(world.accumulated, low, high)
    a = world.adjoint[q]
    if not shared:
        return by_j + _transformed(a, by_i)
    first, last = low.max(axis=1), np.maximum(high.min(axis=1), low.max(axis=1))
    both = world.accumulated[last] - world.accumulated[first]
    # O(j_p→j_q) and O(i_q→i_p) have the same direction when one pair of ends encloses the other.
    forward = world.ends[p] < world.ends[q]
    sign = np.where(forward[:, 0] == forward[:, 1], -1.0, 1.0)[:, None, None]
    unit = np.eye(a.shape[-1])
    apart: Array = by_j - both + _transformed(a, by_i - both)
    return apart + _transformed(unit + sign * a, both)


def _between(accumulated: Array, low: Indices, high: Indices) -> tuple[Array, Array]:
    by_i, by_j = (accumulated[high[:, end]] - accumulated[low[:, end]] for end in (0, 1))
    return by_i, by_j


def _transformed(adjoint: Array, covariance: Array) -> Array:
    """Return Ad Σ Adᵀ."""
    return np.asarray(adjoint @ covariance @ np.swapaxes(adjoint, -1, -2))
