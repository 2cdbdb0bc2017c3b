"""Array types of the library and the checks on every input."""

from collections.abc import Callable
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array: TypeAlias = NDArray[np.float64]
Mask: TypeAlias = NDArray[np.bool_]
Indices: TypeAlias = NDArray[np.intp]
Ids: TypeAlias = NDArray[np.int64]
"""What a file calls its poses, such as GTSAM's keys; ``intp`` has 32 bits in a browser."""


def finite(name: str, value: ArrayLike, shape: tuple[int, ...]) -> Array:
    """Return a read-only float copy of ``value``; -1 in ``shape`` stands for any length.

    Raises:
        ValueError: the shape differs, or an entry is NaN or infinite.
        TypeError: the value is no array of numbers.
    """
    try:
        array = np.array(value, dtype=np.float64)
    except TypeError:
        raise TypeError(f"{name} is a {type(value).__name__}; give an array of numbers") from None
    fits = array.ndim == len(shape) and all(
        expected in (-1, length) for expected, length in zip(shape, array.shape, strict=True)
    )
    if not fits:
        expected = ", ".join("any" if length == -1 else str(length) for length in shape)
        raise ValueError(f"{name}: the shape is {array.shape}; give ({expected})")
    if not np.all(np.isfinite(array)):
        first = tuple(int(k) for k in np.argwhere(~np.isfinite(array))[0])
        raise ValueError(f"{name}: the entry at {first} is not finite; remove NaN and infinity")
    array.flags.writeable = False
    return array


def ending(name: str, value: ArrayLike, shape: tuple[int, ...], each: str) -> Array:
    """Return ``value`` as floats, in any number of arrays of one ``shape``.

    Raises:
        ValueError: the last axes are others; ``each`` says what they hold.
    """
    array = np.asarray(value, dtype=np.float64)
    if array.shape[-len(shape) :] != shape:
        wanted = ", ".join(["…", *map(str, shape)])
        raise ValueError(f"{name}: the shape is {array.shape}; give ({wanted}), each {each}")
    return array


def refuse(wrong: ArrayLike, words: Callable[[int], str], error: type = ValueError) -> None:
    """Refuse the first entry that ``wrong`` ``(k,)`` marks, if there is one.

    Raises:
        ValueError: or another ``error``, with the ``words`` about its number.
    """
    for k in np.flatnonzero(wrong)[:1].tolist():
        raise error(words(k))


def positive(name: str, value: float) -> float:
    """Return ``value`` as a float.

    Raises:
        ValueError: it is not a finite number above zero.
    """
    number = float(value)
    if not (np.isfinite(number) and number > 0.0):
        raise ValueError(f"{name} is {number}; give a finite number above 0")
    return number


def deviations(sigma: ArrayLike, m: int) -> Array:
    """Return standard deviations ``(m,)`` from a scalar or an ``(m,)`` array.

    Raises:
        ValueError: the shape differs, or an entry is not finite and above zero.
    """
    spread = np.asarray(sigma, dtype=np.float64)
    full = finite("sigma", np.full(m, spread) if spread.ndim == 0 else spread, (m,))
    refuse(full <= 0.0, lambda k: f"sigma: entry {k} is not above 0")
    return full


def mask(name: str, value: ArrayLike | None, m: int) -> Mask:
    """Return a read-only boolean copy ``(m,)``; None stands for all False.

    Raises:
        ValueError: the shape differs, or the entries are not booleans.
    """
    array = np.zeros(m, dtype=np.bool_) if value is None else np.array(value)
    if array.shape != (m,):
        raise ValueError(f"{name}: the shape is {array.shape}; give ({m},)")
    if m and array.dtype != np.bool_:
        raise ValueError(f"{name}: the entries are {array.dtype}; give booleans, not indices")
    flags = array.astype(np.bool_)
    flags.flags.writeable = False
    return flags


def pose_numbers(name: str, value: ArrayLike, n: int) -> Indices:
    """Return numbers of poses ``(…)`` as indices; negative ones count from the end.

    Raises:
        ValueError: an entry is not a whole number, or there is no such pose among ``n``.
    """
    numbers = np.asarray(value)
    if numbers.size and not np.issubdtype(numbers.dtype, np.integer):
        raise ValueError(f"{name}: the entries are {numbers.dtype}; give numbers of poses")
    if np.any((numbers < -n) | (numbers >= n)):
        raise ValueError(f"{name} is {numbers.tolist()}; poses are 0 to {n - 1}")
    return numbers.astype(np.intp) % n


def times(matrices: Array, vectors: Array) -> Array:
    """Return the products ``(…, a)`` of matrices ``(…, a, b)`` and vectors ``(…, b)``."""
    return np.asarray((matrices @ vectors[..., None])[..., 0])
