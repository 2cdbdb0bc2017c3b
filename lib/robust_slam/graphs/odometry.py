"""Initial poses from the odometry alone or along a spanning tree, and trees of a pose graph.

Source: Hillis and Steele 1986, pointer doubling; Dijkstra 1959, shortest paths.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_array
from scipy.sparse.csgraph import depth_first_order, dijkstra

from robust_slam._arrays import Array, Indices, Mask, mask
from robust_slam.graphs.pose_graph import (
    PoseGraph,
    check_graph,
    check_weights,
    connected_parts,
    unreached,
)


def sessions(graph: PoseGraph) -> Indices:
    """Return for each pose the number ``(n,)`` of its session, from 0.

    A session is a set of poses that odometry connects: several drives, or a gap in the odometry,
    give several, which only closures join. They are numbered in the order of their first poses.

    >>> graph = PoseGraph(3, [[0, 1], [1, 2]], [[1, 0, 0]] * 2, np.eye(3), [True, False])
    >>> sessions(graph).tolist()
    [0, 0, 1]
    """
    return connected_parts(check_graph(graph).n, graph.edges[graph.is_odometry])


def dead_reckoning(graph: PoseGraph) -> Array:
    """Return the poses from the odometry alone, with pose 0 the identity.

    They are ``(n, 3)`` or ``(n, 3, 4)``. Odometry may have either direction and any order. Where
    it forms cycles, a path with the fewest edges counts.

    Raises:
        ValueError: no path of odometry leads to some pose.

    >>> graph = PoseGraph(3, [[0, 1], [1, 2]], [[1, 0, np.pi / 2], [1, 0, 0]], np.eye(3))
    >>> dead_reckoning(graph).round(3)
    array([[0.   , 0.   , 0.   ],
           [1.   , 0.   , 1.571],
           [1.   , 1.   , 1.571]])
    """
    if not check_graph(graph).odometry_joins_all:
        missing = int(unreached(graph, graph.is_odometry)[0])
        raise ValueError(
            f"graph: no path of odometry leads from pose 0 to pose {missing}; mark more edges in "
            "is_odometry, or take spanning_tree, which uses closures where odometry ends"
        )
    return spanning_tree(graph)


def accumulated_rotation(graph: PoseGraph, used: ArrayLike | None = None) -> float:
    """Return the largest deviation (rad) of a rotation along a tree of ``used`` edges.

    It is that of one axis, relative to pose 0, if the errors of the edges are independent, along
    ``used`` ``(m,)``, by default the odometry. Above about 1 rad the rotation is lost. These edges
    have to connect all poses.
    """
    chosen = graph.is_odometry if used is None else mask("used", used, len(graph.edges))
    check_weights(chosen.astype(np.float64), graph)
    forest = find_forest(graph, chosen, np.ones(len(graph.edges)), np.array([0]))
    d = graph.group.DIMENSION
    covariance = np.linalg.inv(graph.information)[:, d:, d:]
    variance = np.trace(covariance, axis1=1, axis2=2) / covariance.shape[-1]
    return float(np.sqrt(sums_along(forest, variance[forest.edge]).max()))


def spanning_tree(graph: PoseGraph, weights: ArrayLike | None = None) -> Array:
    """Return the poses ``(n, …)`` along a spanning tree, with pose 0 the identity.

    Of all paths from pose 0 to a pose it takes one with the fewest loop closures, and of these one
    with the fewest edges: a complete odometry gives dead reckoning. Ties are broken by the lowest
    edge index. Edges of weight 0 in ``weights`` ``(m,)`` are left out.

    Raises:
        ValueError: ``weights`` have the wrong shape, are not finite, or one is negative.
        Underdetermined: the edges with positive weight do not connect all poses.

    >>> graph = PoseGraph(3, [[0, 1], [0, 2]], [[1, 0, 0], [1, 1, 0]], np.eye(3))
    >>> spanning_tree(graph).tolist()
    [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]]
    """
    used = check_weights(weights, graph) > 0.0
    # A path has fewer than n edges, so closures of length n are minimised first.
    length = np.where(graph.is_odometry, 1.0, float(graph.n))
    return poses_along(graph, find_forest(graph, used, length, np.array([0])))


@dataclass(frozen=True, eq=False)
class Forest:
    """A tree for each connected part of a graph: ``parent`` ``(n,)`` and ``edge`` ``(n,)`` to it.

    A root is its own parent, with edge −1. ``part`` ``(n,)`` numbers the trees from 0 in the order
    of their smallest poses.
    """

    parent: Indices
    edge: Indices
    part: Indices


def find_forest(graph: PoseGraph, used: Mask, length: Array, roots: Indices) -> Forest:
    """Return the trees of shortest paths from ``roots`` over the edges that ``used`` marks.

    ``used`` ``(m,)`` is a mask; ``length`` ``(m,)`` holds whole numbers of at least 1;
    ``roots`` has one pose of each connected part. Ties are broken by the lowest edge index.
    """
    number = np.flatnonzero(used)
    ends = graph.edges[number]
    distance = _distances(graph.n, ends, length[number], roots)
    tails, heads = np.concatenate([ends, ends[:, ::-1]]).T
    number = np.concatenate([number, number])
    # Lengths are whole numbers, so shortest paths are recognised by equality.
    best = distance[tails] + length[number] == distance[heads]
    tails, heads, number = tails[best], heads[best], number[best]
    order = np.argsort(-number, kind="stable")
    parent, edge = np.arange(graph.n), np.full(graph.n, -1, dtype=np.intp)
    parent[heads[order]], edge[heads[order]] = tails[order], number[order]
    return Forest(parent, edge, connected_parts(graph.n, graph.edges[used]))


def _distances(n: int, edges: Indices, length: Array, roots: Indices) -> Array:
    """Return the length ``(n,)`` of the shortest path from a root to each pose."""
    low, high = np.sort(edges, axis=1).T
    # A sparse matrix sums duplicate entries, so only the shortest edge of a pair is kept.
    order = np.lexsort((length, high, low))
    kept = order[np.unique((low * n + high)[order], return_index=True)[1]]
    joined = csr_array((length[kept], (low[kept], high[kept])), shape=(n, n))
    return np.asarray(dijkstra(joined, directed=False, indices=roots, min_only=True), np.float64)


def poses_along(graph: PoseGraph, forest: Forest) -> Array:
    """Return the poses ``(n, …)`` along the trees, with each root the identity."""
    group = graph.group
    z = graph.measurement[forest.edge]
    forward = graph.edges[forest.edge, 1] == np.arange(graph.n)
    ahead = forward.reshape(-1, *(1,) * (z.ndim - 1))
    poses: Array = np.where(ahead, z, group.inverse(z))
    parent = forest.parent
    poses[parent == np.arange(graph.n)] = group.identity()
    # Each pose is known relative to an ancestor. Replacing the ancestor by its own ancestor
    # doubles the distance, so a path of 10000 edges takes 14 rounds instead of 10000.
    while np.any(parent[parent] != parent):
        poses, parent = group.compose(poses[parent], poses), parent[parent]
    return poses


def sums_along(forest: Forest, values: Array) -> Array:
    """Return for each pose the sum of ``values`` ``(n, …)`` from its root, not counted, to it."""
    total, parent = values.copy(), forest.parent
    total[parent == np.arange(parent.size)] = 0.0
    while np.any(parent[parent] != parent):
        total, parent = total + total[parent], parent[parent]
    return total


@dataclass(frozen=True, eq=False)
class Ancestors:
    """Answers which pose is the lowest common ancestor of two.

    ``number`` ``(n + 1,)`` is the place of each pose in depth-first ``order``. A pose n above all
    roots joins the trees.
    """

    number: Indices
    order: Indices
    _lowest: Indices

    @classmethod
    def of(cls, forest: Forest) -> Ancestors:
        """Return the ancestors of the poses in ``forest``."""
        n = forest.parent.size
        top = np.append(np.where(forest.parent == np.arange(n), n, forest.parent), n)
        tree = csr_array((np.ones(n, dtype=np.int8), (top[:-1], np.arange(n))), shape=(n + 1,) * 2)
        order = np.asarray(depth_first_order(tree, n, return_predecessors=False), dtype=np.intp)
        number = np.empty(n + 1, dtype=np.intp)
        number[order] = np.arange(n + 1)
        rows = [number[top[order]]]
        for reach in 2 ** np.arange(max(1, n).bit_length() - 1):
            further = np.concatenate([rows[-1][reach:], rows[-1][-reach:]])
            rows.append(np.minimum(rows[-1], further))
        return cls(number, order, np.stack(rows))

    def common(self, a: ArrayLike, b: ArrayLike) -> Indices:
        """Return the lowest common ancestor of poses ``a`` and ``b``, arrays of one shape.

        It is n where two poses are in different trees.

        Source: Bender and Farach-Colton 2000: in depth-first order the common ancestor has
        the lowest number among the parents of the poses behind the first, up to the second.
        """
        at, to = self.number[np.asarray(a)], self.number[np.asarray(b)]
        low, high = np.minimum(at, to), np.maximum(at, to)
        width = np.maximum(high - low, 1)
        level = np.frexp(width)[1] - 1
        left = self._lowest[level, np.minimum(low + 1, high)]
        right = self._lowest[level, np.maximum(high + 1 - (1 << level), 0)]
        found: Indices = self.order[np.where(low == high, low, np.minimum(left, right))]
        return found
