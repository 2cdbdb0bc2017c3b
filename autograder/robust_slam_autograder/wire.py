"""Plain data as bytes, and nothing but plain data back.

Numbers, strings, booleans, None, arrays, lists, tuples, dicts and callables
(as handles) cross between the trusted and the untrusted process. The bytes are
MessagePack; arrays, tuples, complex numbers and handles are its extension
types. Everything that arrives is checked before anyone sees it: the other side
may have written the bytes by hand. What a message may cost to read (items, keys,
depth, bytes) is bounded, and a sender refuses what its reader would.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NoReturn

import msgpack
import numpy as np

MAX_MESSAGE = 32 * 1024 * 1024
MAX_DEPTH = 24
MAX_ITEMS = 1_000_000
"""What one message may cost: 1 an item, and the following."""
EXTENSION_COST = 10
KEY_COST = 100
"""Keys are dear: somebody may have chosen them so that all of them collide."""
MAX_DIMENSIONS = 8
MAX_INTEGER_BYTES = 512

_ARRAY, _SCALAR, _TUPLE, _COMPLEX, _HANDLE, _INTEGER = range(1, 7)
_DTYPES = frozenset("?bBhHiIlLqQefdFD")


class WireError(Exception):
    """A value cannot cross, or bytes that arrived are not plain data; says why in one sentence."""


@dataclass(frozen=True)
class Handle:
    """A callable on the wire: whose it is ("mine" or "yours" of the sender, or "name"), which."""

    owner: str
    key: int | str


Export = Callable[[Callable[..., Any]], Handle]
Import = Callable[[Handle], Callable[..., Any]]


def encode(value: object, export: Export) -> bytes:
    """Turn plain data into bytes; ``export`` makes a handle for each callable in it.

    Raises:
        WireError: the value holds something that cannot cross, or is too large or too deep.
    """
    try:
        data = bytes(_pack(value, export, 0))
    except WireError:
        raise
    except (ValueError, TypeError, OverflowError, RecursionError, UnicodeError) as error:
        raise WireError(f"a value cannot cross: {error}") from error
    decode(data, _leave)
    return data


def _leave(handle: Handle) -> Callable[..., Any]:
    """Resolve a handle to nothing of use, for a message that is only looked over."""
    return _never


def _never() -> NoReturn:
    raise NotImplementedError


def _pack(value: object, export: Export, depth: int) -> bytes:
    if depth > MAX_DEPTH:
        raise WireError(f"a value is nested deeper than {MAX_DEPTH} levels")
    packed: bytes = msgpack.packb(
        value, strict_types=True, default=lambda item: _as_known(item, export, depth + 1)
    )
    return packed


def _as_known(item: object, export: Export, depth: int) -> object:
    """Say how MessagePack shall write what it does not know itself."""
    if isinstance(item, str):  # before arrays: numpy's own string is both
        return str(item)
    if isinstance(item, np.ndarray | np.generic):
        return _pack_array(item)
    if isinstance(item, tuple):
        return msgpack.ExtType(_TUPLE, _pack(list(item), export, depth))
    if isinstance(item, complex):
        return msgpack.ExtType(_COMPLEX, _pack([item.real, item.imag], export, depth))
    # strict_types sends subclasses here; they cross as what they extend.
    if isinstance(item, int):
        return _pack_integer(int(item))
    if isinstance(item, float):
        return float(item)
    if isinstance(item, list):
        return list(item)
    if isinstance(item, dict):
        return dict(item)
    if callable(item):
        handle = export(item)
        return msgpack.ExtType(_HANDLE, _pack([handle.owner, handle.key], export, depth))
    raise WireError(
        f"a value of type {type(item).__name__} cannot cross; "
        "numbers, strings, lists, tuples, dicts, arrays and functions can"
    )


def _pack_integer(value: int) -> object:
    if -(2**63) <= value < 2**64:
        return value
    size = value.bit_length() // 8 + 1
    if size > MAX_INTEGER_BYTES:
        raise WireError(f"an integer of more than {MAX_INTEGER_BYTES} bytes cannot cross")
    return msgpack.ExtType(_INTEGER, value.to_bytes(size, "little", signed=True))


def _pack_array(item: np.ndarray[Any, Any] | np.generic) -> object:
    array = np.asarray(item)
    if array.dtype.kind == "U":
        return array.tolist()
    if array.dtype.char in "gG":
        array = array.astype(np.complex128 if array.dtype.char == "G" else np.float64)
    if array.dtype.char not in _DTYPES:
        raise WireError(f"an array of dtype {array.dtype} cannot cross; numbers and booleans can")
    code = _SCALAR if isinstance(item, np.generic) else _ARRAY
    little = array.astype(array.dtype.newbyteorder("<"), order="C", copy=False)
    body = msgpack.packb([array.dtype.char, list(array.shape), little.tobytes()])
    return msgpack.ExtType(code, body)


def decode(data: bytes, resolve: Import) -> Any:  # noqa: ANN401
    """Turn bytes into plain data; ``resolve`` turns each handle into a callable.

    Raises:
        WireError: the bytes are not a message of plain data within the limits.
    """
    if len(data) > MAX_MESSAGE:
        raise WireError(f"a value of {len(data)} bytes is larger than {MAX_MESSAGE}")
    try:
        value = _Reader(resolve).unpack(data, 0)
        _refuse_foreign(value, 0)
    except WireError:
        raise
    except Exception as error:  # MessagePack raises many types on bytes written by hand
        raise WireError(f"bytes that are no message ({type(error).__name__})") from error
    return value


class _Reader:
    """Reads one message and counts what it costs."""

    def __init__(self, resolve: Import) -> None:
        self._resolve = resolve
        self._left = MAX_ITEMS

    def unpack(self, data: bytes, depth: int) -> Any:  # noqa: ANN401
        if depth > MAX_DEPTH:
            raise WireError(f"a message is nested deeper than {MAX_DEPTH} levels")
        # A length that the bytes cannot fill would reserve memory for nothing.
        most = min(MAX_ITEMS, len(data))
        return msgpack.unpackb(
            data,
            strict_map_key=False,
            max_array_len=most,
            max_map_len=most,
            list_hook=self._list,
            object_pairs_hook=self._dict,
            ext_hook=lambda code, body: self._extension(code, body, depth + 1),
        )

    def _pay(self, cost: int) -> None:
        self._left -= cost
        if self._left < 0:
            raise WireError("a message of too many items")

    def _list(self, items: list[Any]) -> list[Any]:
        self._pay(1 + len(items))
        return items

    def _dict(self, pairs: list[tuple[Any, Any]]) -> dict[Any, Any]:
        self._pay(1 + KEY_COST * len(pairs))
        for key, _ in pairs:
            _refuse_key(key)
        return dict(pairs)

    def _extension(self, code: int, body: bytes, depth: int) -> object:
        self._pay(EXTENSION_COST)
        if code in (_ARRAY, _SCALAR):
            array = _unpack_array(body)
            return array if code == _ARRAY else array[()]
        if code == _INTEGER and len(body) <= MAX_INTEGER_BYTES:
            return int.from_bytes(body, "little", signed=True)
        items = self.unpack(body, depth)
        if not isinstance(items, list):
            raise WireError("an extension without its list")
        if code == _TUPLE:
            return tuple(items)
        if code == _COMPLEX:
            return complex(*items)
        if code == _HANDLE:
            return self._resolve(_handle(*items))
        raise WireError(f"an unknown extension {code}")


def _handle(owner: object, key: object) -> Handle:
    if owner not in ("mine", "yours", "name") or not isinstance(key, int | str):
        raise WireError("a handle of an unknown kind")
    return Handle(str(owner), key)


def _refuse_key(key: object) -> None:
    """Refuse keys whose hashes collide at will (complex numbers), and those without a hash."""
    if isinstance(key, tuple):
        for part in key:
            _refuse_key(part)
    elif isinstance(key, np.complexfloating) or not (
        key is None or isinstance(key, str | int | float | np.generic)
    ):
        raise WireError("a dict with a key that is no number, string or tuple of them")


def _unpack_array(body: bytes) -> np.ndarray[Any, Any]:
    char, shape, raw = msgpack.unpackb(body, max_array_len=MAX_DIMENSIONS)
    if char not in _DTYPES or not isinstance(shape, list) or not isinstance(raw, bytes):
        raise WireError("an array of an unknown type")
    if any(type(n) is not int or n < 0 for n in shape):
        raise WireError("an array of an impossible shape")
    dtype = np.dtype(char).newbyteorder("<")
    if math.prod(shape) * dtype.itemsize != len(raw):
        raise WireError("an array whose bytes do not fill its shape")
    return np.frombuffer(raw, dtype=dtype).reshape(shape).astype(np.dtype(char))


def _refuse_foreign(value: object, depth: int) -> None:
    """Refuse what MessagePack can carry and we do not: bytes, timestamps, deep nesting."""
    if depth > MAX_DEPTH:
        raise WireError(f"a message is nested deeper than {MAX_DEPTH} levels")
    if isinstance(value, list | tuple):
        for item in value:
            _refuse_foreign(item, depth + 1)
    elif isinstance(value, dict):
        for key, item in value.items():
            _refuse_foreign(key, depth + 1)
            _refuse_foreign(item, depth + 1)
    elif isinstance(value, bytes | msgpack.Timestamp):
        raise WireError(f"a value of type {type(value).__name__} cannot cross")
