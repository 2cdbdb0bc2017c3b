"""A pose graph in SE(2) or SE(3), as arrays, with its residuals and its cost.

Edge k = (i, j) says: seen from pose i, pose j stands at ``measurement[k]``. Its residual
is Log(z⁻¹ ∘ x_i⁻¹ ∘ x_j), the full logarithm, with the information matrix in the same
order: (ρx, ρy, θ) in SE(2), ρ and then the rotation vector in SE(3). The cost of a map is
½ Σ ‖whitened residual‖². Below, D is 3 in SE(2) and 6 in SE(3), and poses are ``(n, 3)``
or ``(n, 3, 4)`` as in ``se2`` and ``se3``.

Source: Grisetti et al. 2010, "A tutorial on graph-based SLAM", with the full logarithm.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from robust_slam._arrays import Array, Indices, Mask, finite, mask
from robust_slam.errors import Underdetermined
from robust_slam.graphs import se2
from robust_slam.graphs.group import Group, group_of

_CROOKED = 1e-6
"""How far R Rᵀ may be from the identity; rounding stays far below."""


@dataclass(frozen=True, eq=False)
class PoseGraph:
    """Relative poses between ``n`` poses, numbered from 0.

    ``edges`` ``(m, 2)`` holds i and j of each edge; ``measurement`` the pose of j seen
    from i, ``(m, 3)`` as [x, y, θ] in m, m, rad or ``(m, 3, 4)`` as [R | t];
    ``information`` ``(m, D, D)`` its inverse covariance; ``is_odometry`` ``(m,)`` tells
    the robot's own steps from closures. The arrays are copied and cannot be written to.

    Raises:
        ValueError: a shape is wrong, an entry is not finite, an index is out of range, a
            rotation matrix is none, an information matrix is not symmetric and positive
            definite, or a pose is not joined to pose 0.
    """

    n: int
    edges: Indices
    measurement: Array
    information: Array
    is_odometry: Mask

    def __post_init__(self) -> None:
        edges = _edges(self.edges, self.n)
        m = len(edges)
        group = group_of(np.asarray(self.measurement))
        checked = {
            "edges": edges,
            "measurement": _poses("measurement", self.measurement, group, m),
            "information": _information(self.information, m, group.DOF),
            "is_odometry": mask("is_odometry", self.is_odometry, m),
        }
        for name, value in checked.items():
            object.__setattr__(self, name, value)
        _check_joined(self.n, edges)

    @property
    def group(self) -> Group:
        """The module ``se2`` or ``se3`` that the poses belong to."""
        return group_of(self.measurement)

    @cached_property
    def odometry_joins_all(self) -> bool:
        """Whether the odometry alone joins every pose to pose 0."""
        return unreached(self, self.is_odometry).size == 0

    @cached_property
    def inverse_measurement(self) -> Array:
        """The pose of i seen from j of each edge, ``(m, 3)`` or ``(m, 3, 4)``."""
        return self.group.inverse(self.measurement)

    @property
    def rotation(self) -> Array:
        """The rotation matrices ``(m, d, d)`` of the measurements; d is 2 or 3."""
        return self.group.rotation(self.measurement)

    @property
    def translation(self) -> Array:
        """The translations ``(m, d)`` of the measurements, in m."""
        return self.group.translation(self.measurement)


def _poses(name: str, value: ArrayLike, group: Group, count: int) -> Array:
    poses = finite(name, value, (count, *group.POSE_SHAPE))
    if group is se2:
        return poses  # an angle is never crooked
    turn = group.rotation(poses)
    gap = np.abs(turn @ np.swapaxes(turn, 1, 2) - np.eye(group.DIMENSION))
    crooked = (gap.max(axis=(1, 2), initial=0.0) > _CROOKED) | (np.linalg.det(turn) < 0.0)
    if np.any(crooked):
        raise ValueError(
            f"{name}: the left part of entry {int(np.argmax(crooked))} is not a rotation "
            "matrix; its columns must be orthonormal and its determinant 1"
        )
    return poses


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


def _information(value: ArrayLike, m: int, dof: int) -> Array:
    information = finite("information", value, (m, dof, dof))
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


def _check_joined(n: int, edges: Indices) -> None:
    loose = _unreached(n, edges)
    if loose.size:
        raise ValueError(
            f"edges: pose {loose[0]} is not joined to pose 0 ({loose.size} poses are not); "
            "add an edge or drop the poses"
        )


def unreached(graph: PoseGraph, used: Mask) -> Indices:
    """Return the poses, ascending, that the edges of the mask ``used`` ``(m,)`` leave loose.

    A pose is loose when no path of used edges joins it to pose 0.
    """
    return _unreached(graph.n, graph.edges[used])


def _unreached(n: int, edges: Indices) -> Indices:
    i, j = edges.T
    adjacency = coo_array((np.ones(i.size, dtype=np.int8), (i, j)), shape=(n, n))
    _, label = connected_components(adjacency, directed=False)
    loose: Indices = np.flatnonzero(label != label[0])
    return loose


def check_poses(name: str, poses: ArrayLike, graph: PoseGraph) -> Array:
    """Return ``poses`` ``(n, 3)`` or ``(n, 3, 4)`` of ``graph`` as a read-only copy.

    Raises:
        ValueError: the shape differs, an entry is not finite, or a rotation matrix is none.
    """
    return _poses(name, poses, graph.group, graph.n)


def check_weights(weights: ArrayLike | None, graph: PoseGraph) -> Array:
    """Return the weights ``(m,)``, every one 1 if None.

    Raises:
        ValueError: the shape differs, or a weight is not finite or negative.
        Underdetermined: the edges with positive weight leave a pose loose.
    """
    m = len(graph.edges)
    full = np.ones(m) if weights is None else finite("weights", weights, (m,))
    if np.any(full < 0.0):
        raise ValueError(f"weights: edge {int(np.argmax(full < 0.0))} weighs less than 0")
    used = full > 0.0
    if np.all(used) or (graph.odometry_joins_all and np.all(used[graph.is_odometry])):
        return full
    loose = unreached(graph, used)
    if loose.size:
        raise Underdetermined(
            f"weights: no edge of positive weight joins pose {loose[0]} to pose 0 "
            f"({loose.size} poses are loose); trust the odometry or keep an edge"
        )
    return full


def residuals(poses: Array, graph: PoseGraph) -> Array:
    """Return Log(z⁻¹ ∘ x_i⁻¹ ∘ x_j) ``(m, D)`` in m and rad, not whitened."""
    return errors(seen(poses, graph), graph)


def seen(poses: Array, graph: PoseGraph) -> Array:
    """Return x_i⁻¹ ∘ x_j, pose j as pose i sees it, for each edge: ``(m, 3)`` or ``(m, 3, 4)``."""
    i, j = graph.edges.T
    return graph.group.between(poses[i], poses[j])


def errors(predicted: Array, graph: PoseGraph) -> Array:
    """Return Log(z⁻¹ ∘ p) ``(m, D)`` in m and rad; p, ``predicted``, is what ``seen`` gives."""
    group = graph.group
    return group.log(group.compose(graph.inverse_measurement, predicted))


def squared_norms(poses: Array, graph: PoseGraph) -> Array:
    """Return the squared whitened residual rᵀ Ω r of each edge, ``(m,)``, without a unit."""
    return squares(residuals(poses, graph), graph)


def squares(r: Array, graph: PoseGraph) -> Array:
    """Return rᵀ Ω r ``(m,)``, without a unit, for residuals ``r`` ``(m, D)`` in m and rad."""
    return np.asarray(np.maximum(np.sum(r * loaded(r, graph), axis=1), 0.0))


def loaded(r: Array, graph: PoseGraph) -> Array:
    """Return Ω r ``(m, D)`` for residuals ``r`` ``(m, D)`` in m and rad."""
    return np.asarray((graph.information @ r[..., None])[..., 0])


def residual_norms(poses: Array, graph: PoseGraph) -> Array:
    """Return the whitened residual norm of each edge, ``(m,)``: the u of a kernel."""
    return np.sqrt(squared_norms(poses, graph))


def cost(poses: Array, graph: PoseGraph, weights: Array | None = None) -> float:
    """Return ½ Σ w ‖whitened residual‖², every weight 1 if ``weights`` ``(m,)`` is None."""
    u2 = squared_norms(poses, graph)
    return 0.5 * float(np.sum(u2 if weights is None else weights * u2))


def linearise(predicted: Array, r: Array, graph: PoseGraph) -> Array:
    """Return the derivatives of the residuals as two factors, ``(2, m, D, D)``.

    ``predicted`` is what ``seen`` gives, and ``r`` ``(m, D)`` are its ``errors``. Poses are
    perturbed on the right, x ∘ Exp(δ). The first factor is the derivative by pose j,
    Jr⁻¹(r). The second is the *lever* −Ad(x_j⁻¹ ∘ x_i), which carries a step of pose i over
    to pose j: the derivative by pose i is the first times the second.

    Source: Solà et al. 2018, the chain rule over between, compose and Log.
    """
    group = graph.group
    both = np.empty((2, *graph.information.shape))
    both[0] = group.inverse_right_jacobian(r)
    np.negative(group.adjoint(group.inverse(predicted)), out=both[1])
    return both


def jacobians(poses: Array, graph: PoseGraph) -> tuple[Array, Array]:
    """Return the derivatives of the residuals by pose i and by pose j, ``(m, D, D)`` each.

    Source: as ``linearise``.
    """
    predicted = seen(poses, graph)
    by_j, lever = linearise(predicted, errors(predicted, graph), graph)
    return by_j @ lever, by_j


def select(graph: PoseGraph, used: ArrayLike) -> PoseGraph:
    """Return ``graph`` with the edges of the mask ``used`` ``(m,)`` alone.

    Raises:
        ValueError: the mask does not fit, or leaves a pose unjoined to pose 0.
    """
    chosen = mask("used", used, len(graph.edges))
    _check_joined(graph.n, graph.edges[chosen])
    return part(graph, chosen)


def part(graph: PoseGraph, used: Mask) -> PoseGraph:
    """Return ``graph`` with the edges of the mask ``used`` ``(m,)``, poses loose or not.

    What was checked of an edge is not checked again.
    """
    smaller = object.__new__(PoseGraph)
    object.__setattr__(smaller, "n", graph.n)
    for of_edges in fields(graph)[1:]:
        chosen = getattr(graph, of_edges.name)[used]
        chosen.flags.writeable = False
        object.__setattr__(smaller, of_edges.name, chosen)
    return smaller


def with_closures(
    graph: PoseGraph, edges: ArrayLike, measurement: ArrayLike, information: ArrayLike
) -> PoseGraph:
    """Return ``graph`` with further loop closures behind its edges.

    ``edges`` ``(k, 2)``, ``measurement`` ``(k, 3)`` or ``(k, 3, 4)``, and ``information``
    ``(k, D, D)``, or ``(D, D)`` for all.

    Raises:
        ValueError: as ``PoseGraph``.
    """
    added = np.asarray(edges)
    shape = (len(added), *graph.information.shape[1:])
    return PoseGraph(
        n=graph.n,
        edges=np.concatenate([graph.edges, added]),
        measurement=np.concatenate([graph.measurement, np.asarray(measurement)]),
        information=np.concatenate(
            [graph.information, np.broadcast_to(np.asarray(information), shape)]
        ),
        is_odometry=np.concatenate([graph.is_odometry, np.zeros(len(added), dtype=np.bool_)]),
    )
