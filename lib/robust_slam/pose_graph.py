"""A pose graph in the plane, as arrays, with its residuals and its cost.

Edge k = (i, j) says: seen from pose i, pose j stands at ``measurement[k]``. Its residual
is Log(z⁻¹ ∘ x_i⁻¹ ∘ x_j), the full logarithm of SE(2), with the information matrix in the
same order (ρx, ρy, θ). The cost of a map is ½ Σ ‖whitened residual‖².
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from robust_slam import se2
from robust_slam._arrays import Array, Indices, Mask, finite, mask


@dataclass(frozen=True, eq=False)
class PoseGraph:
    """Relative poses between ``n`` poses, numbered from 0.

    ``edges`` ``(m, 2)`` holds i and j of each edge, ``measurement`` ``(m, 3)`` the pose
    of j seen from i as [x, y, θ] in m, m, rad, ``information`` ``(m, 3, 3)`` its inverse
    covariance, and ``is_odometry`` ``(m,)`` tells the robot's own steps from closures.
    The arrays are copied and cannot be written to.

    Raises:
        ValueError: a shape is wrong, an entry is not finite, an index is out of range, an
            information matrix is not symmetric and positive definite, or a pose is not
            joined to pose 0.
    """

    n: int
    edges: Indices
    measurement: Array
    information: Array
    is_odometry: Mask

    def __post_init__(self) -> None:
        edges = _edges(self.edges, self.n)
        m = len(edges)
        checked = {
            "edges": edges,
            "measurement": finite("measurement", self.measurement, (m, 3)),
            "information": _information(self.information, m),
            "is_odometry": mask("is_odometry", self.is_odometry, m),
        }
        for name, value in checked.items():
            object.__setattr__(self, name, value)
        loose = unreached(self, np.ones(m, dtype=np.bool_))
        if loose.size:
            raise ValueError(
                f"edges: pose {loose[0]} is not joined to pose 0 ({loose.size} poses are not); "
                "add an edge or drop the poses"
            )


def _edges(value: ArrayLike, n: int) -> Indices:
    edges = np.array(value)
    if n < 2:
        raise ValueError(f"n is {n}; a graph joins at least 2 poses")
    if edges.ndim != 2 or edges.shape[1] != 2:
        raise ValueError(f"edges: the shape is {edges.shape}; give (m, 2)")
    if not np.issubdtype(edges.dtype, np.integer) and edges.size:
        raise ValueError(f"edges: the entries are {edges.dtype}; give whole numbers")
    outside = np.any((edges < 0) | (edges >= n), axis=1)
    if np.any(outside):
        k = int(np.argmax(outside))
        raise ValueError(f"edges: edge {k} is {edges[k].tolist()}; poses are 0 to {n - 1}")
    looped = edges[:, 0] == edges[:, 1]
    if np.any(looped):
        k = int(np.argmax(looped))
        raise ValueError(f"edges: edge {k} joins pose {edges[k, 0]} to itself; drop it")
    edges = edges.astype(np.intp)
    edges.flags.writeable = False
    return edges


def _information(value: ArrayLike, m: int) -> Array:
    information = finite("information", value, (m, 3, 3))
    skew = np.abs(information - np.swapaxes(information, 1, 2)).max(axis=(1, 2), initial=0.0)
    size = np.abs(information).max(axis=(1, 2), initial=0.0)
    crooked = skew > 1e-9 * size
    if np.any(crooked):
        raise ValueError(f"information: edge {int(np.argmax(crooked))} is not symmetric")
    weak = ~(np.linalg.eigvalsh(information)[:, 0] > 0.0)
    if np.any(weak):
        raise ValueError(
            f"information: edge {int(np.argmax(weak))} is not positive definite; give the "
            "inverse of a covariance"
        )
    return information


def unreached(graph: PoseGraph, used: Mask) -> Indices:
    """Return the poses, ascending, that the edges of the mask ``used`` ``(m,)`` leave loose.

    A pose is loose when no path of used edges joins it to pose 0.
    """
    i, j = graph.edges[used].T
    adjacency = coo_array((np.ones(i.size, dtype=np.int8), (i, j)), shape=(graph.n, graph.n))
    _, label = connected_components(adjacency, directed=False)
    loose: Indices = np.flatnonzero(label != label[0])
    return loose


def check_poses(name: str, poses: ArrayLike, graph: PoseGraph) -> Array:
    """Return ``poses`` ``(n, 3)`` of ``graph`` as a read-only copy.

    Raises:
        ValueError: the shape differs, or an entry is not finite.
    """
    return finite(name, poses, (graph.n, 3))


def residuals(poses: Array, graph: PoseGraph) -> Array:
    """Return Log(z⁻¹ ∘ x_i⁻¹ ∘ x_j) ``(m, 3)`` in m, m, rad, not whitened."""
    i, j = graph.edges.T
    predicted = se2.between(poses[i], poses[j])
    return se2.log(se2.between(graph.measurement, predicted))


def squared_norms(poses: Array, graph: PoseGraph) -> Array:
    """Return the squared whitened residual rᵀ Ω r of each edge, ``(m,)``, without a unit."""
    r = residuals(poses, graph)
    squares: Array = np.einsum("ka,kab,kb->k", r, graph.information, r)
    return np.maximum(squares, 0.0)


def residual_norms(poses: Array, graph: PoseGraph) -> Array:
    """Return the whitened residual norm of each edge, ``(m,)``: the u of a kernel."""
    return np.sqrt(squared_norms(poses, graph))


def cost(poses: Array, graph: PoseGraph, weights: Array | None = None) -> float:
    """Return ½ Σ w ‖whitened residual‖², every weight 1 if ``weights`` ``(m,)`` is None."""
    squares = squared_norms(poses, graph)
    return 0.5 * float(np.sum(squares if weights is None else weights * squares))


def jacobians(poses: Array, graph: PoseGraph) -> tuple[Array, Array]:
    """Return the derivatives of the residuals by pose i and by pose j, ``(m, 3, 3)`` each.

    Poses are perturbed on the right, x ∘ Exp(δ): with e = Log(z⁻¹ ∘ x_i⁻¹ ∘ x_j) the
    second is Jr⁻¹(e), and the first −Jr⁻¹(e) Ad(x_j⁻¹ ∘ x_i).

    Source: Solà et al. 2018, the chain rule over between, compose and Log.
    """
    i, j = graph.edges.T
    by_j = se2.inverse_right_jacobian(residuals(poses, graph))
    by_i = -by_j @ se2.adjoint(se2.between(poses[j], poses[i]))
    return by_i, by_j


def with_closures(
    graph: PoseGraph, edges: ArrayLike, measurement: ArrayLike, information: ArrayLike
) -> PoseGraph:
    """Return ``graph`` with further loop closures behind its edges.

    ``edges`` ``(k, 2)``, ``measurement`` ``(k, 3)`` in m, m, rad, and ``information``
    ``(k, 3, 3)``, or ``(3, 3)`` for all.

    Raises:
        ValueError: as ``PoseGraph``.
    """
    added = np.asarray(edges)
    count = len(added)
    return PoseGraph(
        n=graph.n,
        edges=np.concatenate([graph.edges, added]),
        measurement=np.concatenate([graph.measurement, np.asarray(measurement)]),
        information=np.concatenate(
            [graph.information, np.broadcast_to(np.asarray(information), (count, 3, 3))]
        ),
        is_odometry=np.concatenate([graph.is_odometry, np.zeros(count, dtype=np.bool_)]),
    )
