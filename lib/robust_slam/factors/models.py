"""What the factors measure between two nodes, with the derivatives.

A node is a pose, or a landmark as a pose whose rotation stays the identity. The frame of the map
is a node too, with the identity as its pose, so that a prior is a relative pose seen from the
frame, and a GPS fix a point seen from it. Three models are therefore enough: a relative pose, a
point and a range. Their functions take the poses ``(k, …)`` of the first and of the second node
and perturb them on the right, x ∘ Exp(δ). The columns of a Jacobian by a landmark's rotation are
0, so a landmark moves by R δ = δ.

Source: Solà et al. 2018, "A micro Lie theory for state estimation in robotics", the chain rule;
Dellaert and Kaess 2017, "Factor graphs for robot perception", for the factors.
"""

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

import numpy as np

from robust_slam._arrays import Array, times
from robust_slam.groups.group import Group

Jacobians: TypeAlias = tuple[Array, Array]


class Model(NamedTuple):
    """A measurement: its ``residual`` ``(k, d)`` and the ``jacobians`` ``(k, d, D)`` of it.

    Both take the group, the poses of the two nodes and the measurement. The Jacobians are by the
    first and by the second node.
    """

    residual: Callable[[Group, Array, Array, Array], Array]
    jacobians: Callable[[Group, Array, Array, Array], Jacobians]


def _relative(group: Group, a: Array, b: Array, z: Array) -> Array:
    """Return Log(z⁻¹ ∘ a⁻¹ ∘ b), as ``pose_graph.residuals``."""
    return group.log(group.compose(group.inverse(z), group.between(a, b)))


def _relative_jacobians(group: Group, a: Array, b: Array, z: Array) -> Jacobians:
    by_b = group.inverse_right_jacobian(_relative(group, a, b, z))
    return -by_b @ group.adjoint(group.between(b, a)), by_b


def _seen(group: Group, a: Array, b: Array) -> Array:
    """Return Rᵀ (t_b − t_a) ``(k, d)``: the position of b in the frame of a."""
    apart = group.translation(b) - group.translation(a)
    return times(np.swapaxes(group.rotation(a), 1, 2), apart)


def _point(group: Group, a: Array, b: Array, z: Array) -> Array:
    return _seen(group, a, b) - z


def _point_jacobians(group: Group, a: Array, b: Array, z: Array) -> Jacobians:
    d, seen = group.DIMENSION, _seen(group, a, b)
    # Ad of a translation p is [[I, [p]], [0, I]], and a turn φ of the frame moves p by [p] φ.
    by_a = group.adjoint(group.from_parts(np.eye(d), seen))[:, :d].copy()
    by_a[:, :, :d] *= -1.0
    by_b = np.zeros_like(by_a)
    by_b[:, :, :d] = np.swapaxes(group.rotation(a), 1, 2) @ group.rotation(b)
    return by_a, by_b


def _range(group: Group, a: Array, b: Array, z: Array) -> Array:
    apart = group.translation(b) - group.translation(a)
    return np.asarray(np.linalg.norm(apart, axis=1, keepdims=True) - z)


def _range_jacobians(group: Group, a: Array, b: Array, z: Array) -> Jacobians:
    apart = group.translation(b) - group.translation(a)
    length = np.linalg.norm(apart, axis=1, keepdims=True)
    # Where both are at one place every direction is as good as another.
    first = np.eye(1, group.DIMENSION)
    toward = np.divide(apart, length, out=np.tile(first, (len(apart), 1)), where=length > 0.0)
    by_a, by_b = np.zeros((2, len(apart), 1, group.DOF))
    by_a[:, :, : group.DIMENSION] = -toward[:, None] @ group.rotation(a)
    by_b[:, :, : group.DIMENSION] = toward[:, None] @ group.rotation(b)
    return by_a, by_b


RELATIVE = Model(_relative, _relative_jacobians)
"""A pose in the frame of another, with the full logarithm; from the frame of the map, a prior."""
POINT = Model(_point, _point_jacobians)
"""A position in the frame of a pose, less the measured one; from the frame of the map, GPS."""
RANGE = Model(_range, _range_jacobians)
"""A distance, less the measured one."""
