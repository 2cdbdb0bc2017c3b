"""Plain data of every kind, what only looks like it, and when two values are the same."""

import datetime
import struct
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import msgpack
import numpy as np
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from robust_slam_autograder.protocol import wire
from robust_slam_autograder.protocol.wire import Handle


@dataclass(frozen=True)
class Foreign:
    """Stands for a callable of the other side."""

    handle: Handle

    def __call__(self) -> None:
        """Do nothing."""


def export(function: Any) -> Handle:
    """Say a foreign callable's handle."""
    return function.handle


EDGES = [edge + step for edge in (0, 2**31, 2**53, 2**63, 2**64, 2**4090) for step in (-1, 0, 1)]
INTEGERS = st.integers(-(2**300), 2**300) | st.sampled_from(EDGES + [-edge for edge in EDGES])
BITS = st.integers(0, 2**64 - 1)
FLOATS = st.floats() | BITS.map(lambda bits: struct.unpack("<d", struct.pack("<Q", bits))[0])
"""Any double at all, with any payload that a NaN may have."""
TEXT = st.text(st.characters(exclude_categories=["Cs"]))
REAL = hnp.integer_dtypes() | hnp.unsigned_integer_dtypes() | hnp.floating_dtypes()
DTYPES = hnp.boolean_dtypes() | REAL | hnp.complex_number_dtypes(sizes=(64, 128))
LAYOUTS: list[Callable[[Any], Any]] = [
    lambda array: array,
    np.asfortranarray,
    lambda array: array.T,
    lambda array: array[..., ::-1] if array.ndim else array,
    lambda array: array[::2] if array.ndim else array,
    lambda array: np.broadcast_to(array, (2, *array.shape)),
]


def _of_raw_bytes(dtype: np.dtype[Any], shape: tuple[int, ...], seed: int) -> Any:
    size = int(np.prod(shape)) * dtype.itemsize
    if dtype.kind == "b":
        return np.random.default_rng(seed).random(shape) < 0.5
    return np.frombuffer(np.random.default_rng(seed).bytes(size), dtype).reshape(shape)


SHAPES = hnp.array_shapes(min_dims=0, max_dims=4, min_side=0, max_side=4)
ARRAYS = st.builds(
    lambda array, layout: layout(array),
    hnp.arrays(DTYPES, SHAPES) | st.builds(_of_raw_bytes, DTYPES, SHAPES, st.integers(0, 2**32)),
    st.sampled_from(LAYOUTS),
)
SCALARS = hnp.arrays(DTYPES, ()).map(lambda array: array[()])
REAL_SCALARS = SCALARS.filter(lambda scalar: scalar.dtype.kind != "c")
SIMPLE_KEYS = TEXT | INTEGERS | FLOATS | st.booleans() | st.none() | REAL_SCALARS
KEYS = SIMPLE_KEYS | st.lists(SIMPLE_KEYS, max_size=3).map(tuple)
HANDLES = st.builds(
    lambda owner, key: Foreign(Handle(owner, key)),
    st.sampled_from(["mine", "yours"]),
    st.integers(0, 2**64 - 1),
)
NUMBERS = INTEGERS | FLOATS | st.builds(complex, FLOATS, FLOATS)
LEAVES = st.none() | st.booleans() | NUMBERS | TEXT | ARRAYS | SCALARS | HANDLES


def nested(leaves: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
    """These in lists, tuples and dicts."""
    return st.recursive(
        leaves,
        lambda inner: (
            st.lists(inner, max_size=4)
            | st.lists(inner, max_size=4).map(tuple)
            | st.dictionaries(KEYS, inner, max_size=4)
        ),
        max_leaves=12,
    )


PLAIN = nested(LEAVES)
REFUSED: list[object] = [
    *(b"bytes", bytearray(b"bytes"), memoryview(b"bytes"), "half \ud800", 2**4096),
    *({1, 2}, object(), iter([1]), range(3), np),
    *(np.array([1, None], dtype=object), np.array(["2020-01-01"], dtype="datetime64[D]")),
    *(np.zeros(1, dtype=[("x", float)]), np.array([b"bytes"]), np.void(b"bytes")),
    *(np.zeros((0, 2**40)), datetime.datetime.now(datetime.UTC), msgpack.Timestamp(1)),
    *(msgpack.ExtType(1, b"bytes"), msgpack.ExtType(3, b"")),
    *({complex(1, 2): 0}, {np.complex128(1): 0}, {frozenset(): 0}, {b"bytes": 0}),
    {Foreign(Handle("mine", 1)): 0},
]
"""What no message may hold."""
STRANGE = st.sampled_from([*REFUSED, np.ma.masked])


def same(a: Any, b: Any) -> bool:
    """Whether two values are of the same types and hold the same bits.

    Arrays arrive in the machine's own byte order, and contiguous.
    """
    if isinstance(a, np.ndarray | np.generic):
        native = a.astype(a.dtype.newbyteorder("="))
        alike = type(a) is type(b) and native.dtype == b.dtype and a.shape == b.shape
        return alike and native.tobytes() == b.tobytes()
    if type(a) is not type(b):
        return False
    if isinstance(a, float):
        return struct.pack("<d", a) == struct.pack("<d", b)
    if isinstance(a, complex):
        return same([a.real, a.imag], [b.real, b.imag])
    if isinstance(a, list | tuple):
        return len(a) == len(b) and all(map(same, a, b))
    if isinstance(a, dict):
        return same(list(a.items()), list(b.items()))
    return bool(a == b)


def plain_cost(value: Any, depth: int = 0) -> int:
    """Number of values within a value; fails where one is no plain data, or nested too deeply."""
    assert depth <= wire.MAX_DEPTH
    if isinstance(value, dict):
        return 1 + plain_cost(list(value), depth) + plain_cost(list(value.values()), depth)
    if type(value) in (list, tuple):
        return 1 + sum(plain_cost(item, depth + 1) for item in value)
    if type(value) is np.ndarray:
        assert value.dtype.char in "?bBhHiIlLqQefdFD" and value.dtype.isnative
        assert value.flags.writeable and value.flags.c_contiguous
        return 1
    if type(value) is int:
        assert value.bit_length() <= 8 * wire.MAX_INTEGER_BYTES
    known = (type(None), bool, int, float, complex, str, Foreign)
    assert type(value) in known or isinstance(value, np.number | np.bool)
    return 1
