"""Poses in the plane: composition, inverse, exponential, logarithm and their derivatives.

A pose is [x, y, θ] in m, m and rad; a tangent vector is (ρx, ρy, θ) in the same units.
Every function takes arrays ``(…, 3)`` and broadcasts over the leading axes. Perturbations
are on the right: p ∘ Exp(δ).

Source: Solà, Deray and Atchuthan 2018, "A micro Lie theory for state estimation in
robotics", the appendix on SE(2).
"""

import numpy as np
from numpy.typing import ArrayLike

from robust_slam._arrays import Array, ending

DIMENSION = 2
DOF = 3
POSE_SHAPE: tuple[int, ...] = (3,)


def identity() -> Array:
    """Return the identity pose ``(3,)``."""
    return np.zeros(3)


def rotation(p: ArrayLike) -> Array:
    """Return the rotation matrices ``(…, 2, 2)`` of poses."""
    angle = _pose("p", p)[..., 2]
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.stack([cosine, -sine, sine, cosine], axis=-1).reshape(*angle.shape, 2, 2)


def translation(p: ArrayLike) -> Array:
    """Return the positions ``(…, 2)`` of poses, in m."""
    return _pose("p", p)[..., :2]


def from_parts(rotation: ArrayLike, translation: ArrayLike) -> Array:
    """Return the poses ``(…, 3)`` of rotations ``(…, 2, 2)`` and positions ``(…, 2)``."""
    matrix, position = np.asarray(rotation, np.float64), np.asarray(translation, np.float64)
    angle = np.arctan2(matrix[..., 1, 0], matrix[..., 0, 0])
    shape = np.broadcast_shapes(angle.shape, position.shape[:-1])
    return _stack(np.broadcast_to(position, (*shape, 2)), np.broadcast_to(angle, shape))


def wrap(angle: ArrayLike) -> Array:
    """Return the angle in (−π, π] equal to ``angle`` (rad, any shape) modulo 2π.

    An angle that is already inside is returned unchanged, to the last bit.
    """
    angle = np.asarray(angle, dtype=np.float64)
    turns = np.ceil(angle / (2.0 * np.pi) - 0.5)
    return np.asarray(angle - 2.0 * np.pi * turns)


def compose(a: ArrayLike, b: ArrayLike) -> Array:
    """Return a ∘ b ``(…, 3)``: the pose b, given relative to a, in the frame of a."""
    a, b = _pose("a", a), _pose("b", b)
    return _stack(a[..., :2] + _rotate(a[..., 2], b[..., :2]), wrap(a[..., 2] + b[..., 2]))


def inverse(p: ArrayLike) -> Array:
    """Return p⁻¹ ``(…, 3)``, for which p ∘ p⁻¹ is [0, 0, 0]."""
    p = _pose("p", p)
    return _stack(-_rotate(-p[..., 2], p[..., :2]), wrap(-p[..., 2]))


def between(a: ArrayLike, b: ArrayLike) -> Array:
    """Return a⁻¹ ∘ b ``(…, 3)``: b in the frame of a."""
    a, b = _pose("a", a), _pose("b", b)
    return _stack(_rotate(-a[..., 2], b[..., :2] - a[..., :2]), wrap(b[..., 2] - a[..., 2]))


def exp(xi: ArrayLike) -> Array:
    """Return the pose ``(…, 3)`` Exp(xi): motion with the constant twist ``xi`` for 1 s."""
    xi = _pose("xi", xi)
    angle = xi[..., 2]
    # V(θ) = [[a, −b], [b, a]] with a = sin θ/θ, b = (1 − cos θ)/θ; np.sinc is defined at 0.
    a = np.sinc(angle / np.pi)
    b = np.sin(angle / 2.0) * np.sinc(angle / (2.0 * np.pi))
    return _stack(_complex_product(a, b, xi[..., :2]), wrap(angle))


def log(p: ArrayLike) -> Array:
    """Return the twist ``(…, 3)`` with Exp(twist) = p and its angle in (−π, π]."""
    p = _pose("p", p)
    angle = wrap(p[..., 2])
    return _stack(_complex_product(_half_cotangent(angle), -angle / 2.0, p[..., :2]), angle)


def adjoint(p: ArrayLike) -> Array:
    """Return Ad(p) ``(…, 3, 3)``, for which p ∘ Exp(δ) = Exp(Ad(p) δ) ∘ p."""
    p = _pose("p", p)
    cosine, sine = np.cos(p[..., 2]), np.sin(p[..., 2])
    return _affine(cosine, sine, p[..., 1], -p[..., 0])


def inverse_right_jacobian(xi: ArrayLike) -> Array:
    """Return the Jacobian ``(…, 3, 3)`` of Log(Exp(xi) ∘ Exp(δ)) by δ at δ = 0.

    Source: the inverse of the right Jacobian of Solà et al. 2018; the closed form of its
    last column is derived here, ((1 − a)/θ) ρ + ½ [ρy, −ρx] with a = (θ/2) cot(θ/2).
    """
    xi = _pose("xi", xi)
    x, y, angle = xi[..., 0], xi[..., 1], xi[..., 2]
    c = _log_coefficient(angle)
    return _affine(_half_cotangent(angle), angle / 2.0, c * x + y / 2.0, c * y - x / 2.0)


def _pose(name: str, value: ArrayLike) -> Array:
    return ending(name, value, POSE_SHAPE, "[x, y, θ]")


def _stack(position: Array, angle: Array) -> Array:
    return np.concatenate([position, angle[..., None]], axis=-1)


def _complex_product(a: Array, b: Array, v: Array) -> Array:
    """Return [[a, −b], [b, a]] v, the product (a + ib) v of complex numbers."""
    x, y = v[..., 0], v[..., 1]
    real = a * x - b * y
    # Written in place: on small graphs np.stack would take longer than the arithmetic.
    product = np.empty((*real.shape, 2))
    product[..., 0], product[..., 1] = real, b * x + a * y
    return product


def _rotate(angle: Array, v: Array) -> Array:
    return _complex_product(np.cos(angle), np.sin(angle), v)


def _affine(a: Array, b: Array, x: Array, y: Array) -> Array:
    """Return [[a, −b, x], [b, a, y], [0, 0, 1]]."""
    matrix = np.zeros((*a.shape, 3, 3))
    matrix[..., 0, 0] = matrix[..., 1, 1] = a
    matrix[..., 0, 1], matrix[..., 1, 0] = -b, b
    matrix[..., 0, 2], matrix[..., 1, 2], matrix[..., 2, 2] = x, y, 1.0
    return matrix


def _half_cotangent(angle: Array) -> Array:
    """Return (θ/2) cot(θ/2), which is 1 at 0."""
    return np.asarray(np.cos(angle / 2.0) / np.sinc(angle / (2.0 * np.pi)))


def _log_coefficient(angle: Array) -> Array:
    """Return (1 − (θ/2) cot(θ/2))/θ, which is about θ/12.

    Near 0 the difference suffers from cancellation, so its series is used; the first term
    left out is θ⁷/1209600, below 1e-15 there.
    """
    small = np.abs(angle) < 0.05
    safe = np.where(small, 1.0, angle)
    series = angle * (1.0 / 12.0 + angle**2 * (1.0 / 720.0 + angle**2 / 30240.0))
    return np.where(small, series, (1.0 - _half_cotangent(safe)) / safe)
