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
- Σ grows with the odometry in the cycle, so a long cycle passes too easily.
- A test of pairs has the given probability for each pair. An inlier is compared with many
  others, so more inliers are lost than the probability suggests.

Every closure is taken in the direction of travel, from the pose that the odometry reaches
first to the other: with opposite directions the cycle would contain more odometry. So it
does not matter in which direction a closure is written.

The odometry is a spanning tree of the odometry edges, whichever their direction, rooted
where the drive begins. Where it has gaps, each connected part is a session with a tree of
its own. Two closures are compared when both join the same two sessions, as in PCM for
several robots; others do not contradict each other.

Computation (derived here). With x the poses from dead reckoning, each in the frame of its
session, a closure displaces the world behind it by G = x_i ∘ z ∘ x_j⁻¹. The cycle,
conjugated, is G_q⁻¹ ∘ G_p: two closures are consistent when their displacements are equal.
Each part is perturbed on the right and transformed to the world frame, where an odometry
edge that ends at pose k with covariance Σ_z contributes Ad(x_k) Σ_z Ad(x_k)ᵀ. With S(a) the
sum of these from the root to pose a, and c the lowest common ancestor of a and b, the odometry
between a and b has the covariance P(a, b) = S(a) + S(b) − 2 S(c). A closure has
Q = Ad(x_j) Σ_z Ad(x_j)ᵀ. With A_q = Ad(G_q⁻¹) the cycle has the covariance

    Q_p + Q_q + P(j_p, j_q) + A_q P(i_p, i_q) A_qᵀ

if its four parts are independent, as the paper assumes; odometry in both parts makes them
dependent. The distance is the same in every frame, and the Jacobian of Log cancels, since
Jr(e) e = e.

Source: Mangelson, Dominic, Eustice and Vasudevan 2018; SLAM Handbook 2026, (3.6) to (3.8).
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import inf

import numpy as np
from numpy.typing import ArrayLike

from robust_slam._arrays import Array, Indices, Mask, mask, positive
from robust_slam._deadline import Deadline
from robust_slam._words import counted
from robust_slam.consistency.cliques import Clique, max_clique
from robust_slam.estimators.thresholds import chi_square_threshold
from robust_slam.graphs.odometry import (
    Ancestors,
    Forest,
    find_forest,
    poses_along,
    sessions,
    sums_along,
)
from robust_slam.graphs.pose_graph import PoseGraph, check_graph

PAIRS = {2: 2_000_000, 3: 400_000}
"""The number of pairs that are compared, by dimension: a few seconds of work."""
_CHUNK = 20_000
"""Pairs that are computed at a time: their 6×6 matrices stay in the cache."""


@dataclass(frozen=True, eq=False)
class Block:
    """Closures that were compared with each other.

    ``members`` ``(k,)`` are their places among the closures of ``PcmResult``, ascending, and
    ``consistent`` ``(k, k)`` tells which pairs are.
    """

    members: Indices
    consistent: Mask


@dataclass(frozen=True, eq=False, repr=False)
class PcmResult:
    """The closures that PCM keeps, and the consistency graph.

    ``kept`` ``(M,)`` marks edges of the graph: every edge that was not compared, and the clique.
    ``closures`` ``(m,)`` are the edges that were compared, and ``clique`` the set that was found.
    Its members are indices into ``closures``, and ``clique.proven`` tells whether it is proven
    optimal; ``select(graph, result.kept)`` is the graph to solve. ``blocks`` are the closures that
    were compared with each other: two of different blocks were not, since they join other sessions
    or since there are more pairs than the budget allows, and count as consistent. ``complete`` is
    False in the latter case, and where the time did not suffice for all pairs of a block; these
    count as consistent too.
    """

    kept: Mask
    closures: Indices
    blocks: tuple[Block, ...]
    clique: Clique
    complete: bool

    def __repr__(self) -> str:
        agree = f"{self.clique.members.size:,} of {counted(self.closures.size, 'closure')} agree"
        return f"<PcmResult: {agree}, {self.kept.sum():,} of {self.kept.size:,} edges kept>"

    @property
    def adjacency(self) -> Mask:
        """Which pairs of closures are consistent, ``(m, m)``, the diagonal True."""
        joined = np.ones((self.closures.size, self.closures.size), dtype=np.bool_)
        for block in self.blocks:
            joined[np.ix_(block.members, block.members)] = block.consistent
        return joined


