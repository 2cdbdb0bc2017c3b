"""How certain a map is: the marginal covariance of single poses.

At a minimum with the Hessian H of the cost, the covariance of all poses is H⁻¹ to first
order, and the marginal covariance of pose k is its block at k. One factorisation of H gives
any of these blocks.

Source: Kaess and Dellaert 2009, "Covariance recovery from a square root information matrix".
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from robust_slam._arrays import Array
from robust_slam.descent.normal_equations import NormalEquations
from robust_slam.errors import Underdetermined
from robust_slam.graphs.pose_graph import PoseGraph, check_poses, check_weights

_COLUMNS = 60
"""Columns that are solved for at a time, so that memory stays small."""


def covariance(
    graph: PoseGraph, poses: ArrayLike, k: ArrayLike, weights: ArrayLike | None = None
) -> Array:
    """Return the marginal covariance of pose ``k``, ``(D, D)``, or of several, ``(…, D, D)``.

    ``poses``, ``(n, 3)`` or ``(n, 3, 4)``, are a minimum of the cost; ``weights`` ``(m,)``
    multiply the information and are 1 if None, and edges of weight 0 are left out. The
    covariance is that of a perturbation on the right, x ∘ Exp(δ), in the order (position,
    rotation), in m² and rad². It is relative to pose 0, whose own covariance is 0. It holds
    to first order, and for the kept edges alone: a wrong closure makes a map look certain.

    Raises:
        ValueError: ``poses`` or ``weights`` do not fit the graph, or ``k`` is not a pose.
        Underdetermined: the edges with positive weight do not determine the map.

    Source: Kaess and Dellaert 2009.

    >>> graph = PoseGraph(3, [[0, 1], [1, 2]], [[1, 0, 0]] * 2, [np.eye(3)] * 2, [True, True])
    >>> covariance(graph, np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0]]), 2).round(3)
    array([[2., 0., 0.],
           [0., 3., 1.],
           [0., 1., 2.]])
    """
    x, w = check_poses("poses", poses, graph), check_weights(weights, graph)
    chosen = _chosen(k, graph.n)
    equations, w = NormalEquations(graph).restricted(w)
    hessian, _ = equations.system(equations.at(x, w))
    factors = equations.pattern.factorise(hessian)
    if factors is None:
        raise Underdetermined(
            "the normal equations are singular to working precision: some edges weigh almost "
            "nothing beside the others; give such edges weight 0 or trust more edges"
        )
    size = graph.group.DOF
    blocks = np.empty((chosen.size, size, size))
    for first in range(0, chosen.size, _COLUMNS // size):
        part = chosen.ravel()[first : first + _COLUMNS // size]
        right = np.zeros((graph.n, size, part.size, size))
        right[part, :, np.arange(part.size)] = np.eye(size)
        solved = factors.solve(right)
        blocks[first : first + part.size] = solved[part, :, np.arange(part.size)]
    blocks = 0.5 * (blocks + np.swapaxes(blocks, 1, 2))
    return np.asarray(blocks.reshape(*chosen.shape, size, size))


def _chosen(k: ArrayLike, n: int) -> np.ndarray[tuple[int, ...], np.dtype[np.intp]]:
    chosen = np.asarray(k)
    if chosen.size and not np.issubdtype(chosen.dtype, np.integer):
        raise ValueError(f"k: the entries are {chosen.dtype}; give numbers of poses")
    if np.any((chosen < 0) | (chosen >= n)):
        raise ValueError(f"k is {chosen.tolist()}; poses are 0 to {n - 1}")
    return chosen.astype(np.intp)
