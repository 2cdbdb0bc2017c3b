"""Digests of what functions return: equal where the values agree to about six digits.

All numbers that a test cell saw are added up with fixed weights, and the sums are rounded. A sum
beside the edge of its cell has two digests, so values that differ by rounding alone have one
in common. A digest tells nothing of the values.
"""

from __future__ import annotations

import functools
import hashlib
import itertools
import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

MAX_CALLS = 400
MAX_NUMBERS = 200_000
"""Of one test cell; what makes more calls or returns more numbers is not looked at."""
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

Part = tuple[str, np.ndarray | None]
"""The kind of a part of a value, and its numbers where it has some."""


class Unprintable(Exception):
    """A value is too large, or nothing that can be compared."""


@dataclass(frozen=True)
class Called:
    """A call of a student's function."""

    name: str
    parts: tuple[Part, ...]
    """Of what it returned."""


@dataclass
class Trace:
    """What functions returned in one test cell.

    Attributes:
        calls: in order.
        numbers: how many numbers they returned.
        broken: whether something came that cannot be compared.
        raised: whether the last call raised, or returned nothing.
    """

    calls: list[Called] = field(default_factory=list)
    numbers: int = 0
    broken: bool = False
    raised: bool = False

    @property
    def is_real(self) -> bool:
        """Tell whether the last call returned a number that is not whole."""
        last = self.calls[-1].parts if self.calls else ()
        numbers = [one[np.isfinite(one)] for _, one in last if one is not None]
        return any(bool(np.any(one != np.round(one))) for one in numbers)

    def begin(self) -> None:
        """Forget the calls of the cell before."""
        self.calls, self.numbers, self.broken, self.raised = [], 0, False, False

    def watched(self, names: Mapping[str, Any]) -> dict[str, Any]:
        """Return the same names, with functions whose values are noted here."""
        return {
            name: self._watch(name, value) if callable(value) else value
            for name, value in names.items()
        }

    def _watch(self, name: str, function: Callable[..., Any]) -> Callable[..., Any]:
        def student_function(*args: object, **kwargs: object) -> Any:  # noqa: ANN401
            try:
                value = function(*args, **kwargs)
            except Exception as error:
                self.add(name, f"! {type(error).__name__}")
                self.raised = True
                raise
            self.add(name, value)
            return value

        student_function.__name__ = student_function.__qualname__ = name
        return student_function

    def add(self, name: str, value: object) -> None:
        """Note what a function returned; whatever it is, nothing is raised."""
        self.raised = value is None
        if self.broken:
            return
        try:
            parts = tuple(itertools.islice(parts_of(value), MAX_PARTS + 1))
            self.numbers += sum(0 if one is None else one.size for _, one in parts)
            self.calls.append(Called(name, parts))
            self.broken = (
                len(parts) > MAX_PARTS or self.numbers > MAX_NUMBERS or len(self.calls) > MAX_CALLS
            )
        except Exception:  # a value is whatever a student's code returned
            self.broken = True
        if self.broken:
            self.calls.clear()


def digests(parts: Iterable[Part]) -> tuple[str, ...]:
    """Return the digest of some parts, and then those of the neighbouring cells."""
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


def parts_of(value: object, depth: int = 0) -> Iterator[Part]:
    """Take a value apart into kinds, each with its numbers where it has some.

    Raises:
        Unprintable: it is nested too deeply, or nothing that can be compared.
    """
    if depth > MAX_DEPTH:
        raise Unprintable
    if isinstance(value, str):
        yield f"'{value[:MAX_TEXT]}'", None
    elif isinstance(value, dict):
        yield f"dict {len(value)}", None
        for key in sorted(value, key=repr):
            yield f"key {key!r}"[:MAX_TEXT], None
            yield from parts_of(value[key], depth + 1)
    elif isinstance(value, list | tuple) and not _is_plain(value):
        yield f"row {len(value)}", None
        for item in value:
            yield from parts_of(item, depth + 1)
    elif value is None or callable(value):
        yield "none" if value is None else "function", None
    else:
        array = np.asarray(value)
        if array.dtype.kind == "c":
            array = np.stack([array.real, array.imag])
        if array.dtype.kind not in "biuf" or array.size > MAX_NUMBERS:
            raise Unprintable
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