@dataclass(frozen=True, eq=False)
class _Displacements:
    """The displacements of m closures in the world frame; D is 3 in SE(2) and 6 in SE(3).

    ``ends`` ``(m, 2)``, in the direction of travel; ``move`` ``(m, …)`` is G; ``adjoint``
    ``(m, D, D)`` Ad(G⁻¹); ``own`` ``(m, D, D)`` Q; ``accumulated`` ``(n + 1, D, D)`` the sums
    S at every pose, and 0 above the roots; ``turned`` ``(m,)`` and ``turns`` ``(n + 1,)`` are the
    traces of both in the rotation; ``ancestors`` those of the odometry's trees.
    """

    ends: Indices
    move: Array
    adjoint: Array
    own: Array
    accumulated: Array
    turned: Array
    turns: Array
    ancestors: Ancestors


def pairwise_distances(
    graph: PoseGraph, closures: ArrayLike | None = None, *, most: float = inf
) -> Array:
    """Return the Mahalanobis distance √(eᵀ Σ⁻¹ e) of each pair, ``(m, m)``, without a unit.

    ``closures`` is a mask ``(M,)`` of the edges to compare, by default all that are not
    odometry; row p is the p-th of them. For p < q the cycle begins with z_p: where the edges
    are in another order, its error is the inverse one, and as Σ is of first order the
    distance differs a little. For a pair of inliers whose loops overlap in time the square is χ²
    with 3 degrees of freedom in SE(2) and 6 in SE(3), to first order. Where one loop ends before
    the other begins, the odometry in between is in both parts of the cycle, so that it is counted
    twice and the distance is smaller. The matrix is symmetric with a zero diagonal, and
    0 too where two closures join different sessions. A distance above ``most`` may be inf, for
    less work.

    Raises:
        ValueError: the mask does not fit or marks odometry.
    """
    chosen = _chosen(graph, closures)
    distances = np.zeros((chosen.size, chosen.size))
    world, session = _displacements(graph, chosen)
    for members in _groups(session):
        for p, q, distance in _pairs(graph, world, members, most):
            distances[p, q] = distances[q, p] = distance
    return distances


def total_distances(graph: PoseGraph, closures: ArrayLike) -> Array:
    """Return the sum ``(M,)`` of each closure's distances to all it can be compared with.

    ``closures`` is a mask ``(M,)`` as in ``pairwise_distances``; here the distances are not
    stored, and other edges have the sum 0. The smallest sum belongs to the closure in the
    middle of the others.

    Raises:
        ValueError: the mask does not fit or marks odometry.

    Source: Kaufman and Rousseeuw 1987, the medoid.
    """
    chosen = _chosen(graph, closures)
    world, session = _displacements(graph, chosen)
    totals = np.zeros(len(graph.edges))
    for members in _groups(session):
        for p, q, distance in _pairs(graph, world, members):
            np.add.at(totals, chosen[p], distance)
            np.add.at(totals, chosen[q], distance)
    return totals


def pairwise_consistent(graph: PoseGraph, gamma: float, closures: ArrayLike | None = None) -> Mask:
    """Return which pairs of closures are consistent, ``(m, m)``, the diagonal True.

    ``gamma`` is compared with the norm, not with its square: see
    ``estimators.chi_square_threshold``. ``closures`` is a mask ``(M,)`` of the edges to compare,
    by default all that are not odometry.

    Raises:
        ValueError: ``gamma`` is not above 0, or the mask does not fit or marks odometry.

    Source: Mangelson et al. 2018; SLAM Handbook 2026, (3.6) to (3.8).
    """
    limit = positive("gamma", gamma)
    return np.asarray(pairwise_distances(graph, closures, most=limit) <= limit)


def pcm(
    graph: PoseGraph,
    gamma: float | None = None,
    *,
    probability: float = 0.99,
    max_seconds: float = inf,
) -> PcmResult:
    """Return a largest set of pairwise consistent closures of ``graph``.

    ``gamma`` is the largest distance of a consistent pair, by default the one that a pair of
    inliers does not exceed with ``probability``. That is the probability of each pair: an inlier
    is compared with many others, so the set holds a smaller share of the inliers. Where the budget
    of ``max_clique`` is used up, the best set found so far is returned, and ``clique.proven`` is
    False. Where there are more pairs than a few seconds allow, closures are compared in blocks
    along the drive, each has a largest set of its own, and ``complete`` is False. After
    ``max_seconds`` of CPU time the remaining pairs are not compared either, and the search ends
    with the best set so far.

    It does not test a closure against the odometry alone, nor the set jointly, and it
    prefers a larger group of consistent outliers. See the module.

    Raises:
        ValueError: ``gamma`` is not above 0, ``probability`` is not inside (0, 1), or
            ``max_seconds`` is negative.

    Source: Mangelson et al. 2018; SLAM Handbook 2026, (3.6) to (3.8).

    >>> from robust_slam.graphs import add_random_closures, manhattan
    >>> rng = np.random.default_rng(0)
    >>> graph, is_outlier = add_random_closures(manhattan(60, rng, closures=15)[0], 8, rng)
    >>> result = pcm(graph)
    >>> int(result.kept[is_outlier].sum()), result.clique.proven
    (0, True)
    """
    limit = chi_square_threshold(probability, check_graph(graph).group.DOF)
    limit = limit if gamma is None else positive("gamma", gamma)
    closures = _chosen(graph, None)
    deadline = Deadline.after(max_seconds)
    blocks, complete = _compared(graph, closures, limit, deadline)
    clique = _largest(blocks, deadline)
    kept = graph.is_odometry.copy()
    kept[closures[clique.members]] = True
    return PcmResult(kept, closures, tuple(blocks), clique, complete)


