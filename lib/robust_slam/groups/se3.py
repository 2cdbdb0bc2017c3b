"""Poses in space: composition, inverse, exponential, logarithm and their derivatives.

A pose is the matrix [R | t] ``(3, 4)``: a rotation matrix and a position in m. A tangent
vector is (ρ, φ): ρ in m first, then the rotation vector φ in rad. Every function takes
arrays of them and broadcasts over the leading axes. Perturbations are on the right:
p ∘ Exp(δ).

Source: Solà, Deray and Atchuthan 2018, "A micro Lie theory for state estimation in
robotics", the appendix on SE(3).
"""

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from robust_slam._arrays import Array, ending, times

DIMENSION = 3
DOF = 6
POSE_SHAPE: tuple[int, ...] = (3, 4)

_FAR = -0.5
"""For angles with a smaller cosine the logarithm goes through a quaternion."""
_SMALL = 0.3
"""Below this angle (rad) a series replaces a quotient that suffers from cancellation."""


def identity() -> Array:
    """Return the identity pose ``(3, 4)``."""
    return np.eye(3, 4)


def rotation(p: ArrayLike) -> Array:
    """Return the rotation matrices ``(…, 3, 3)`` of poses."""
    return _pose("p", p)[..., :3]


def translation(p: ArrayLike) -> Array:
    """Return the positions ``(…, 3)`` of poses, in m."""
    return _pose("p", p)[..., 3]


def from_parts(rotation: ArrayLike, translation: ArrayLike) -> Array:
    """Return the poses ``(…, 3, 4)`` of rotations ``(…, 3, 3)`` and positions ``(…, 3)``."""
    matrix, position = np.asarray(rotation, np.float64), np.asarray(translation, np.float64)
    shape = np.broadcast_shapes(matrix.shape[:-2], position.shape[:-1])
    pose = np.empty((*shape, 3, 4))
    pose[..., :3], pose[..., 3] = matrix, position
    return pose


def compose(a: ArrayLike, b: ArrayLike) -> Array:
    """Return a ∘ b ``(…, 3, 4)``: the pose b, given relative to a, in the frame of a."""
    a, b = _pose("a", a), _pose("b", b)
    moved = a[..., :3] @ b
    moved[..., 3] += a[..., 3]
    return np.asarray(moved)


def inverse(p: ArrayLike) -> Array:
    """Return p⁻¹ ``(…, 3, 4)``, for which p ∘ p⁻¹ is the identity."""
    p = _pose("p", p)
    back = np.swapaxes(p[..., :3], -1, -2)
    return from_parts(back, -times(back, p[..., 3]))


def between(a: ArrayLike, b: ArrayLike) -> Array:
    """Return a⁻¹ ∘ b ``(…, 3, 4)``: b in the frame of a."""
    return compose(inverse(a), b)


def exp(xi: ArrayLike) -> Array:
    """Return the pose ``(…, 3, 4)`` Exp(xi): motion with the constant twist ``xi`` for 1 s."""
    xi = _twist("xi", xi)
    rho, phi = xi[..., :3], xi[..., 3:]
    angle = _length(phi)
    # V = I + (1 − cos θ)/θ² [φ] + (θ − sin θ)/θ³ [φ]²; np.sinc is defined at 0.
    first = 0.5 * np.sinc(angle / (2.0 * np.pi)) ** 2
    second = _exp_coefficient(angle)
    cross = np.cross(phi, rho)
    position = rho + first[..., None] * cross + second[..., None] * np.cross(phi, cross)
    flat = Rotation.from_rotvec(phi.reshape(-1, 3)).as_matrix()
    return from_parts(np.asarray(flat).reshape(*phi.shape, 3), position)


def log(p: ArrayLike) -> Array:
    """Return the twist ``(…, 6)`` with Exp(twist) = p and its angle in [0, π]."""
    p = _pose("p", p)
    phi = _rotation_vectors(p[..., :3])
    position = p[..., 3]
    # V⁻¹ = I − ½ [φ] + (1 − (θ/2) cot(θ/2))/θ² [φ]²
    second = _log_coefficient(_length(phi))
    cross = np.cross(phi, position)
    rho = position - 0.5 * cross + second[..., None] * np.cross(phi, cross)
    return np.concatenate([rho, phi], axis=-1)


def adjoint(p: ArrayLike) -> Array:
    """Return Ad(p) ``(…, 6, 6)``, for which p ∘ Exp(δ) = Exp(Ad(p) δ) ∘ p."""
    p = _pose("p", p)
    matrix = p[..., :3]
    return _block_triangle(matrix, _cross_matrix(p[..., 3]) @ matrix)


