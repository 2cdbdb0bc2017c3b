"""Robust kernels: the cost ρ, the influence ψ = ρ' and the weight w = ψ/u.

One convention for all: u is a whitened residual (no unit), ρ(u) ≈ u²/2 near 0, so
w(0) = 1. Every kernel is even in u, and |u| = scale belongs to the inner piece.
Papers on graduated non-convexity drop the ½ and write w = ρ'/(2u): the weights are
the same numbers (Yang et al. 2020).

A new kernel needs a constructor, one line in ``KERNELS``, and its name in the docstring of
``irls``. The tests cover every kernel of ``KERNELS``, whose order gives figures their line styles.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from math import inf, sqrt
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from robust_slam._arrays import Array, positive

Influence: TypeAlias = Literal["unbounded", "bounded", "redescending", "unknown"]
Function: TypeAlias = Callable[[ArrayLike], Array]

_LARGE = 1e100
"""A ratio u/c whose square is still a float."""


@dataclass(frozen=True)
class Kernel:
    """A robust cost ρ with its influence, its weight and its properties.

    ``name`` is its key in ``KERNELS``, ``label`` its name in figures and tables.
    ``rho``, ``psi`` and ``weight`` take whitened residuals of any shape and return an
    array of that shape. ``convex_until`` is the largest |u| up to which ρ is convex.
    ``influence`` describes ψ for large u: "unbounded" grows without limit, "bounded"
    tends to a constant above 0, "redescending" tends to 0. Of a loss that a user wrote neither is
    known.

    Kernels are values: two of the same name and scale are equal and have the same hash, and
    those of ``KERNELS`` can be pickled.
    """

    name: str
    label: str
    scale: float
    rho: Function = field(compare=False, repr=False)
    psi: Function = field(compare=False, repr=False)
    weight: Function = field(compare=False, repr=False)
    convex_until: float
    influence: Influence

    def __reduce__(self) -> tuple[object, ...]:
        # The functions are closures, which pickle cannot store: store how to make them.
        if self.name in KERNELS:
            return KERNELS[self.name], (self.scale,)
        return super().__reduce__()  # type: ignore[return-value]


Loss: TypeAlias = Callable[[Array], ArrayLike]
"""A loss as ``scipy.optimize.least_squares`` takes it: of z = (u/scale)², the rows ρ, ρ', ρ''."""


def as_kernel(
    given: Kernel | str | Callable[..., object], scale: float, argument: str = "kernel"
) -> Kernel:
    """Return a kernel from one, from its name or constructor, or from a loss of SciPy.

    ``scale`` is for those that do not have one yet. A name is one of ``KERNELS`` or of SciPy. With
    a ``Loss`` of z ``(m,)`` the kernel is ρ(u) = ½ scale² ρ(z), and its weight ρ'(z).

    Raises:
        TypeError: it is something else.
        ValueError: there is no kernel of that name, or ``scale`` is not above 0.

    Source: the documentation of ``scipy.optimize.least_squares`` for the loss.

    >>> as_kernel(lambda z: [np.arctan(z), 1 / (1 + z**2)], 1.0).weight([0.0, 2.0]).round(3)
    array([1.   , 0.059])
    """
    if hasattr(given, "rho") and hasattr(given, "weight"):
        return given  # type: ignore[return-value]
    if isinstance(given, str):
        if given in _OF_SCIPY:
            return _of_loss(_OF_SCIPY[given], positive("scale", scale))
        if given not in KERNELS:
            known = ", ".join([*KERNELS, *_OF_SCIPY])
            raise ValueError(f"{argument} is {given!r}; give one of {known}")
        return KERNELS[given](scale)
    if given in KERNELS.values():
        return given(scale)  # type: ignore[return-value]
    try:
        return _of_loss(given, positive("scale", scale))  # type: ignore[arg-type]
    except (TypeError, ValueError, IndexError):
        raise TypeError(
            f"{argument} is {getattr(given, '__name__', repr(given))}; give a kernel such as "
            "kernels.cauchy(1.0), a name such as 'cauchy', or a loss as SciPy takes it, of "
            "z = (u/scale)², which returns the rows ρ and ρ'"
        ) from None