def _largest(blocks: list[Block], deadline: Deadline) -> Clique:
    """Return a largest clique of each block, united, as places among all closures."""
    found = [max_clique(block.consistent, max_seconds=deadline.left) for block in blocks]
    members = [b.members[clique.members] for b, clique in zip(blocks, found, strict=True)]
    united = np.sort(np.concatenate([np.empty(0, dtype=np.intp), *members]))
    return Clique(united, all(c.proven for c in found), sum(c.bound for c in found))


def _chosen(graph: PoseGraph, closures: ArrayLike | None) -> Indices:
    m = len(check_graph(graph).edges)
    chosen = ~graph.is_odometry if closures is None else mask("closures", closures, m)
    if np.any(chosen & graph.is_odometry):
        k = int(np.argmax(chosen & graph.is_odometry))
        raise ValueError(f"closures: edge {k} is odometry; mark loop closures alone")
    return np.flatnonzero(chosen)


def _compared(
    graph: PoseGraph, chosen: Indices, gamma: float, deadline: Deadline
) -> tuple[list[Block], bool]:
    """Return the blocks of closures, and whether all comparable pairs were compared.

    Pairs that the ``deadline`` leaves uncompared count as consistent.
    """
    world, session = _displacements(graph, chosen)
    groups = _groups(session)
    parts = _cut(world, groups, PAIRS[graph.group.DIMENSION])
    blocks, complete = [], len(parts) == len(groups)
    for members in parts:
        consistent = np.ones((members.size, members.size), dtype=np.bool_)
        for p, q, distance in _pairs(graph, world, members, gamma):
            if deadline.passed:
                complete = False
                break
            at, to = np.searchsorted(members, p), np.searchsorted(members, q)
            consistent[at, to] = consistent[to, at] = distance <= gamma
        blocks.append(Block(members, consistent))
    return blocks, complete


def _groups(session: Indices) -> list[Indices]:
    """Return the closures, ascending, that join the same two sessions, for each such pair."""
    if not session.size:
        return []
    _, label = np.unique(session, axis=0, return_inverse=True)
    order = np.argsort(label, kind="stable")
    return np.split(order, np.flatnonzero(np.diff(label[order])) + 1)


