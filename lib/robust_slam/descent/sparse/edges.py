"""Residuals and normal equations of all edges in one pass, compiled by numba.

The mathematics is that of ``graphs.se2``, ``graphs.se3`` and ``graphs.pose_graph``, which are
the text to read: the names are the same, a function takes one pose or edge in place of
arrays of them, and results are written to the last argument.

Source: as ``se2``, ``se3`` and ``pose_graph``.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from robust_slam._arrays import Array, Indices, Mask
from robust_slam.descent.sparse.compiled import ROUNDING
from robust_slam.descent.sparse.pattern import BlockPattern
from robust_slam.graphs.pose_graph import PoseGraph

_SMALL_PLANE, _SMALL_SPACE, _FAR = 0.05, 0.3, -0.5
"""Where series replace quotients, and where the logarithm goes through a quaternion."""


class CompiledEdges:
    """The edges of ``graph``, with their places in the matrix of ``pattern``.

    Its methods raise ValueError where an array has not the size that the graph needs.
    """

    def __init__(self, graph: PoseGraph, pattern: BlockPattern) -> None:
        self._given = graph.edges, graph.inverse_measurement, graph.information
        self._shape = (graph.n, *graph.group.POSE_SHAPE)
        self._pattern = pattern
        self._last: tuple[Array, Array] | None = None

    def squared_norms(self, poses: Array) -> Array:
        """Return rᵀ Ω r of each edge, ``(m,)``, as ``pose_graph.squared_norms``.

        ``poses`` are ``(n, 3)`` or ``(n, 3, 4)``. The last ones are kept, because a robust
        solve asks for those of the same poses three times.
        """
        if self._last is None or not np.array_equal(self._last[0], poses):
            own = _own("poses", poses, self._shape)
            self._last = own, np.asarray(_norms(*self._given, own))
        return self._last[1]

    def assemble(self, poses: Array, weights: Array) -> tuple[Array, Array]:
        """Return Σ w Jᵀ Ω J as the blocks of the pattern, and Σ w Jᵀ Ω r ``(n, D)``."""
        pattern = self._pattern
        blocks = np.zeros((pattern.row.size, pattern.block, pattern.block))
        gradient = np.zeros((pattern.n, pattern.block))
        at = _own("poses", poses, self._shape), _own("weights", weights, pattern.flipped.shape)
        _assemble(*self._given, *at, pattern.targets, pattern.flipped, blocks, gradient)
        return blocks, gradient


def _own(name: str, values: Array, shape: tuple[int, ...]) -> Array:
    """Return a copy: kernels are compiled for types, and a read-only array has another."""
    # Compiled code reads what is there, also beyond the end.
    if values.shape != shape:
        raise ValueError(f"{name}: the shape is {values.shape}; give {shape}")
    return np.array(values)


@njit(cache=True, error_model="numpy", fastmath=ROUNDING)
def _norms(edges: Indices, inverse: Array, information: Array, poses: Array) -> Array:
    norms, r = np.empty(len(edges)), np.empty(information.shape[1])
    relative, error = np.empty_like(poses[0]), np.empty_like(poses[0])
    for k in range(len(edges)):
        _residual(poses[edges[k, 0]], poses[edges[k, 1]], inverse[k], relative, error, r)
        norms[k] = _mahalanobis_squared(information[k], r)
    return norms


@njit(cache=True, error_model="numpy", fastmath=ROUNDING)
def _residual(p: Array, q: Array, inverse: Array, relative: Array, error: Array, r: Array) -> None:
    # Where a function is compiled, ndim is a constant, and the other branch is left out.
    if p.ndim == 1:
        _residual_plane(p, q, inverse, relative, r)
    else:
        _residual_space(p, q, inverse, relative, error, r)


@njit(cache=True, error_model="numpy", fastmath=ROUNDING)
def _factors(relative: Array, r: Array, jacobian: Array, transfer: Array) -> None:
    """Write the two factors of ``pose_graph.linearise``."""
    if relative.ndim == 1:
        _inverse_right_jacobian_plane(r, jacobian)
        _transfer_plane(relative, transfer)
    else:
        _inverse_right_jacobian_space(r, jacobian)
        _transfer_space(relative, transfer)


@njit(cache=True, error_model="numpy", fastmath=ROUNDING)
def _mahalanobis_squared(information: Array, r: Array) -> float:
    total = 0.0
    for a in range(r.size):
        for b in range(r.size):
            total += r[a] * information[a, b] * r[b]
    return max(total, 0.0)


@njit(cache=True, error_model="numpy", fastmath=ROUNDING)
def _assemble(
    edges: Indices,
    inverse: Array,
    information: Array,
    poses: Array,
    weights: Array,
    onto: Indices,
    flipped: Mask,
    blocks: Array,
    gradient: Array,
) -> None:
    size = 3 if poses.ndim == 2 else 6  # known where it is compiled, so that loops are unrolled
    relative, error, r = np.empty_like(poses[0]), np.empty_like(poses[0]), np.empty(size)
    jacobian, transfer = np.zeros((size, size)), np.zeros((size, size))
    work, pair = np.empty((3, size, size)), np.empty((2, size))
    for k in range(len(edges)):
        i, j = edges[k]
        _residual(poses[i], poses[j], inverse[k], relative, error, r)
        _factors(relative, r, jacobian, transfer)
        _pieces(size, weights[k], information[k], r, jacobian, transfer, work, pair)
        _add_all(size, onto[:, k], flipped[k], work, blocks)
        gradient[i] += pair[0]
        gradient[j] += pair[1]


@njit(cache=True, inline="always")
def _pieces(
    size: int,
    weight: float,
    information: Array,
    r: Array,
    jacobian: Array,
    transfer: Array,
    work: Array,
    pair: Array,
) -> None:
    """Write Tᵀ G T, G and Tᵀ G to ``work`` and Tᵀ g and g to ``pair``.

    G = w Jᵀ Ω J and g = w Jᵀ Ω r, with J and T the two factors of ``pose_graph.linearise``.
    """
    _product(size, information, jacobian, work[0])
    _product_transposed(size, jacobian, work[0], work[1])
    for a in range(size):
        total = 0.0
        for b in range(size):
            total += work[0, b, a] * r[b]
            work[1, a, b] *= weight
        pair[1, a] = weight * total
    _product_transposed(size, transfer, work[1], work[2])
    _product(size, work[2], transfer, work[0])
    for a in range(size):
        total = 0.0
        for b in range(size):
            total += transfer[b, a] * pair[1, b]
        pair[0, a] = total


@njit(cache=True, inline="always")
def _product(size: int, left: Array, right: Array, out: Array) -> None:
    for a in range(size):
        for b in range(size):
            out[a, b] = left[a, 0] * right[0, b]
        for c in range(1, size):
            for b in range(size):
                out[a, b] += left[a, c] * right[c, b]


@njit(cache=True, inline="always")
def _product_transposed(size: int, left: Array, right: Array, out: Array) -> None:
    """Write leftᵀ right."""
    for a in range(size):
        for b in range(size):
            out[a, b] = left[0, a] * right[0, b]
        for c in range(1, size):
            for b in range(size):
                out[a, b] += left[c, a] * right[c, b]


@njit(cache=True, inline="always")
def _add_all(size: int, onto: Indices, flipped: bool, pieces: Array, blocks: Array) -> None:
    for piece in range(3):
        if onto[piece] >= 0:
            for a in range(size):
                for b in range(size):
                    turned = flipped and piece == 2
                    blocks[onto[piece], a, b] += (
                        pieces[piece, b, a] if turned else pieces[piece, a, b]
                    )


@njit(cache=True)
def _wrap(angle: float) -> float:
    return angle - 2.0 * np.pi * np.ceil(angle / (2.0 * np.pi) - 0.5)


@njit(cache=True)
def _half_cotangent(angle: float) -> float:
    half = angle / 2.0
    return 1.0 if half == 0.0 else np.cos(half) * half / np.sin(half)


@njit(cache=True, error_model="numpy", fastmath=ROUNDING)
def _residual_plane(p: Array, q: Array, inverse: Array, relative: Array, r: Array) -> None:
    """Write ``relative``, p⁻¹ ∘ q, and ``r``, Log(z⁻¹ ∘ p⁻¹ ∘ q)."""
    c, s, x, y = np.cos(p[2]), np.sin(p[2]), q[0] - p[0], q[1] - p[1]
    relative[0], relative[1], relative[2] = c * x + s * y, c * y - s * x, _wrap(q[2] - p[2])
    c, s = np.cos(inverse[2]), np.sin(inverse[2])
    x = inverse[0] + c * relative[0] - s * relative[1]
    y = inverse[1] + s * relative[0] + c * relative[1]
    angle = _wrap(inverse[2] + relative[2])
    a, half = _half_cotangent(angle), angle / 2.0
    r[0], r[1], r[2] = a * x + half * y, a * y - half * x, angle


@njit(cache=True, error_model="numpy", fastmath=ROUNDING)
def _inverse_right_jacobian_plane(r: Array, jacobian: Array) -> None:
    x, y, angle = r[0], r[1], r[2]
    a, half = _half_cotangent(angle), angle / 2.0
    if abs(angle) < _SMALL_PLANE:
        square = angle * angle
        c = angle * (1.0 / 12.0 + square * (1.0 / 720.0 + square / 30240.0))
    else:
        c = (1.0 - a) / angle
    jacobian[0, 0], jacobian[0, 1], jacobian[0, 2] = a, -half, c * x + y / 2.0
    jacobian[1, 0], jacobian[1, 1], jacobian[1, 2] = half, a, c * y - x / 2.0
    jacobian[2, 2] = 1.0


@njit(cache=True, error_model="numpy", fastmath=ROUNDING)
def _transfer_plane(relative: Array, transfer: Array) -> None:
    """Write −Ad(relative⁻¹)."""
    x, y, c, s = relative[0], relative[1], np.cos(relative[2]), np.sin(relative[2])
    transfer[0, 0], transfer[0, 1], transfer[0, 2] = -c, -s, c * y - s * x
    transfer[1, 0], transfer[1, 1], transfer[1, 2] = s, -c, -c * x - s * y
    transfer[2, 2] = -1.0


@njit(cache=True, error_model="numpy", fastmath=ROUNDING)
def _residual_space(
    p: Array, q: Array, inverse: Array, relative: Array, error: Array, r: Array
) -> None:
    """Write ``relative``, p⁻¹ ∘ q, ``error``, z⁻¹ ∘ p⁻¹ ∘ q, and ``r``, its logarithm."""
    for a in range(3):
        for b in range(4):
            total = 0.0
            for c in range(3):
                total += p[c, a] * (q[c, b] - p[c, 3] if b == 3 else q[c, b])
            relative[a, b] = total
    for a in range(3):
        for b in range(4):
            total = inverse[a, 3] if b == 3 else 0.0
            for c in range(3):
                total += inverse[a, c] * relative[c, b]
            error[a, b] = total
    _log_space(error, r)


@njit(cache=True, error_model="numpy", fastmath=ROUNDING)
def _log_space(p: Array, r: Array) -> None:
    x, y, z = _rotation_vector(p)
    u, v, w = p[0, 3], p[1, 3], p[2, 3]
    second = _log_coefficient(np.sqrt(x * x + y * y + z * z))
    a, b, c = y * w - z * v, z * u - x * w, x * v - y * u
    r[0] = u - 0.5 * a + second * (y * c - z * b)
    r[1] = v - 0.5 * b + second * (z * a - x * c)
    r[2] = w - 0.5 * c + second * (x * b - y * a)
    r[3], r[4], r[5] = x, y, z


@njit(cache=True, error_model="numpy", fastmath=ROUNDING)
def _rotation_vector(p: Array) -> tuple[float, float, float]:
    x, y, z = p[2, 1] - p[1, 2], p[0, 2] - p[2, 0], p[1, 0] - p[0, 1]
    sine = 0.5 * np.sqrt(x * x + y * y + z * z)
    cosine = 0.5 * (p[0, 0] + p[1, 1] + p[2, 2] - 1.0)
    if cosine < _FAR:
        return _far_rotation_vector(p)
    half = 0.5 * np.arctan2(sine, cosine) / sine if sine > 0.0 else 0.5
    return half * x, half * y, half * z


@njit(cache=True, error_model="numpy", fastmath=ROUNDING)
def _far_rotation_vector(p: Array) -> tuple[float, float, float]:
    """Return the rotation vector through the quaternion, whose largest part comes first.

    Source: Shepperd 1978, "Quaternion from rotation matrix".
    """
    a = 0
    for b in range(1, 3):
        if p[b, b] > p[a, a]:
            a = b
    b, c = (a + 1) % 3, (a + 2) % 3
    q = np.empty(3)
    q[a] = 1.0 + p[a, a] - p[b, b] - p[c, c]
    q[b], q[c], real = p[a, b] + p[b, a], p[a, c] + p[c, a], p[c, b] - p[b, c]
    length = np.sqrt(q[0] ** 2 + q[1] ** 2 + q[2] ** 2)
    if real < 0.0:
        length, real = -length, -real
    factor = 2.0 * np.arctan2(abs(length), real) / length
    return factor * q[0], factor * q[1], factor * q[2]


@njit(cache=True, error_model="numpy", fastmath=ROUNDING)
def _log_coefficient(angle: float) -> float:
    """Return (1 − (θ/2) cot(θ/2))/θ²."""
    if angle >= _SMALL_SPACE:
        half = angle / 2.0
        return (1.0 - half / np.tan(half)) / (4.0 * half * half)
    t = angle * angle
    return 1 / 12 + t * (1 / 720 + t * (1 / 30240 + t * (1 / 1209600 + t / 47900160)))


@njit(cache=True, error_model="numpy", fastmath=ROUNDING)
def _fourth_coefficient(angle: float) -> float:
    """Return the b of ``se3.inverse_right_jacobian``."""
    if angle >= _SMALL_SPACE:
        sine = np.sin(angle / 2.0)
        derivative = 0.5 * np.cos(angle / 2.0) / sine - 0.25 * angle / (sine * sine)
        return (derivative + 2.0 * angle * _log_coefficient(angle)) / (2.0 * angle**3)
    t = angle * angle
    return -1 / 720 + t * (-1 / 15120 + t * (-1 / 403200 - t / 11975040))


@njit(cache=True, error_model="numpy", fastmath=ROUNDING)
def _inverse_right_jacobian_space(r: Array, jacobian: Array) -> None:
    rho, phi = r[:3], r[3:]
    square = phi[0] ** 2 + phi[1] ** 2 + phi[2] ** 2
    dot = rho[0] * phi[0] + rho[1] * phi[1] + rho[2] * phi[2]
    angle = np.sqrt(square)
    c, d = _log_coefficient(angle), 2.0 * _fourth_coefficient(angle) * dot
    # With v the vector of a cross matrix, [φ]² = φ φᵀ − θ² I and
    # [φ][ρ] + [ρ][φ] = ρ φᵀ + φ ρᵀ − 2 (φ·ρ) I.
    for a in range(3):
        for b in range(3):
            twice = phi[a] * phi[b]
            mixed = rho[a] * phi[b] + phi[a] * rho[b]
            if a == b:
                twice, mixed = twice - square, mixed - 2.0 * dot
            same = 1.0 if a == b else 0.0
            jacobian[a, b] = jacobian[a + 3, b + 3] = same + c * twice
            jacobian[a, b + 3] = c * mixed - d * twice
    for a in range(3):
        b, c3 = (a + 1) % 3, (a + 2) % 3
        for row, column, sign in ((b, c3, -0.5), (c3, b, 0.5)):
            jacobian[row, column] += sign * phi[a]
            jacobian[row + 3, column + 3] += sign * phi[a]
            jacobian[row, column + 3] += sign * rho[a]


@njit(cache=True, error_model="numpy", fastmath=ROUNDING)
def _transfer_space(relative: Array, transfer: Array) -> None:
    """Write −Ad(relative⁻¹) = −[[Rᵀ, −Rᵀ[t]], [0, Rᵀ]] for ``relative`` = [R | t]."""
    x, y, z = relative[0, 3], relative[1, 3], relative[2, 3]
    for a in range(3):
        u, v, w = relative[0, a], relative[1, a], relative[2, a]
        transfer[a, 0] = transfer[a + 3, 3] = -u
        transfer[a, 1] = transfer[a + 3, 4] = -v
        transfer[a, 2] = transfer[a + 3, 5] = -w
        transfer[a, 3], transfer[a, 4], transfer[a, 5] = (
            v * z - w * y,
            w * x - u * z,
            u * y - v * x,
        )
