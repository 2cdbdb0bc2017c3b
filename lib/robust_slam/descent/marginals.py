"""How certain a map is: the marginal covariance of single poses, and of several jointly.

At a minimum with the Hessian H of the cost, the covariance of all poses is H⁻¹ to first
order. The marginal covariance of pose k is its block at k, and the joint covariance of several
poses has their blocks and those between them. One factorisation of H gives any of these.

Source: Kaess and Dellaert 2009, "Covariance recovery from a square root information matrix".
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike

from robust_slam._arrays import Array, Indices, pose_numbers
from robust_slam.descent.normal_equations import NormalEquations
from robust_slam.graphs.pose_graph import PoseGraph, check_graph, check_poses, check_weights

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
    Where the truth is known, ``robust_slam.graphs.nees`` tells whether errors are that large.

    Raises:
        ValueError: ``poses`` or ``weights`` do not fit the graph, or ``k`` is not a pose;
            negative numbers count from the last one.
        Underdetermined: the edges with positive weight do not determine the map.

    >>> graph = PoseGraph(3, [[0, 1], [1, 2]], [[1, 0, 0]] * 2, [np.eye(3)] * 2, [True, True])
    >>> covariance(graph, np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0]]), 2).round(3)
    array([[2., 0., 0.],
           [0., 3., 1.],
           [0., 1., 2.]])
    """
    chosen = pose_numbers("k", k, check_graph(graph).n)
    size = graph.group.DOF
    blocks = np.empty((chosen.size, size, size))
    for part, solved in _columns(graph, poses, weights, chosen.ravel()):
        blocks[part] = solved[chosen.ravel()[part], :, np.arange(solved.shape[2])]
    return np.asarray(_symmetric(blocks).reshape(*chosen.shape, size, size))


def joint_covariance(
    graph: PoseGraph, poses: ArrayLike, k: ArrayLike, weights: ArrayLike | None = None
) -> Array:
    """Return the joint covariance of the poses ``k`` ``(p,)``, ``(pD, pD)``.

    The blocks are in the order of ``k``: on the diagonal those of ``covariance``, elsewhere the
    cross-covariances. ``poses``, ``weights``, coordinates and units are those of ``covariance``.
    The relative pose a⁻¹ ∘ b of two poses is often far more certain than either. Its covariance
    is J Σ Jᵀ, with Σ that of (a, b) and J = [−Ad(b⁻¹ ∘ a), 1].

    Raises:
        ValueError, Underdetermined: as ``covariance``, or ``k`` is not a list of poses.

    Source: Kaess and Dellaert 2009; Solà et al. 2018 for J.

    >>> graph = PoseGraph(3, [[0, 1], [1, 2]], [[1, 0, 0]] * 2, [np.eye(3)] * 2, [True, True])
    >>> poses = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0]])
    >>> joint, group = joint_covariance(graph, poses, [1, 2]), graph.group
    >>> J = np.hstack([-group.adjoint(group.between(poses[2], poses[1])), np.eye(3)])
    >>> bool(np.allclose(J @ joint @ J.T, np.eye(3)))  # the noise of the edge between them
    True
    """
    chosen = pose_numbers("k", k, check_graph(graph).n)
    if chosen.ndim != 1:
        raise ValueError(f"k: the shape is {chosen.shape}; give a list of poses, such as [3, 8]")
    size = graph.group.DOF
    joint = np.empty((chosen.size, size, chosen.size, size))
    for part, solved in _columns(graph, poses, weights, chosen):
        joint[:, :, part] = solved[chosen]
    return _symmetric(joint.reshape(chosen.size * size, chosen.size * size))


def _columns(
    graph: PoseGraph, poses: ArrayLike, weights: ArrayLike | None, chosen: Indices
) -> Iterator[tuple[slice, Array]]:
    """Yield slices of the poses ``chosen`` ``(p,)``, and their columns ``(n, D, c, D)`` of H⁻¹."""
    x, w = check_poses("poses", poses, graph), check_weights(weights, graph)
    equations, w = NormalEquations(graph).restricted(w)
    factors, _ = equations.factorise(equations.at(x, w))
    size = graph.group.DOF
    for first in range(0, chosen.size, _COLUMNS // size):
        part = chosen[first : first + _COLUMNS // size]
        right = np.zeros((graph.n, size, part.size, size))
        right[part, :, np.arange(part.size)] = np.eye(size)
        yield slice(first, first + part.size), factors.solve(right)


def _symmetric(matrices: Array) -> Array:
    return np.asarray(0.5 * (matrices + np.swapaxes(matrices, -2, -1)))