def _cut(world: _Displacements, groups: list[Indices], pairs: int) -> list[Indices]:
    """Return ``groups``, large ones cut along the drive, with about ``pairs`` pairs in all."""
    if sum(members.size * (members.size - 1) for members in groups) // 2 <= pairs:
        return groups
    # Blocks of this size have m·size/2 pairs together, for m closures.
    size = max(2, 2 * pairs // sum(members.size for members in groups))
    parts: list[Indices] = []
    for members in groups:
        last = world.ancestors.number[world.ends[members]].max(axis=1)
        along = members[np.argsort(last, kind="stable")]
        parts.extend(np.sort(part) for part in np.array_split(along, -(-members.size // size)))
    return parts


def _pairs(
    graph: PoseGraph, world: _Displacements, members: Indices, most: float = inf
) -> Iterator[tuple[Indices, Indices, Array]]:
    """Yield p, q and the distance of every pair p < q of members, a bounded number at a time."""
    rows = 1 + _CHUNK // (members.size + 1)
    for first in range(0, members.size, rows):
        block = np.arange(first, min(first + rows, members.size))
        q, p = np.nonzero(np.arange(members.size) < block[:, None])
        p, q = members[p], members[q + first]
        yield p, q, _distances(graph, world, p, q, most)


def _displacements(graph: PoseGraph, chosen: Indices) -> tuple[_Displacements, Indices]:
    """Return the displacements, and the two sessions ``(m, 2)`` that each closure joins."""
    group = graph.group
    forest = _odometry_forest(graph)
    ancestors = Ancestors.of(forest)
    poses = _centred(graph, forest)
    ends, z, covariance = _in_direction_of_travel(graph, chosen, ancestors)
    start, end = poses[ends[:, 0]], poses[ends[:, 1]]
    move = group.compose(group.compose(start, z), group.inverse(end))
    own = _transformed(group.adjoint(end), covariance)
    accumulated = _accumulated(graph, forest, poses)
    adjoint = group.adjoint(group.inverse(move))
    d, both = group.DIMENSION, (own, accumulated)
    turned, turns = (np.trace(each[:, d:, d:], axis1=1, axis2=2) for each in both)
    world = _Displacements(ends, move, adjoint, own, accumulated, turned, turns, ancestors)
    return world, forest.part[ends]


def _odometry_forest(graph: PoseGraph) -> Forest:
    """Return a spanning tree of each session, rooted where its drive begins.

    That is the pose of smallest number with the fewest odometry edges, of these one that no
    odometry edge leads to.
    """
    used = graph.is_odometry
    session = sessions(graph)
    degree = np.bincount(graph.edges[used].ravel(), minlength=graph.n)
    entered = np.bincount(graph.edges[used, 1], minlength=graph.n) > 0
    order = np.lexsort((np.arange(graph.n), entered, degree, session))
    _, first = np.unique(session[order], return_index=True)
    return find_forest(graph, used, np.ones(len(graph.edges)), order[first])


def _centred(graph: PoseGraph, forest: Forest) -> Array:
    """Return the poses along the forest, moved so that their mean position is the origin.

    The distances do not depend on the world frame, but entries grow with the square of the
    distance to its origin.
    """
    group = graph.group
    poses = poses_along(graph, forest)
    centre = group.translation(poses).mean(axis=0)
    unrotated = group.rotation(group.identity())
    return group.compose(group.from_parts(unrotated, -centre), poses)


def _in_direction_of_travel(
    graph: PoseGraph, chosen: Indices, ancestors: Ancestors
) -> tuple[Indices, Array, Array]:
    """Return the ends ``(m, 2)``, measurements and covariances of closures, so directed."""
    group = graph.group
    ends, z = graph.edges[chosen].copy(), graph.measurement[chosen].copy()
    covariance = _covariances(graph, chosen)
    back = ancestors.number[ends[:, 0]] > ancestors.number[ends[:, 1]]
    # (z Exp(δ))⁻¹ = z⁻¹ Exp(−Ad(z) δ)
    covariance[back] = _transformed(group.adjoint(z[back]), covariance[back])
    z[back] = group.inverse(z[back])
    ends[back] = ends[back, ::-1]
    return ends, z, covariance


def _accumulated(graph: PoseGraph, forest: Forest, poses: Array) -> Array:
    """Return the sums S ``(n + 1, D, D)``, the last of them 0."""
    group = graph.group
    edge = np.flatnonzero(graph.is_odometry)
    own = _transformed(group.adjoint(poses[graph.edges[edge, 1]]), _covariances(graph, edge))
    each = np.zeros((len(graph.edges), group.DOF, group.DOF))
    each[edge] = own
    sums = sums_along(forest, each[forest.edge])
    return np.concatenate([sums, np.zeros((1, group.DOF, group.DOF))])


def _covariances(graph: PoseGraph, edges: Indices) -> Array:
    return np.asarray(np.linalg.inv(graph.information[edges]), dtype=np.float64)


def _distances(
    graph: PoseGraph, world: _Displacements, p: Indices, q: Indices, most: float
) -> Array:
    """Return the distances of pairs, infinite where the rotation alone is beyond ``most``.

    Its variance in all directions together is at least that in the direction of the error, and the
    same in every frame; the other components can only add to the distance.
    """
    error = graph.group.log(graph.group.between(world.move[q], world.move[p]))
    distances, near = np.full(p.size, inf), np.arange(p.size)
    if most < inf:
        angle = error[:, graph.group.DIMENSION :]
        variance = world.turned[p] + world.turned[q]
        for end in (0, 1):
            variance += _between(world, world.turns, world.ends[p, end], world.ends[q, end])
        near = np.flatnonzero(np.sum(angle**2, axis=1) <= most**2 * variance)
        p, q, error = p[near], q[near], error[near]
    (i_p, j_p), (i_q, j_q) = world.ends[p].T, world.ends[q].T
    sums = world.accumulated
    behind = _transformed(world.adjoint[q], _between(world, sums, i_p, i_q))
    covariance = world.own[p] + world.own[q] + _between(world, sums, j_p, j_q) + behind
    weighted = np.linalg.solve(covariance, error[..., None])[..., 0]
    distances[near] = np.sqrt(np.maximum(np.sum(error * weighted, axis=-1), 0.0))
    return distances


def _between(world: _Displacements, sums: Array, a: Indices, b: Indices) -> Array:
    """Return what ``sums`` ``(n + 1, …)`` from the roots are between poses ``a`` and ``b``."""
    return np.asarray(sums[a] + sums[b] - 2.0 * sums[world.ancestors.common(a, b)])


def _transformed(adjoint: Array, covariance: Array) -> Array:
    """Return Ad Σ Adᵀ."""
    return np.asarray(adjoint @ covariance @ np.swapaxes(adjoint, -1, -2))
