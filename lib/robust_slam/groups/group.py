"""The interface of a group of poses, which the modules ``se2`` and ``se3`` implement.

Code for both groups takes the module of its poses from ``group_of`` and does not use
coordinates itself.
"""

from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from robust_slam._arrays import Array, Ids
from robust_slam.groups import se2, se3


class Group(Protocol):
    """A module of functions on arrays of poses; d is the dimension, D the tangent's.

    Poses are ``(…, 3)`` in SE(2) and ``(…, 3, 4)`` in SE(3), tangent vectors ``(…, D)``.
    Every function broadcasts over the leading axes. See ``se2`` and ``se3`` for each.
    """

    DIMENSION: int
    DOF: int
    POSE_SHAPE: tuple[int, ...]

    def identity(self) -> Array:
        """Return the identity pose."""

    def compose(self, a: ArrayLike, b: ArrayLike) -> Array:
        """Return a ∘ b."""

    def inverse(self, p: ArrayLike) -> Array:
        """Return p⁻¹."""

    def between(self, a: ArrayLike, b: ArrayLike) -> Array:
        """Return a⁻¹ ∘ b."""

    def exp(self, xi: ArrayLike) -> Array:
        """Return the pose of a tangent vector."""

    def log(self, p: ArrayLike) -> Array:
        """Return the tangent vector of a pose."""

    def adjoint(self, p: ArrayLike) -> Array:
        """Return Ad(p) ``(…, D, D)``, for which p ∘ Exp(δ) = Exp(Ad(p) δ) ∘ p."""

    def inverse_right_jacobian(self, xi: ArrayLike) -> Array:
        """Return the Jacobian ``(…, D, D)`` of Log(Exp(xi) ∘ Exp(δ)) by δ at δ = 0."""

    def rotation(self, p: ArrayLike) -> Array:
        """Return the rotation matrices ``(…, d, d)``."""

    def translation(self, p: ArrayLike) -> Array:
        """Return the positions ``(…, d)`` in m."""

    def from_parts(self, rotation: ArrayLike, translation: ArrayLike) -> Array:
        """Return the poses of rotation matrices ``(…, d, d)`` and positions ``(…, d)``."""


def group_of(poses: Array) -> Group:
    """Return the module for ``poses``: ``se2`` for ``(…, 3)``, ``se3`` for ``(…, 3, 4)``.

    Raises:
        ValueError: the shape is neither.
    """
    if poses.ndim and poses.shape[-1] == 3:
        return se2
    if poses.shape[-2:] == (3, 4):
        return se3
    raise ValueError(
        f"poses: the shape is {poses.shape}; give (…, 3) in SE(2) or (…, 3, 4) in SE(3)"
        f"{', the rows [R | t] of each: poses[:, :3]' if poses.shape[-2:] == (4, 4) else ''}"
    )


def upward(ends: Ids, measurement: Array) -> Array:
    """Return the relative poses ``(m, …)`` of edges from the smaller to the larger of two ends.

    ``measurement`` ``(m, …)`` are those from the first to the second of the ``ends`` ``(m, 2)``.
    """
    back = (ends[:, 0] > ends[:, 1]).reshape(-1, *[1] * (measurement.ndim - 1))
    return np.where(back, group_of(measurement).inverse(measurement), measurement)