_OF_SCIPY: dict[str, Loss] = {
    "linear": lambda z: np.stack([z, np.ones_like(z)]),
    "soft_l1": lambda z: np.stack([2.0 * (np.sqrt(1.0 + z) - 1.0), 1.0 / np.sqrt(1.0 + z)]),
    "arctan": lambda z: np.stack([np.arctan(z), 1.0 / (1.0 + z**2)]),
}
"""Losses of SciPy that are not among ``KERNELS``."""


def _of_loss(loss: Loss, c: float) -> Kernel:
    def row(k: int, u: ArrayLike) -> Array:
        z = (_real(u) / c) ** 2
        return np.asarray(np.asarray(loss(z.ravel()))[k], dtype=np.float64).reshape(z.shape)

    if row(1, np.zeros(2))[0] != 1.0:
        raise ValueError("a loss is z near 0")
    return Kernel(
        name=getattr(loss, "__name__", "loss"),
        label="loss",
        scale=c,
        rho=lambda u: 0.5 * c**2 * row(0, u),
        psi=lambda u: row(1, u) * _real(u),
        weight=lambda u: row(1, u),
        convex_until=float("nan"),  # another one each time, so that no two are equal
        influence="unknown",
    )


def _real(u: ArrayLike) -> Array:
    return np.asarray(u, dtype=np.float64)


def _squared_ratio(u: ArrayLike, c: float) -> Array:
    """Return (u/c)², infinite where floats end."""
    with np.errstate(over="ignore"):
        return np.asarray((_real(u) / c) ** 2)


def squared(scale: float = 1.0) -> Kernel:
    """Return the squared kernel ρ = u²/2, that of least squares.

    The scale has no effect; it gives all constructors the same signature.

    Raises:
        ValueError: ``scale`` is not a finite number above zero.

    Source: Legendre 1805; Gauss 1809.
    """
    return Kernel(
        name="squared",
        label="squared",
        scale=positive("scale", scale),
        rho=lambda u: 0.5 * _real(u) ** 2,
        psi=lambda u: _real(u).copy(),
        weight=lambda u: np.ones_like(_real(u)),
        convex_until=inf,
        influence="unbounded",
    )


def huber(k: float) -> Kernel:
    """Return Huber's kernel: u²/2 up to |u| = k and k(|u| − k/2) beyond.

    Its cost is unbounded, its influence is at most k.

    Raises:
        ValueError: ``k`` is not a finite number above zero.

    Source: Huber 1964, the minimax estimator of location.
    """
    k = positive("k", k)

    def rho(u: ArrayLike) -> Array:
        size = np.abs(_real(u))
        return np.where(size <= k, 0.5 * np.minimum(size, k) ** 2, k * (size - 0.5 * k))

    return Kernel(
        name="huber",
        label="Huber",
        scale=k,
        rho=rho,
        psi=lambda u: np.clip(_real(u), -k, k),
        weight=lambda u: k / np.maximum(np.abs(_real(u)), k),
        convex_until=inf,
        influence="bounded",
    )


def cauchy(c: float) -> Kernel:
    """Return the Cauchy kernel ρ = (c²/2) ln(1 + u²/c²); max ψ = c/2 at u = c.

    Raises:
        ValueError: ``c`` is not a finite number above zero.

    Source: Black and Rangarajan 1996, the Lorentzian.

    >>> kernel = cauchy(1.0)
    >>> kernel.psi([1.0, 3.0]), kernel.weight([1.0, 3.0])
    (array([0.5, 0.3]), array([0.5, 0.1]))
    """
    c = positive("c", c)

    def rho(u: ArrayLike) -> Array:
        size = np.abs(_real(u)) / c
        # ln(1 + v²) = 2 ln v where v² is beyond all floats, and to rounding long before.
        large = np.log(np.maximum(size, _LARGE))
        return np.asarray(
            c**2 * np.where(size < _LARGE, 0.5 * np.log1p(np.minimum(size, _LARGE) ** 2), large)
        )

    return Kernel(
        name="cauchy",
        label="Cauchy",
        scale=c,
        rho=rho,
        psi=lambda u: _real(u) / (1.0 + _squared_ratio(u, c)),
        weight=lambda u: 1.0 / (1.0 + _squared_ratio(u, c)),
        convex_until=c,
        influence="redescending",
    )


