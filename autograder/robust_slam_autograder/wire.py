"""Plain data as bytes, and nothing but plain data back.

Numbers, strings, booleans, None, arrays, lists, tuples, dicts and callables
(as handles) cross between the trusted and the untrusted process. The bytes are
MessagePack; arrays, tuples, complex numbers and handles are its extension
types. Everything that arrives is checked before anyone sees it: the other side
may have written the bytes by hand.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import msgpack
import numpy as np

MAX_MESSAGE = 32 * 1024 * 1024
MAX_DEPTH = 24
MAX_ITEMS = 1_000_000
MAX_KEYS = 10_000
MAX_DIMENSIONS = 8

_ARRAY, _SCALAR, _TUPLE, _COMPLEX, _HANDLE = range(1, 6)
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
        data = msgpack.packb(value, strict_types=True, default=lambda item: _pack(item, export, 0))
    except WireError:
        raise
    except (ValueError, TypeError, OverflowError, RecursionError, UnicodeError) as error:
        raise WireError(f"a value cannot cross: {error}") from error
    if len(data) > MAX_MESSAGE:
        raise WireError(f"a value of {len(data)} bytes is larger than {MAX_MESSAGE}")
    return bytes(data)


def _pack(item: object, export: Export, depth: int) -> object:
    """Say how MessagePack shall write what it does not know itself."""
    if depth > MAX_DEPTH:
        raise WireError(f"a value is nested deeper than {MAX_DEPTH} levels")

    def pack(inner: object) -> bytes:
        nested = msgpack.packb(
            inner, strict_types=True, default=lambda it: _pack(it, export, depth + 1)
        )
        return bytes(nested)

    if isinstance(item, str):  # before arrays: numpy's own string is both
        return str(item)
    if isinstance(item, np.ndarray | np.generic):
        return _pack_array(item)
    if isinstance(item, tuple):
        return msgpack.ExtType(_TUPLE, pack(list(item)))
    if isinstance(item, complex):
        return msgpack.ExtType(_COMPLEX, pack([item.real, item.imag]))
    # strict_types sends subclasses here; they cross as what they extend.
    if isinstance(item, int):
        return int(item)
    if isinstance(item, float):
        return float(item)
    if isinstance(item, list):
        return list(item)
    if isinstance(item, dict):
        return dict(item)
    if callable(item):
        handle = export(item)
        return msgpack.ExtType(_HANDLE, pack([handle.owner, handle.key]))
    raise WireError(
        f"a value of type {type(item).__name__} cannot cross; "
        "numbers, strings, lists, tuples, dicts, arrays and functions can"
    )


def _pack_array(item: np.ndarray[Any, Any] | np.generic) -> msgpack.ExtType:
    array = np.asarray(item)
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
    try:
        value = _unpack(data, resolve, 0)
        _refuse_foreign(value, 0)
    except WireError:
        raise
    except Exception as error:  # MessagePack raises many types on bytes written by hand
        raise WireError(f"bytes that are no message ({type(error).__name__})") from error
    return value


def _unpack(data: bytes, resolve: Import, depth: int) -> Any:  # noqa: ANN401
    if depth > MAX_DEPTH:
        raise WireError(f"a message is nested deeper than {MAX_DEPTH} levels")
    return msgpack.unpackb(
        data,
        strict_map_key=False,
        max_array_len=MAX_ITEMS,
        max_map_len=MAX_KEYS,
        ext_hook=lambda code, body: _extension(code, body, resolve, depth + 1),
    )


def _extension(code: int, body: bytes, resolve: Import, depth: int) -> object:
    if code in (_ARRAY, _SCALAR):
        array = _unpack_array(body)
        return array if code == _ARRAY else array[()]
    items = _unpack(body, resolve, depth)
    if not isinstance(items, list):
        raise WireError("an extension without its list")
    if code == _TUPLE:
        return tuple(items)
    if code == _COMPLEX:
        return complex(*items)
    if code == _HANDLE:
        owner, key = items
        if owner not in ("mine", "yours", "name") or type(key) not in (int, str):
            raise WireError("a handle of an unknown kind")
        return resolve(Handle(owner, key))
    raise WireError(f"an unknown extension {code}")


def _unpack_array(body: bytes) -> np.ndarray[Any, Any]:
    char, shape, raw = msgpack.unpackb(body)
    if char not in _DTYPES or not isinstance(shape, list) or not isinstance(raw, bytes):
        raise WireError("an array of an unknown type")
    if len(shape) > MAX_DIMENSIONS or any(type(n) is not int or n < 0 for n in shape):
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
