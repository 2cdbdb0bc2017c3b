"""Initial poses from the odometry alone or along a spanning tree.

Source: Hillis and Steele 1986, pointer doubling; Dijkstra 1959, shortest paths.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from robust_slam._arrays import Array, Indices, mask
from robust_slam.graphs.forest import find_forest, poses_along, sums_along
from robust_slam.graphs.pose_graph import (
    PoseGraph,
    check_graph,
    check_weights,
    connected_parts,
    unreached,
)

_ROOT = np.array([0])


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
    ones = np.ones(len(graph.edges))
    return poses_along(graph, find_forest(graph, graph.is_odometry, ones, _ROOT))


def accumulated_rotation(graph: PoseGraph, used: ArrayLike | None = None) -> float:
    """Return the largest deviation (rad) of a rotation along a tree of ``used`` edges.

    It is that of one axis, relative to pose 0, if the errors of the edges are independent, along
    ``used`` ``(m,)``, by default the odometry. Above about 1 rad the rotation is lost. These edges
    have to connect all poses.

    >>> graph = PoseGraph(3, [[0, 1], [1, 2]], [[1, 0, 0]] * 2, np.diag([1, 1, 4]))
    >>> round(accumulated_rotation(graph), 4)
    0.7071
    """
    chosen = graph.is_odometry if used is None else mask("used", used, len(graph.edges))
    check_weights(chosen.astype(np.float64), graph)
    forest = find_forest(graph, chosen, np.ones(len(graph.edges)), _ROOT)
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
    return poses_along(graph, find_forest(graph, used, length, _ROOT))
