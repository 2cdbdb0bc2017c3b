"""Initial poses from the odometry alone or along a spanning tree.

Source: Hillis and Steele 1986 for chains; Dijkstra 1959 for the tree.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from robust_slam._arrays import Array, Indices, Mask
from robust_slam.graphs.pose_graph import PoseGraph, check_weights


def dead_reckoning(graph: PoseGraph) -> Array:
    """Return the poses from the odometry alone, with pose 0 the identity.

    They are ``(n, 3)`` in SE(2) and ``(n, 3, 4)`` in SE(3).

    Raises:
        ValueError: no odometry edge (k, k + 1) leads to some pose k + 1.

    Source: Hillis and Steele 1986, "Data parallel algorithms", the prefix sum.

    >>> graph = PoseGraph(3, [[0, 1], [1, 2]], [[1, 0, np.pi / 2], [1, 0, 0]], [np.eye(3)] * 2,
    ...                   is_odometry=[True, True])
    >>> dead_reckoning(graph).round(3)
    array([[0.   , 0.   , 0.   ],
           [1.   , 0.   , 1.571],
           [1.   , 1.   , 1.571]])
    """
    i, j = graph.edges.T
    steps = np.flatnonzero(graph.is_odometry & (j == i + 1))
    edge = np.full(graph.n, -1, dtype=np.intp)
    edge[j[steps[::-1]]] = steps[::-1]
    if np.any(edge[1:] < 0):
        missing = 1 + int(np.argmax(edge[1:] < 0))
        raise ValueError(
            f"graph: no odometry edge leads from pose {missing - 1} to pose {missing}; "
            "mark it in is_odometry or give first poses"
        )
    group = graph.group
    poses = np.concatenate([group.identity()[None], graph.measurement[edge[1:]]])
    # Chains of 1, 2, 4, … steps: each round composes every chain with the one before it.
    reach = 1
    while reach < graph.n:
        poses[reach:] = group.compose(poses[:-reach], poses[reach:])
        reach *= 2
    return poses


def spanning_tree(graph: PoseGraph, weights: ArrayLike | None = None) -> Array:
    """Return the poses ``(n, …)`` along a spanning tree, with pose 0 the identity.

    Of all paths from pose 0 to a pose it takes one with the fewest loop closures, and of
    these one with the fewest edges: a complete odometry gives dead reckoning. Ties are
    broken by the lowest edge index. Edges of weight 0 in ``weights`` ``(m,)`` are left out;
    the other weights have no effect.

    Raises:
        ValueError: ``weights`` have the wrong shape, are not finite, or one is negative.
        Underdetermined: the edges with positive weight do not connect all poses.

    Source: Dijkstra 1959, shortest paths; the lengths are derived here.

    >>> graph = PoseGraph(3, [[0, 1], [0, 2]], [[1, 0, 0], [1, 1, 0]], [np.eye(3)] * 2,
    ...                   is_odometry=[True, False])
    >>> spanning_tree(graph).tolist()
    [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]]
    """
    used = check_weights(weights, graph) > 0.0
    parent, edge = _tree(graph, used)
    forward = graph.edges[edge, 1] == np.arange(graph.n)
    z = graph.measurement[edge]
    group = graph.group
    back = group.inverse(z)
    ahead = forward.reshape(-1, *(1,) * (z.ndim - 1))
    poses: Array = np.where(ahead, z, back)
    poses[0] = group.identity()
    # Each pose is known relative to an ancestor. Replacing the ancestor by its own ancestor
    # doubles the distance, so a path of 10000 edges takes 14 rounds instead of 10000.
    while np.any(parent > 0):
        poses = group.compose(poses[parent], poses)
        parent = parent[parent]
    return poses


def _tree(graph: PoseGraph, used: Mask) -> tuple[Indices, Indices]:
    """Return the parent of each pose in the tree and the edge to it, ``(n,)`` each.

    Pose 0 is its own parent, with edge 0.
    """
    # A path has fewer than n edges, so closures of length n are minimised first.
    length = np.where(graph.is_odometry, 1.0, float(graph.n))
    distance = _distances(graph.n, graph.edges[used], length[used])
    number = np.flatnonzero(used)
    ends = graph.edges[number]
    tails, heads = np.concatenate([ends, ends[:, ::-1]]).T
    number = np.concatenate([number, number])
    # Lengths are whole numbers, so shortest paths are recognised by equality.
    best = distance[tails] + length[number] == distance[heads]
    tails, heads, number = tails[best], heads[best], number[best]
    order = np.argsort(-number, kind="stable")
    parent, edge = np.zeros(graph.n, dtype=np.intp), np.zeros(graph.n, dtype=np.intp)
    parent[heads[order]], edge[heads[order]] = tails[order], number[order]
    return parent, edge


def _distances(n: int, edges: Indices, length: Array) -> Array:
    """Return the length ``(n,)`` of the shortest path from pose 0 to each pose."""
    low, high = edges.min(axis=1), edges.max(axis=1)
    # A sparse matrix sums duplicate entries, so only the shortest edge of a pair is kept.
    order = np.lexsort((length, high, low))
    _, first = np.unique((low * n + high)[order], return_index=True)
    kept = order[first]
    joined = csr_array((length[kept], (low[kept], high[kept])), shape=(n, n))
    return np.asarray(dijkstra(joined, directed=False, indices=[0])[0], dtype=np.float64)