def inverse_right_jacobian(xi: ArrayLike) -> Array:
    """Return the Jacobian ``(…, 6, 6)`` of Log(Exp(xi) ∘ Exp(δ)) by δ at δ = 0.

    It is I + ½ A + a A² + b A⁴, with A = ad(xi).

    Source: derived here. The inverse right Jacobian is g(A) + ½ A with
    g(z) = (z/2) coth(z/2), and the eigenvalues of A are 0 and twice ±iθ. So a and b are
    such that 1 + a z² + b z⁴ has the value and the derivative of g at z = iθ.
    """
    xi = _twist("xi", xi)
    rho, phi = xi[..., :3], xi[..., 3:]
    rotation_part, translation_part = _cross_matrix(phi), _cross_matrix(rho)
    angle = _length(phi)
    c, b = _log_coefficient(angle), _fourth_coefficient(angle)
    # With A = [[Φ, P], [0, Φ]] the corner of A² is Q = ΦP + PΦ. As Φ³ = −θ² Φ, that of A⁴ is
    # −θ² Q − 2 (φ·ρ) Φ², and c = a − b θ² is the coefficient in Log.
    squared, mixed = rotation_part @ rotation_part, rotation_part @ translation_part
    mixed += np.swapaxes(mixed, -1, -2)
    d = 2.0 * b * np.sum(phi * rho, axis=-1)
    c, d = c[..., None, None], d[..., None, None]
    corner = 0.5 * translation_part + c * mixed - d * squared
    return _block_triangle(np.eye(3) + 0.5 * rotation_part + c * squared, corner)


def _pose(name: str, value: ArrayLike) -> Array:
    return ending(name, value, POSE_SHAPE, "[R | t]")


def _twist(name: str, value: ArrayLike) -> Array:
    return ending(name, value, (DOF,), "(ρ, φ)")


def _length(v: Array) -> Array:
    return np.asarray(np.sqrt(np.sum(v * v, axis=-1)))


def _rotation_vectors(matrix: Array) -> Array:
    """Return φ of exp([φ]): R − Rᵀ is 2 sin θ/θ [φ], and the trace of R is 1 + 2 cos θ."""
    flat = matrix.reshape(-1, 3, 3)
    skew = np.empty((len(flat), 3))
    for axis, (i, j) in enumerate(((2, 1), (0, 2), (1, 0))):
        np.subtract(flat[:, i, j], flat[:, j, i], out=skew[:, axis])
    sine = 0.5 * _length(skew)
    cosine = 0.5 * (flat[:, 0, 0] + flat[:, 1, 1] + flat[:, 2, 2] - 1.0)
    # At angle 0 the quotient of angle and sine is 1.
    quotient = np.divide(np.arctan2(sine, cosine), sine, out=np.ones_like(sine), where=sine > 0.0)
    phi = 0.5 * quotient[:, None] * skew
    # Near an angle of π R is nearly symmetric, and R − Rᵀ suffers from cancellation.
    far = cosine < _FAR
    if np.any(far):  # SciPy 1.14 takes no empty stack
        phi[far] = Rotation.from_matrix(flat[far]).as_rotvec()
    return np.asarray(phi.reshape(matrix.shape[:-1]))


def _cross_matrix(v: Array) -> Array:
    """Return [v] ``(…, 3, 3)``, for which [v] w = v × w."""
    x, y, z = v[..., 0], v[..., 1], v[..., 2]
    zero = np.zeros_like(x)
    entries = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=-1)
    return entries.reshape(*v.shape, 3)


def _block_triangle(diagonal: Array, corner: Array) -> Array:
    """Return [[diagonal, corner], [0, diagonal]] of blocks ``(…, 3, 3)``."""
    full = np.empty((*diagonal.shape[:-2], 6, 6))
    full[..., :3, :3] = full[..., 3:, 3:] = diagonal
    full[..., :3, 3:] = corner
    full[..., 3:, :3] = 0.0
    return full


def _exp_coefficient(angle: Array) -> Array:
    """Return (θ − sin θ)/θ³, which is 1/6 at 0."""
    c = _power_series(angle, 1 / 6, -1 / 120, 1 / 5040, -1 / 362880, 1 / 39916800)
    theta = angle[large := angle >= _SMALL]
    c[large] = (theta - np.sin(theta)) / theta**3
    return c


def _log_coefficient(angle: Array) -> Array:
    """Return (1 − (θ/2) cot(θ/2))/θ², which is 1/12 at 0."""
    c = _power_series(angle, 1 / 12, 1 / 720, 1 / 30240, 1 / 1209600, 1 / 47900160)
    half = angle[large := angle >= _SMALL] / 2.0
    c[large] = (1.0 - half / np.tan(half)) / (4.0 * half**2)
    return c


def _fourth_coefficient(angle: Array) -> Array:
    """Return the b of ``inverse_right_jacobian``, which is −1/720 at 0.

    With γ = (θ/2) cot(θ/2) it solves 1 − a θ² + b θ⁴ = γ and −2 a θ + 4 b θ³ = dγ/dθ.
    """
    b = _power_series(angle, -1 / 720, -1 / 15120, -1 / 403200, -1 / 11975040)
    theta = angle[large := angle >= _SMALL]
    sine = np.sin(theta / 2.0)
    derivative = 0.5 * np.cos(theta / 2.0) / sine - 0.25 * theta / sine**2
    b[large] = (derivative + 2.0 * theta * _log_coefficient(theta)) / (2.0 * theta**3)
    return b


def _power_series(angle: Array, *coefficients: float) -> Array:
    """Return c₀ + c₁ θ² + c₂ θ⁴ + …"""
    return np.asarray(np.polynomial.polynomial.polyval(angle**2, coefficients))