def geman_mcclure(c: float) -> Kernel:
    """Return the Geman–McClure kernel ρ = (u²/2) / (1 + u²/c²), bounded by c²/2.

    Raises:
        ValueError: ``c`` is not a finite number above zero.

    Source: Geman and McClure 1985; SLAM Handbook 2026, (3.25) at μ = 1, without the ½ there.
    """
    c = positive("c", c)

    def rho(u: ArrayLike) -> Array:
        # Capped, ρ does not become ∞/∞; at the cap it equals c²/2 to rounding.
        v = np.minimum(np.abs(_real(u)) / c, _LARGE)
        return np.asarray(0.5 * c**2 * (v**2 / (1.0 + v**2)))

    def weight(u: ArrayLike) -> Array:
        with np.errstate(over="ignore"):
            return np.asarray(1.0 / (1.0 + _squared_ratio(u, c)) ** 2)

    return Kernel(
        name="geman-mcclure",
        label="Geman–McClure",
        scale=c,
        rho=rho,
        psi=lambda u: weight(u) * _real(u),
        weight=weight,
        convex_until=c / sqrt(3.0),
        influence="redescending",
    )


def tls(c: float) -> Kernel:
    """Return truncated least squares ρ = min(u², c²)/2: residuals beyond c have no influence.

    At the kink |u| = c the inner piece holds: ψ(c) = c and w(c) = 1.

    Raises:
        ValueError: ``c`` is not a finite number above zero.

    Source: Yang et al. 2020, truncated least squares, without the ½ there.
    """
    c = positive("c", c)
    return Kernel(
        name="tls",
        label="TLS",
        scale=c,
        rho=lambda u: 0.5 * np.minimum(np.abs(_real(u)), c) ** 2,
        psi=lambda u: np.where(np.abs(_real(u)) <= c, _real(u), 0.0),
        weight=lambda u: np.where(np.abs(_real(u)) <= c, 1.0, 0.0),
        convex_until=c,
        influence="redescending",
    )


def dcs(c: float) -> Kernel:
    """Return the kernel whose weight is that of dynamic covariance scaling, with Φ = c².

    It is u²/2 up to |u| = c and (3Φu² − Φ²)/(2(Φ + u²)) beyond it, bounded by 3Φ/2.
    The weight is s² with s = min(1, 2Φ/(Φ + u²)): four times that of Geman–McClure, capped
    at 1.

    Raises:
        ValueError: ``c`` is not a finite number above zero.

    Source: Agarwal et al. 2013 for s; the cost is derived here, as the integral of s² u.
    """
    c = positive("c", c)
    phi = c**2

    def scaling(u: ArrayLike) -> Array:
        return np.minimum(1.0, 2.0 / (1.0 + _squared_ratio(u, c)))

    def rho(u: ArrayLike) -> Array:
        square = _squared_ratio(u, c)
        beyond = np.maximum(square, 1.0)
        tail = (1.5 - 0.5 / beyond) / (1.0 + 1.0 / beyond)
        return phi * np.where(square <= 1.0, 0.5 * square, tail)

    return Kernel(
        name="dcs",
        label="DCS",
        scale=c,
        rho=rho,
        psi=lambda u: scaling(u) ** 2 * _real(u),
        weight=lambda u: scaling(u) ** 2,
        convex_until=c,
        influence="redescending",
    )


def welsch(c: float) -> Kernel:
    """Return Welsch's kernel ρ = (c²/2)(1 − exp(−u²/c²)), bounded by c²/2.

    Raises:
        ValueError: ``c`` is not a finite number above zero.

    Source: Dennis and Welsch 1978; Holland and Welsch 1977 for the weight.
    """
    c = positive("c", c)

    def weight(u: ArrayLike) -> Array:
        return np.asarray(np.exp(-_squared_ratio(u, c)))

    return Kernel(
        name="welsch",
        label="Welsch",
        scale=c,
        rho=lambda u: -0.5 * c**2 * np.expm1(-_squared_ratio(u, c)),
        psi=lambda u: weight(u) * _real(u),
        weight=weight,
        convex_until=c / sqrt(2.0),
        influence="redescending",
    )


KERNELS: dict[str, Callable[[float], Kernel]] = {
    "squared": squared,
    "huber": huber,
    "cauchy": cauchy,
    "geman-mcclure": geman_mcclure,
    "tls": tls,
    "dcs": dcs,
    "welsch": welsch,
}
"""Every kernel by its name; the value takes the scale."""
