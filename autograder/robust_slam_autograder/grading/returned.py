"""Digests of what functions returned: equal where the values agree to about six digits.

All numbers that a test cell saw are added up with fixed weights, and the sums are rounded. A sum
beside the edge of its cell has two digests, so values that differ by rounding alone have one
in common. A digest tells nothing of the values.
"""

import functools
import hashlib
import itertools
import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from robust_slam_autograder.grading.explain import MAX_CALLS, Call

MAX_NUMBERS = 200_000
"""Of one test cell; what returns more is not looked at."""
MAX_PARTS = 2_000
"""Parts of nested values, alike."""
MAX_DEPTH = 20
MAX_TEXT = 200
CELL = 1e-5
"""Width of a cell that a sum is rounded to."""
EDGE = 0.1
"""A sum that is nearer to the edge of its cell than this share of it is in both cells."""
_SOFT = 100.0
"""Of what size numbers count by their logarithm: above one over this."""
_NAN, _INF = 40.25, 60.5
_SUMS = 2
RAISED, WHOLE, REAL = "e", "w", "r"
"""How a test cell ended."""

Part = tuple[str, np.ndarray | None]
"""The kind of a part of a value, and its numbers where it has some."""


class _Unlike(Exception):
    """A value is too large, or nothing that can be compared."""


def digests(calls: Sequence[Call], *, raised: bool) -> tuple[str, ...]:
    """Return the digest of what a test cell's calls returned, and then those of its neighbours.

    Each begins with how the cell ended: at an exception or nothing, at words or whole numbers, or
    at numbers that are not whole, which are hardly alike by chance. There is none where something
    cannot be compared.
    """
    parts: list[Part] = []
    last: list[Part] = []
    try:
        for call in calls:
            last = list(itertools.islice(_parts_of(call.value), MAX_PARTS + 1))
            parts += [(call.name, None), *last]
            numbers = sum(one.size for _, one in parts if one is not None)
            if len(last) > MAX_PARTS or numbers > MAX_NUMBERS:
                return ()
    except Exception:  # a value is whatever a student's code returned
        return ()
    if len(calls) >= MAX_CALLS or not (calls or raised):
        return ()
    if raised or calls[-1].value is None:
        return tuple(RAISED + one for one in _digests([*parts, ("raised", None)]))
    ends = np.concatenate([[0.0], *(one.ravel() for _, one in last if one is not None)])
    ends = ends[np.isfinite(ends)]
    kind = REAL if np.any(ends != np.round(ends)) else WHOLE
    return tuple(kind + one for one in _digests(parts))


def _digests(parts: Sequence[Part]) -> tuple[str, ...]:
    head = hashlib.blake2b(digest_size=16)
    sums, place = np.zeros(_SUMS), 0
    for kind, numbers in parts:
        head.update(b"\0" + kind.encode(errors="backslashreplace"))
        if numbers is not None and numbers.size:
            weights = _weights(1 << (place + numbers.size).bit_length())
            sums += weights[:, place : place + numbers.size] @ _soft(numbers).ravel()
            place += numbers.size
    found = []
    for cells in itertools.product(*map(_cells, (sums / CELL).tolist())):
        one = head.copy()
        one.update(repr(cells).encode())
        found.append(one.hexdigest())
    return tuple(found)


def _soft(numbers: np.ndarray) -> np.ndarray:
    soft = np.arcsinh(numbers * _SOFT)
    if np.isfinite(soft).all():
        return soft
    soft = np.where(np.isnan(numbers), _NAN, soft)
    return np.where(np.isinf(numbers), np.sign(numbers) * _INF, soft)


def _cells(place: float) -> Iterator[int]:
    own = math.floor(place)
    yield own
    if place - own < EDGE:
        yield own - 1
    elif own + 1 - place < EDGE:
        yield own + 1


@functools.cache
def _weights(size: int) -> np.ndarray:
    """Return weights of the first numbers, of shape (sums, size) and always the same.

    They stand by the number's place, so that a longer row begins like a shorter one.
    """
    place = np.arange(1, size + 1)
    roots = np.sqrt([2.0, 3.0])[:, None]
    return 0.5 + np.modf(place * roots)[0]


def _parts_of(value: object, depth: int = 0) -> Iterator[Part]:
    """Take a value apart into kinds, each with its numbers where it has some.

    Raises:
        _Unlike: it is nested too deeply, or nothing that can be compared.
    """
    if depth > MAX_DEPTH:
        raise _Unlike
    if isinstance(value, str):
        yield f"'{value[:MAX_TEXT]}'", None
    elif isinstance(value, dict):
        yield f"dict {len(value)}", None
        for key in sorted(value, key=repr):
            yield f"key {key!r}"[:MAX_TEXT], None
            yield from _parts_of(value[key], depth + 1)
    elif isinstance(value, list | tuple) and not _is_plain(value):
        yield f"row {len(value)}", None
        for item in value:
            yield from _parts_of(item, depth + 1)
    elif value is None or callable(value):
        yield "none" if value is None else "function", None
    else:
        array = np.asarray(value)
        if array.dtype.kind == "c":
            array = np.stack([array.real, array.imag])
        if array.dtype.kind not in "biuf" or array.size > MAX_NUMBERS:
            raise _Unlike
        kind = "truth" if array.dtype.kind == "b" else "number"
        yield f"{kind} {array.shape}", array.astype(float)


def _is_plain(value: list[Any] | tuple[Any, ...]) -> bool:
    """Tell whether a list is an array of numbers."""
    if not value or len(value) > MAX_NUMBERS:
        return not value
    try:
        return np.asarray(value).dtype.kind in "biuf"
    except ValueError:  # rows of different lengths
        return False
